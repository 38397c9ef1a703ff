"""A drive with fixes becomes tiles that lie where the walls are, in the campus's map frame."""

import math

import msgspec
import numpy as np
import pytest

from contract.geometry import Array, Pose2
from contract.occupancy.occupancy_map import FREE, OCCUPIED
from contract.roads.model import Origin
from vehicle_agent.localization.laser.pose_arrays import between, composed
from workshop.carmen.beams import Beams
from workshop.carmen.laser_logs import LaserLog
from workshop.cloud_mapping.gnss_fixes import Fixes
from workshop.laser_mapping.mapping import NoProgress
from workshop.laser_mapping.placement import NotPlaced
from workshop.laser_mapping.pose_graph import Edge, GraphParams, NodePlace, optimized
from workshop.laser_mapping.site_mapping import SiteMappingParams, map_site

LASER = Pose2(1.5, 0.0, 0.0)
ORIGIN = Origin(31.3, 121.4)
# A street of 8 m with recesses, which begins here and goes this way.
START = np.array([-40.0, 25.0, 0.6])
WAY_M, STEP_M = 60.0, 0.5
BEAMS = Beams(-0.75 * math.pi, math.radians(1.0), 271)


def wall_m(x: Array) -> Array:
    """Distance of the right wall from the middle of the street: recesses at unequal places."""
    return np.where((np.floor(x / 7.0) + np.floor(x / 11.0)) % 2 == 0, 4.0, 5.5)


def ranges_from(x_m: float) -> Array:
    out = np.empty(BEAMS.count)
    reach = np.arange(0.3, 28.0, 0.02)
    for number, angle in enumerate(BEAMS.angles_rad):
        x, y = x_m + reach * math.cos(angle), reach * math.sin(angle)
        hit = (y > 4.0) | (y < -wall_m(x))
        out[number] = reach[np.argmax(hit)] if hit.any() else np.nan
    return out


def street_drive(rng: np.random.Generator) -> tuple[LaserLog, Array]:
    """(log, true poses of the base (n, 3)); its odometry turns slowly and its wheels are too large."""
    along = np.arange(0.0, WAY_M, STEP_M)
    true = composed(START, np.stack([along, np.zeros_like(along), np.zeros_like(along)], axis=1))
    odometry = np.stack([1.01 * along, 0.0005 * along**2, 0.001 * along], axis=1)
    ranges_m = np.array([ranges_from(x + LASER.x_m) for x in along])
    ranges_m += 0.01 * rng.standard_normal(ranges_m.shape)
    return LaserLog(BEAMS, ranges_m, 0.2 * np.arange(len(along)), odometry, LASER, ()), true


def fixes_of(true: Array, rng: np.random.Generator, std_m: float = 0.02) -> Fixes:
    places = np.column_stack((true[:, :2] + std_m * rng.standard_normal((len(true), 2)), np.zeros(len(true))))
    stds = np.column_stack((np.full((len(true), 2), std_m), np.full(len(true), np.inf)))
    return Fixes(ORIGIN, np.arange(len(true), dtype=np.int64) * 200_000_000, places, stds, 0)


def test_a_street_lies_where_the_receiver_was() -> None:
    rng = np.random.default_rng(1)
    log, true = street_drive(rng)
    site = map_site(log, fixes_of(true, rng), SiteMappingParams(), NoProgress())
    away = between(composed(true, np.array([LASER.x_m, 0.0, 0.0])), site.poses)
    assert np.hypot(away[:, 0], away[:, 1]).max() < 0.15
    assert np.abs(away[:, 2]).max() < 0.02
    side = round(32.0 / 0.1)
    assert all(cells.shape == (side, side) for cells in site.tiles.values())
    # The left wall is 4 m beside the street's middle, 20 m from its begin; in the middle it is free.
    states = []
    for left_m in (0.0, 4.0):
        x, y, _ = composed(START, np.array([20.0, left_m, 0.0]))
        around = [
            site.tiles[math.floor((x + dx) / 32.0), math.floor((y + dy) / 32.0)][
                math.floor(((y + dy) % 32.0) / 0.1), math.floor(((x + dx) % 32.0) / 0.1)
            ]
            for dx in (-0.1, 0.0, 0.1)
            for dy in (-0.1, 0.0, 0.1)
        ]
        states.append(around)
    assert set(states[0]) == {FREE}
    assert OCCUPIED in states[1]


def test_a_drive_whose_fixes_cover_nothing_is_refused() -> None:
    rng = np.random.default_rng(1)
    log, true = street_drive(rng)
    fixes = fixes_of(true, rng, std_m=5.0)
    with pytest.raises(NotPlaced, match="do not cover"):
        map_site(log, fixes, SiteMappingParams(), NoProgress())


def test_a_few_wrong_fixes_do_not_make_a_scanner_blind() -> None:
    rng = np.random.default_rng(1)
    log, true = street_drive(rng)
    fixes = fixes_of(true, rng)
    fixes.places[::40, 0] += 1_000.0
    map_site(log, fixes, SiteMappingParams(), NoProgress())


def test_a_scanner_that_sees_its_own_vehicle_is_named() -> None:
    """Every beam ends on the vehicle's roof: by the scans it never moved."""
    rng = np.random.default_rng(1)
    log, true = street_drive(rng)
    roof_m = 1.5 + 0.01 * rng.standard_normal(log.ranges_m.shape)
    with pytest.raises(NotPlaced, match="the scanner sees its own vehicle"):
        map_site(
            msgspec.structs.replace(log, ranges_m=roof_m),
            fixes_of(true, rng),
            SiteMappingParams(),
            NoProgress(),
        )


def test_one_wrong_place_does_not_bend_a_chain() -> None:
    edges = [Edge(n, n + 1, np.array([1.0, 0.0, 0.0]), np.diag([1e4, 1e4, 1e6]), False) for n in range(30)]
    true = np.stack([np.arange(31.0) + 5.0, np.full(31, -3.0), np.zeros(31)], axis=1)
    lever = np.array([-0.5, 0.2])
    places = [NodePlace(n, lever, true[n, :2] + lever, 0.02) for n in range(0, 31, 3)]
    places[4] = NodePlace(12, lever, true[12, :2] + lever + np.array([0.0, 6.0]), 0.02)
    start = true + np.array([0.3, -0.2, 0.05])
    found = optimized(start, edges, GraphParams(), places)
    assert np.abs(found.poses - true).max() < 0.02
    assert found.weights[len(edges) + 4] < 0.05

"""Walls against the plainest possible geometry: every ray with every wall."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Array
from contract.roads.model import Building
from simulator.sensors.ray_hits import NOTHING, WALL
from simulator.sensors.walls import WallScene

COLUMNS, REACH_M = 90, 100.0
ELEVATIONS = np.radians(np.linspace(-15.0, 15.0, 16))
HOUSES = st.lists(
    st.tuples(
        st.floats(-40.0, 40.0), st.floats(-40.0, 40.0), st.floats(2.0, 12.0), st.floats(0.5, 20.0)
    ).filter(lambda house: max(abs(house[0]), abs(house[1])) > house[2] + 1.0),
    min_size=1,
    max_size=6,
)


def house(x_m: float, y_m: float, half_m: float, top_m: float) -> Building:
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    return Building(tuple((x_m + half_m * i, y_m + half_m * j) for i, j in corners), top_m)


def nearest(buildings: list[Building], height_m: float, yaw_rad: float) -> Array:
    """(rings * columns,) range to the first wall from (0, 0, height_m)."""
    azimuth = yaw_rad + 2.0 * math.pi * np.arange(COLUMNS) / COLUMNS
    cos_el, tan_el = np.cos(ELEVATIONS)[:, None], np.tan(ELEVATIONS)[:, None]
    ranges = np.full((len(ELEVATIONS), COLUMNS), REACH_M)
    dx, dy = np.cos(azimuth), np.sin(azimuth)
    for building in buildings:
        outline = building.outline
        for (ax, ay), (bx, by) in zip(outline, outline[1:] + outline[:1], strict=True):
            ex, ey = bx - ax, by - ay
            with np.errstate(all="ignore"):
                across = dx * ey - dy * ex
                level_m = (ax * ey - ay * ex) / across
                along = (ax * dy - ay * dx) / across
                met = (level_m > 0.0) & (along >= 0.0) & (along <= 1.0)
                z_m = height_m + level_m * tan_el
                reach = level_m / cos_el
                hit = met & (z_m >= 0.0) & (z_m <= building.height_m) & (reach < ranges)
                ranges = np.where(hit, reach, ranges)
    flat: Array = ranges.reshape(-1)
    return flat


@settings(max_examples=60, deadline=None)
@given(HOUSES, st.floats(-math.pi, math.pi), st.floats(0.8, 3.0))
def test_every_ray_ends_at_the_first_wall_in_its_way(
    houses: list[tuple[float, float, float, float]], yaw_rad: float, height_m: float
) -> None:
    buildings = [house(*row) for row in houses]
    ranges = np.full(len(ELEVATIONS) * COLUMNS, REACH_M, dtype=np.float32)
    kinds = np.full(len(ranges), NOTHING, dtype=np.int8)
    sensor = np.array([0.0, 0.0, height_m])
    WallScene(tuple(buildings)).shorten(
        sensor, yaw_rad, np.cos(ELEVATIONS), np.sin(ELEVATIONS), ranges, kinds
    )
    expected = nearest(buildings, height_m, yaw_rad)
    # Below the ground there is no wall; what a ray meets there is the ground's business.
    above = height_m + ranges * np.tile(np.sin(ELEVATIONS)[:, None], COLUMNS).reshape(-1) >= 0.0
    differs = (np.abs(ranges - expected) > 0.01) & above
    # Rays that graze a corner or an edge may go either way.
    assert np.count_nonzero(differs) <= 0.01 * len(ranges)
    assert np.all((kinds == WALL) == (ranges < REACH_M))

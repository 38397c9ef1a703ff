"""Everybody around the vehicle as rows in its own frame: where they are, how they move, what they cover."""

import math

import numpy as np
import pytest

from contract.geometry import Array, Pose2
from vehicle_agent.guard.road_users import (
    BRAKE,
    BRAKES_MPS2,
    RADIUS,
    SWERVE,
    SWERVES_MPS2,
    VX,
    VY,
    X,
    Y,
    are_finite,
    rows_of_fleet_vehicles,
    rows_of_points,
    rows_of_tracks,
)
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE, FleetVehicle, Tracks

S = 1_000_000_000
HERE = Pose2(100.0, 50.0, 0.5 * math.pi)
BODY = (0.85, 3.5, 0.815)


def a_track(
    x: float,
    y: float,
    kind: int = VEHICLE,
    yaw: float = 0.0,
    velocity: tuple[float, float] = (0.0, 0.0),
    size: tuple[float, float] = (4.0, 2.0),
) -> Tracks:
    return Tracks(
        S,
        np.array([1]),
        np.array([kind]),
        np.array([[x, y, yaw]]),
        np.array([velocity]),
        np.array([size]),
    )


def rows(tracks: Tracks, pose: Pose2 = HERE, now_ns: int = S, within_m: float = 20.0) -> Array:
    found: Array = rows_of_tracks(tracks, pose, now_ns, within_m)
    return found


def corners(x: float, y: float, yaw: float, length: float, width: float) -> list[tuple[float, float]]:
    cos, sin = math.cos(yaw), math.sin(yaw)
    return [
        (x + cos * a * length - sin * b * width, y + sin * a * length + cos * b * width)
        for a in (-0.5, 0.5)
        for b in (-0.5, 0.5)
    ]


def test_a_person_ahead_is_one_disc_ahead_of_a_vehicle_that_heads_north() -> None:
    (row,) = rows(a_track(100.0, 60.0, PEDESTRIAN, velocity=(1.5, 0.0), size=(0.6, 0.6)))
    assert row[[X, Y, VX, VY, RADIUS]].tolist() == pytest.approx([10.0, 0.0, 0.0, -1.5, 0.3])
    assert (row[BRAKE], row[SWERVE]) == (BRAKES_MPS2[PEDESTRIAN], SWERVES_MPS2[PEDESTRIAN])


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.0, 0.5 * math.pi])
@pytest.mark.parametrize("size", [(4.0, 2.0), (1.8, 0.6), (0.9, 0.9), (0.5, 0.4), (5.0, 0.3), (0.05, 6.0)])
def test_anybody_else_is_their_outline_with_every_corner_and_no_gap_wide_enough_for_a_bumper_corner(
    yaw: float, size: tuple[float, float]
) -> None:
    found = rows(a_track(103.0, 58.0, CYCLIST, yaw, size=size))
    assert len(found) >= 8
    for x, y in corners(8.0, -3.0, yaw - HERE.yaw_rad, *size):
        assert np.hypot(found[:, X] - x, found[:, Y] - y).min() < 1e-9
    cos, sin = math.cos(yaw - HERE.yaw_rad), math.sin(yaw - HERE.yaw_rad)
    along = cos * (found[:, X] - 8.0) + sin * (found[:, Y] + 3.0)
    across = cos * (found[:, Y] + 3.0) - sin * (found[:, X] - 8.0)
    length, width = size
    on_it = np.maximum(np.abs(along) - 0.5 * length, np.abs(across) - 0.5 * width)
    assert np.abs(on_it).max() < 1e-9
    for there, other, side in ((along, across, width), (across, along, length)):
        for sign in (1.0, -1.0):
            edge = np.sort(there[np.abs(other - sign * 0.5 * side) < 1e-9])
            assert np.diff(edge).max() < 0.65
    assert (found[:, RADIUS] == 0.0).all()


@pytest.mark.parametrize(("late_s", "moved_m"), [(0.0, 0.0), (0.4, 0.8), (1.0, 2.0), (9.0, 2.0), (-1.0, 0.0)])
def test_a_track_is_carried_from_when_it_was_seen_for_a_second_at_most(late_s: float, moved_m: float) -> None:
    walks = a_track(100.0, 60.0, PEDESTRIAN, velocity=(0.0, 2.0), size=(0.5, 0.5))
    (row,) = rows(walks, now_ns=S + round(late_s * S))
    assert row[X] == pytest.approx(10.0 + moved_m)


def test_only_who_is_within_reach_counts_with_half_of_a_long_vehicle_inside() -> None:
    assert len(rows(a_track(100.0, 50.0 + 20.4, PEDESTRIAN, size=(0.5, 0.5)))) == 1
    assert len(rows(a_track(100.0, 50.0 + 20.6, PEDESTRIAN, size=(0.5, 0.5)))) == 0
    assert len(rows(a_track(100.0 - 23.9, 50.0, size=(4.0, 2.0)))) > 0
    assert len(rows(a_track(100.0 - 24.1, 50.0, size=(4.0, 2.0)))) == 0


def test_an_unknown_kind_is_as_quick_as_the_last_one_known() -> None:
    assert rows(a_track(105.0, 50.0, 9))[0, BRAKE] == BRAKES_MPS2[3]


def test_obstacle_cells_stand_where_they_are_and_those_out_of_reach_are_left_out() -> None:
    cells = np.array([[100.0, 60.0], [110.0, 50.0], [100.0, 70.1], [121.0, 50.0]])
    found = rows_of_points(cells, HERE, 20.0)
    assert found[:, :2].tolist() == [pytest.approx([10.0, 0.0]), pytest.approx([0.0, -10.0])]
    assert not found[:, 2:].any()
    assert rows_of_points(np.empty((0, 2)), HERE, 20.0).shape == (0, 7)


def test_a_mate_has_our_own_body_where_it_is_by_now() -> None:
    mate = FleetVehicle(S, "b", Pose2(100.0, 60.0, 0.0), 2.0)
    found = rows_of_fleet_vehicles((mate,), HERE, S + S // 2, BODY)
    # Rear axle at 101 m to the east by now; the middle of the outline 1.325 m farther.
    for x, y in corners(10.0, -(1.0 + 1.325), -HERE.yaw_rad, 4.35, 1.63):
        assert np.hypot(found[:, X] - x, found[:, Y] - y).min() < 1e-9
    assert found[0, [VX, VY]].tolist() == pytest.approx([0.0, -2.0])
    assert found[0, BRAKE] == BRAKES_MPS2[VEHICLE]
    assert len(rows_of_fleet_vehicles((), HERE, S, BODY)) == 0


@pytest.mark.parametrize("part", ["poses_map", "velocities_map_mps", "sizes_m"])
def test_a_track_with_anything_that_is_no_number_is_noticed(part: str) -> None:
    tracks = a_track(1.0, 2.0)
    assert are_finite(tracks)
    getattr(tracks, part)[0, 1] = math.nan
    assert not are_finite(tracks)

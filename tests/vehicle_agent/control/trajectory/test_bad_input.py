"""What the Snow Lion control does with poses and trajectories that cannot be: gently to a stop, and on
again."""

import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from contract.geometry import Array, Pose2
from tests.vehicle_agent.control.trajectory.shuttle_drive import (
    Change,
    driven,
    rows_on,
    said,
    straight,
    within_limits,
)
from vehicle_agent.control.trajectory.timed_path import (
    FAULTS,
    at_length,
    at_time,
    fault_number,
    lengths,
    nearest,
)
from vehicle_agent.signals import Ego, Path, Trajectory

FROM, TO = 400, 700
ROWS = rows_on(straight(40.0))


def moved(pose: Callable[[Pose2], Pose2]) -> Change:
    def change(tick: int, ego: Ego, path: Path) -> tuple[Ego, Path]:
        told = pose(ego.pose_map) if FROM < tick < TO else ego.pose_map
        return msgspec.structs.replace(ego, pose_map=told), path

    return change


def replanned(rows: Callable[[Array], Array]) -> Change:
    def change(tick: int, ego: Ego, path: Path) -> tuple[Ego, Path]:
        assert path.trajectory is not None
        if not FROM < tick < TO:
            return ego, path
        told = Trajectory(path.trajectory.stamp_ns, rows(path.trajectory.rows.copy()))
        return ego, msgspec.structs.replace(path, trajectory=told)

    return change


def spoilt(row: int, column: int, value: float) -> Callable[[Array], Array]:
    def spoil(rows: Array) -> Array:
        rows[row, column] = value
        return rows

    return spoil


BAD: dict[str, Change] = {
    "pose not a number": moved(lambda pose: Pose2(math.nan, pose.y_m, pose.yaw_rad)),
    "heading infinite": moved(lambda pose: Pose2(pose.x_m, pose.y_m, math.inf)),
    "pose jumped 30 m": moved(lambda pose: Pose2(pose.x_m, pose.y_m + 30.0, pose.yaw_rad)),
    "facing backwards": moved(lambda pose: Pose2(pose.x_m, pose.y_m, pose.yaw_rad + math.pi)),
    "trajectory not a number": replanned(spoilt(5, 1, math.nan)),
    "times fall": replanned(spoilt(5, 0, -1.0)),
    "speed absurd": replanned(spoilt(5, 5, 400.0)),
    "no rows": replanned(lambda rows: rows[:0]),
    "one row": replanned(lambda rows: rows[:1]),
    "far from the vehicle": replanned(lambda rows: rows + np.array((0, 0, 50.0, 0, 0, 0, 0, 0))),
    "across the vehicle's way": replanned(lambda rows: rows + np.array((0, 0, 0, 1.5, 0, 0, 0, 0))),
}


@pytest.mark.parametrize("change", BAD.values(), ids=BAD)
def test_it_stops_comfortably_within_its_limits(change: Change) -> None:
    run = driven(ROWS, change, seed=None)
    trace = run.drive.trace
    assert within_limits(run)
    assert np.abs(said(run, "path_fault")[FROM + 60 : TO - 1]).min() > 0.0
    assert trace[TO - 1, 4] == 0.0
    assert trace[FROM:TO, 5].min() > -1.3
    # Straight on is where it was going: it must not have left the lane meanwhile.
    assert np.abs(trace[:TO, 2]).max() < 0.2


def test_a_pose_that_is_gone_for_a_moment_is_driven_through() -> None:
    def change(tick: int, ego: Ego, path: Path) -> tuple[Ego, Path]:
        blind = FROM < tick < FROM + 20
        return msgspec.structs.replace(ego, valid=not blind), path

    run = driven(ROWS, change)
    assert said(run, "path_fault").max() == 0.0 or np.all(said(run, "path_fault")[100:] == 0.0)
    assert np.abs(run.drive.trace[:, 2]).max() < 0.03


def test_a_trajectory_that_ran_out_in_motion_ends_in_a_comfortable_stop() -> None:
    rows = ROWS[:60]
    run = driven(rows, seed=None, settle_s=8.0)
    assert rows[-1, 5] > 2.0
    assert run.drive.trace[-1, 4] == 0.0
    assert run.drive.trace[:, 5].min() > -1.3
    assert np.abs(run.drive.trace[:, 2]).max() < 0.1


def test_after_a_bad_spell_it_drives_on_when_it_is_planned_for_anew() -> None:
    onward = rows_on(straight(20.0))
    new: list[Trajectory] = []

    def change(tick: int, ego: Ego, path: Path) -> tuple[Ego, Path]:
        assert path.trajectory is not None
        told = path.trajectory
        if tick > 450 and not new:
            shifted = onward.copy()
            shifted[:, 1] += ego.pose_map.x_m
            new.append(Trajectory(ego.stamp_ns, shifted))
        if tick > 200:
            told = new[0] if new else Trajectory(told.stamp_ns, told.rows * math.nan)
        return ego, msgspec.structs.replace(path, trajectory=told)

    run = driven(ROWS, change, seed=None, settle_s=8.0)
    assert run.drive.trace[440, 4] == 0.0
    assert run.drive.trace[-1, 4] == 0.0
    assert run.drive.trace[-1, 1] == pytest.approx(new[0].rows[-1, 1], abs=0.05)


@pytest.mark.parametrize(
    ("spoil", "fault"),
    [
        (spoilt(3, 2, math.inf), "not finite"),
        (spoilt(3, 0, 0.0), "times do not rise"),
        (spoilt(3, 5, -2.0), "speed out of reason"),
        (spoilt(3, 4, 9.0), "speed out of reason"),
        (spoilt(3, 1, 90.0), "it jumps"),
        (lambda rows: rows[:1], "too few rows"),
        (lambda rows: rows, ""),
    ],
)
def test_what_is_wrong_with_rows_is_named(spoil: Callable[[Array], Array], fault: str) -> None:
    assert FAULTS[fault_number(np.ascontiguousarray(spoil(ROWS.copy())))] == fault


def test_places_on_a_circle_are_exact_between_its_rows() -> None:
    radius, n = 10.0, 20
    angle = np.linspace(0.0, 1.5, n)
    rows = np.zeros((n, 8))
    rows[:, 0], rows[:, 5], rows[:, 3], rows[:, 4] = angle * radius / 2.0, 2.0, angle, 1.0 / radius
    rows[:, 1], rows[:, 2] = radius * np.sin(angle), radius * (1.0 - np.cos(angle))
    s = lengths(rows)
    assert s[-1] == pytest.approx(15.0, abs=1e-4)
    for a in np.linspace(0.05, 1.45, 31):
        place, offset = nearest(rows, s, 10.2 * math.sin(a), 10.0 - 10.2 * math.cos(a), 7.5, 20.0)
        assert offset == pytest.approx(-0.2, abs=1e-3)
        assert place == pytest.approx(10.0 * a, abs=0.01)
        assert at_length(rows, s, 10.0 * a)[0] == pytest.approx(a, abs=1e-6)
        assert at_time(rows, s, 5.0 * a, 0.8)[0] == pytest.approx(10.0 * a, abs=1e-3)


@pytest.mark.parametrize("last_m", [-1e-5, 1e-5, -1e-7, 0.0])
@pytest.mark.parametrize("left_m", [2.0, 0.7, 0.1, -0.3])
def test_a_stop_whose_last_rows_point_backwards_still_lies_ahead(last_m: float, left_m: float) -> None:
    """An optimizer leaves steps of micrometres in any direction where the vehicle is to stand."""
    rows = np.zeros((42, 8))
    rows[:, 0] = 0.1 * np.arange(42)
    rows[:40, 1] = np.linspace(0.0, 10.0, 40)
    rows[40:, 1] = 10.0 + last_m * np.arange(1, 3)
    s = lengths(rows)
    place, offset = nearest(rows, s, 10.0 - left_m, 0.05, 10.0, 5.0)
    assert place == pytest.approx(10.0 - left_m, abs=1e-3)
    assert offset == pytest.approx(0.05, abs=1e-3)

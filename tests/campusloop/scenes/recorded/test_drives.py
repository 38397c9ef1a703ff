import numpy as np
import pytest

from campusloop.scenes.recorded.drives import RecordedDrive, rear_axle_path, recorded_drives
from contract.geometry import Array
from simulator.traffic.recordings import CAR_LENGTH_M, CAR_WIDTH_M, RecordedTrack
from simulator.traffic.track_repairs import velocities_mps
from vehicle_agent.config import Body
from vehicle_agent.signals import VEHICLE

_DT_S = 1.0 / 24.0
NOISE_M = 0.03


def a_car(speeds_mps: Array, facing_rad: float = 0.0, noise_m: float = NOISE_M) -> RecordedTrack:
    """A car on the x axis with these signed speeds, and a tracker that trembles."""
    rng = np.random.default_rng(1)
    times = _DT_S * np.arange(len(speeds_mps))
    x = np.cumsum(speeds_mps) * _DT_S
    places = np.column_stack((x, np.zeros_like(x))) + rng.normal(0.0, noise_m, (len(x), 2))
    yaw = facing_rad + rng.normal(0.0, 0.01, len(x))
    states = np.column_stack((places, yaw, velocities_mps(times, places, 1.0)))
    return RecordedTrack(100_000, VEHICLE, times, states, (CAR_LENGTH_M, CAR_WIDTH_M))


def speeds(*parts: tuple[float, float]) -> Array:
    """(speed_mps, seconds) one after the other."""
    return np.concatenate([np.full(round(seconds / _DT_S), speed) for speed, seconds in parts])


def greatest_turn_rad(drive: RecordedDrive) -> float:
    steps = np.diff(rear_axle_path(drive, Body()), axis=0)
    return float(np.abs(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])))).max())


def test_a_car_that_stands_and_trembles_is_one_drive_with_a_stand_in_it() -> None:
    drives = recorded_drives(a_car(speeds((2.0, 5.0), (0.0, 8.0), (2.0, 5.0))))
    assert len(drives) == 1
    assert drives[0].time_s == pytest.approx(18.0, abs=0.1)
    assert drives[0].length_m == pytest.approx(20.0, abs=0.3)


def test_the_path_of_a_car_that_trembles_does_not_fold() -> None:
    drive = recorded_drives(a_car(speeds((2.0, 5.0), (0.0, 8.0), (2.0, 5.0))))[0]
    assert greatest_turn_rad(drive) < 0.2


def test_a_drive_ends_when_the_car_arrives_and_not_when_the_recording_ends() -> None:
    drive = recorded_drives(a_car(speeds((2.0, 6.0), (0.0, 4.0))))[0]
    assert drive.time_s == pytest.approx(6.0, abs=0.5)


def test_a_stand_at_the_beginning_belongs_to_the_drive() -> None:
    drive = recorded_drives(a_car(speeds((0.0, 3.0), (2.0, 6.0))))[0]
    assert drive.time_s == pytest.approx(9.0, abs=0.1)


def test_a_parked_car_that_trembles_is_no_drive() -> None:
    assert not recorded_drives(a_car(speeds((0.0, 20.0))))


def test_a_car_that_backs_in_between_makes_two_drives() -> None:
    drives = recorded_drives(a_car(speeds((2.0, 4.0), (-1.0, 3.0), (2.0, 4.0))))
    assert [round(drive.length_m) for drive in drives] == [8, 8]
    assert drives[1].car.times_s[0] == pytest.approx(7.0, abs=0.3)


def test_a_car_that_only_backs_is_driven_in_its_direction_of_motion() -> None:
    drives = recorded_drives(a_car(speeds((2.0, 6.0)), facing_rad=np.pi))
    assert len(drives) == 1
    path = rear_axle_path(drives[0], Body())
    assert path[-1, 0] - path[0, 0] == pytest.approx(12.0, abs=0.3)


def test_a_fast_car_that_was_seen_three_times_has_a_path() -> None:
    times = np.array((0.0, 0.4, 0.8))
    states = np.column_stack((8.0 * times, 0.0 * times, 0.0 * times, 8.0 + 0.0 * times, 0.0 * times))
    drives = recorded_drives(RecordedTrack(100_000, VEHICLE, times, states, (CAR_LENGTH_M, CAR_WIDTH_M)))
    path = rear_axle_path(drives[0], Body())
    assert path[-1, 0] - path[0, 0] == pytest.approx(6.4, abs=0.01)


def test_a_short_manoeuvre_is_no_drive() -> None:
    assert not recorded_drives(a_car(speeds((1.0, 2.0))))

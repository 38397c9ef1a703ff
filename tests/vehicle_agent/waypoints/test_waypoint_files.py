"""Recording waypoints and their files."""

import math
from pathlib import Path

import numpy as np
import pytest

from contract.geometry import Pose2
from contract.roads.model import Origin
from vehicle_agent.planning.waypoint.waypoints import WaypointRules
from vehicle_agent.signals import Ego
from vehicle_agent.waypoints.files import WaypointFileError, read_waypoints, write_recording
from vehicle_agent.waypoints.recorder import WaypointRecorder, turn_radius_m

ORIGIN = Origin(31.3, 121.4)


def a_recorder(turn_radps: float = 0.0) -> WaypointRecorder:
    recorder = WaypointRecorder()
    for k in range(1, 501):
        pose = Pose2(0.04 * k, 0.0, 0.0)
        recorder.observe(Ego(k, pose, 2.0, 0.0, turn_radps, 0.0, 0.02, k, True))
    return recorder


def test_a_waypoint_is_kept_every_metre() -> None:
    xs = np.array([waypoint.x_m for waypoint in a_recorder().waypoints])
    assert np.all(np.abs(np.diff(xs) - 1.0) < 0.041)


def test_a_position_that_is_not_valid_is_not_recorded() -> None:
    recorder = WaypointRecorder()
    recorder.observe(Ego(1, Pose2(0, 0, 0), 2.0, 0.0, 0.0, 0.0, math.inf, 0, False))
    assert recorder.waypoints == []


def test_the_radius_is_speed_over_turn_rate_and_infinite_on_a_straight() -> None:
    assert turn_radius_m(2.0, -0.1) == pytest.approx(20.0)
    assert turn_radius_m(2.0, 0.0) == math.inf


def test_one_file_for_each_speed_with_curve_speeds(tmp_path: Path) -> None:
    files = write_recording(tmp_path, "loop", a_recorder(turn_radps=0.2).waypoints, ORIGIN, [1.5, 3.0])
    assert [file.name for file in files] == ["loop-1.5mps.csv", "loop-3.0mps.csv"]
    slow, fast = (read_waypoints(file, ORIGIN, WaypointRules(3.0)) for file in files)
    assert np.allclose(slow.speeds_mps, 1.5)
    assert np.allclose(fast.speeds_mps, math.sqrt(0.5 * 10.0), atol=1e-3)


def test_what_is_read_is_what_was_driven(tmp_path: Path) -> None:
    recorded = a_recorder().waypoints
    (file,) = write_recording(tmp_path, "loop", recorded, ORIGIN, [3.0])
    points = read_waypoints(file, ORIGIN, WaypointRules(3.0)).points_map
    assert np.allclose(points, [(w.x_m, w.y_m) for w in recorded], atol=1e-3)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("latitude_deg,longitude_deg,speed_mps\n31,121,abc\n", ":2:"),
        ("31,121,2\n31,121\n", ":2:"),
        ("31,121,2\n131,121,2\n", "no place"),
        ("31,121,2\n", "three"),
        ("", "three"),
    ],
)
def test_a_broken_file_is_refused_with_the_line(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "broken.csv"
    file.write_text(text)
    with pytest.raises(WaypointFileError, match=says):
        read_waypoints(file, ORIGIN, WaypointRules())


def test_a_missing_file_is_an_error_that_names_it(tmp_path: Path) -> None:
    with pytest.raises(WaypointFileError, match=r"nowhere\.csv"):
        read_waypoints(tmp_path / "nowhere.csv", ORIGIN, WaypointRules())

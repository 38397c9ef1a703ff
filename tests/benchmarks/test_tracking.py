"""The tracking benchmark keeps the paper's figure, and reads recordings that others bring."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.tracking.reference_paths import PathFileError, lemniscate, recorded_path
from benchmarks.tracking.scan_sensing import ScannedCurve
from benchmarks.tracking.stop_and_go import judged, stop_and_go_rows
from contract.geometry import Pose2, curvatures, resample, wrap_angle
from simulator.sensors.gnss import GnssNoise
from simulator.vehicle.plant import PlantView
from vehicle_agent.config import load_profile
from vehicle_agent.signals import VehicleMotion

ROOT = Path(__file__).resolve().parents[2]
SHARED = Path(os.environ.get("CAMPUSLOOP_SHARED", ROOT.parent / "shared"))


def test_the_lemniscates_least_radius_is_what_was_asked_for() -> None:
    path = lemniscate(18.0, 1)
    kappa = curvatures(resample(path.points, 0.5))
    assert 1.0 / np.abs(kappa).max() == pytest.approx(18.0, rel=0.01)
    assert path.length_m == pytest.approx(5.2441151 * 54.0, rel=1e-4)


def test_cross_track_is_measured_against_the_curve_even_where_it_crosses_itself() -> None:
    path = lemniscate(18.0, 2)
    beside = path.points[::50] + np.array([0.0, 0.05])
    errors = path.cross_track_m(beside)
    assert np.abs(errors).max() <= 0.05 + 1e-9
    assert np.abs(path.cross_track_m(path.points[::50])).max() < 1e-9


def test_a_set_off_that_leaps_and_a_stop_that_overruns_are_seen() -> None:
    rows = stop_and_go_rows(seed=3, stops=6)
    t = np.arange(-2.0, rows[-1, 0], 0.02)
    trace = np.zeros((len(t), 7))
    trace[:, 0] = t
    trace[:, 1], trace[:, 4] = np.interp(t, rows[:, 0], rows[:, 7]), np.interp(t, rows[:, 0], rows[:, 5])
    faster, beyond, ahead_m = judged(trace, rows)
    assert len(faster) == len(beyond) == 6
    assert max(faster.max(), beyond.max(), ahead_m) < 1e-9
    trace[:, 4] += np.where(trace[:, 4] > 0.05, 0.2, 0.0)
    trace[t > 0.5 * t[-1], 1] += 0.1
    faster, beyond, ahead_m = judged(trace, rows)
    assert faster == pytest.approx(np.full(6, 0.2), abs=0.01)
    assert beyond[-1] == pytest.approx(0.1)
    assert beyond[0] == pytest.approx(0.0, abs=1e-9)
    assert ahead_m == pytest.approx(0.1)


@pytest.mark.long
@pytest.mark.parametrize("stack", ["nus", "snow_lion"])
def test_scans_say_where_on_a_curve_a_vehicle_is_once_gnss_is_silent(stack: str) -> None:
    profile = load_profile(ROOT / "vehicle_agent" / "profiles" / "campus-shuttle.toml")
    scanned = ScannedCurve(lemniscate(6.0, 1), profile, [stack])
    path, speed_mps = scanned.path, 1.5
    sense = scanned.sensing(stack, profile, GnssNoise(), 1, silent_ticks=500)
    turn_rad = np.unwrap(np.arctan2(np.gradient(path.points[:, 1]), np.gradient(path.points[:, 0])))
    errors_m = []
    for tick in range(1, round(path.length_m / speed_mps * 50)):
        s_m, now_ns = speed_mps * tick / 50, tick * 20_000_000
        x_m, y_m, yaw_rad = (np.interp(s_m, path.s, c) for c in (*path.points.T, turn_rad))
        after_rad = np.interp(s_m + 0.02 * speed_mps, path.s, turn_rad)
        truth = PlantView(
            Pose2(float(x_m), float(y_m), wrap_angle(float(yaw_rad))), speed_mps, 0.0, 0.0, 0.0, 0.0,
            50.0 * float(after_rad - yaw_rad), s_m, 1.0,
        )  # fmt: skip
        motion = VehicleMotion(now_ns, speed_mps, 0.0, 0.0, 0.0, True, False, True, 1.0)
        ego = sense(now_ns, truth, motion)
        assert ego.valid
        if tick > 600:
            errors_m.append(math.hypot(ego.pose_map.x_m - x_m, ego.pose_map.y_m - y_m))
    assert len(errors_m) > 2000
    assert max(errors_m) < 0.3
    assert math.sqrt(float(np.mean(np.square(errors_m)))) < 0.1


@pytest.mark.long
@pytest.mark.parametrize("stack", ["gem", "nus", "snow_lion"])
def test_two_laps_stay_within_the_papers_twelve_centimetres(tmp_path: Path, stack: str) -> None:
    report = tmp_path / "tracking.json"
    subprocess.run(
        [
            *(sys.executable, "-m", "benchmarks.tracking", "--seeds", "1", "--plants", "1"),
            *("--stacks", stack, "--json", report, "--traces", tmp_path),
        ],
        cwd=ROOT,
        check=True,
        capture_output=True,
    )
    found = json.loads(report.read_text())
    assert set(found) == {"name", "machine", "commit", "arguments", "rows", "summary"}
    if stack == "gem":
        assert found["summary"]["gem.peak_cross_track_m"] < 0.06
        assert found["summary"]["gem.unknown_vehicle_peak_cross_track_m"] < 0.06
    assert all(row["finished"] for row in found["rows"])
    trace = next(tmp_path.glob("*ours*.csv")).read_text().splitlines()
    assert trace[0] == "t_s,x_m,y_m,yaw_rad,v_mps,a_mps2,steer_rad"
    assert len(trace) > 9000


def test_a_recorded_loop_is_thinned_to_a_metre_and_its_standing_left_out() -> None:
    file = SHARED / "data" / "waypoints" / "gem_e2_loop.csv"
    if not file.exists():
        pytest.skip(
            "the recorded loop is not here; set CAMPUSLOOP_SHARED to the folder that has data/waypoints"
        )
    path = recorded_path(file)
    assert path.length_m == pytest.approx(182.0, abs=4.0)
    assert np.all(np.hypot(*np.diff(path.points, axis=0).T) < 0.03)


@pytest.mark.parametrize("text", ["", "a,b,c\n", "1.0\n", "0,0\n0,0\n", "nan,1\n"])
def test_what_is_no_recording_is_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "broken.csv"
    file.write_text(text)
    with pytest.raises(PathFileError, match=r"broken\.csv"):
        recorded_path(file)

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from simulator.traffic.recordings import (
    DRONE_FPS,
    Clip,
    RecordingError,
    drone_clips,
    pavement_clip,
)
from simulator.traffic.replayed import ReplayedTraffic
from vehicle_agent.signals import PEDESTRIAN, VEHICLE

PED = "id,frame,label,x_est,y_est,vx_est,vy_est\n"
VEH = "id,frame,label,x_est,y_est,psi_est,vel_est\n"


def a_folder(tmp_path: Path, ped: str, veh: str) -> Path:
    (tmp_path / "square_01_traj_ped_filtered.csv").write_text(PED + ped)
    (tmp_path / "square_01_traj_veh_filtered.csv").write_text(VEH + veh)
    return tmp_path


def a_clip(tmp_path: Path) -> Clip:
    ped = "".join(f"3,{k},ped,{0.05 * k},2.0,1.2,0.0\n" for k in range(1, 241))
    ped += "".join(f"4,{k},ped,9.0,{0.05 * k},0.0,1.2\n" for k in range(1, 100))
    veh = "".join(f"0,{k},veh,5.0,{0.1 * k},1.5707963,2.4\n" for k in range(1, 241))
    return drone_clips(a_folder(tmp_path, ped, veh))[0]


def test_a_clip_is_read_with_its_people_and_cars(tmp_path: Path) -> None:
    clip = a_clip(tmp_path)
    assert [track.kind for track in clip.tracks] == [PEDESTRIAN, PEDESTRIAN, VEHICLE]
    car = clip.cars()[0]
    assert car.mean_speed_mps == pytest.approx(0.1 * DRONE_FPS, rel=1e-6)
    assert car.states[0, 3:] == pytest.approx((0.0, 2.4), abs=1e-6)


@pytest.mark.parametrize("bad", ["3,1,ped,abc,2.0,1.2,0.0\n", "3,1,ped,nan,2.0,1.2,0.0\n", "3,1\n"])
def test_a_damaged_row_is_named_by_file_and_line(tmp_path: Path, bad: str) -> None:
    with pytest.raises(RecordingError, match=r"ped_filtered\.csv, line 2"):
        drone_clips(a_folder(tmp_path, bad, ""))


def test_a_folder_without_recordings_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="drone recordings"):
        drone_clips(tmp_path)


def test_people_are_where_they_were_recorded_between_frames_too(tmp_path: Path) -> None:
    traffic = ReplayedTraffic(a_clip(tmp_path), 1.0)
    bodies = traffic.bodies()
    expected_m = 0.05 * DRONE_FPS * 1.0
    assert bodies.poses_map[0, 0] == pytest.approx(expected_m, abs=1e-6)
    for _ in range(50):
        traffic.step(np.empty((0, 7)), np.empty(0), np.empty((0, 1, 2)), 0.02)
    assert traffic.bodies().poses_map[0, 0] == pytest.approx(2.0 * expected_m, abs=1e-6)


def test_who_left_the_picture_is_gone_and_who_did_not_walks_on(tmp_path: Path) -> None:
    traffic = ReplayedTraffic(a_clip(tmp_path), 240 / DRONE_FPS + 2.0, without=frozenset({100_000}))
    bodies = traffic.bodies()
    assert bodies.numbers.tolist() == [3]
    assert bodies.poses_map[0, 0] == pytest.approx(12.0 + 2.0 * 1.2, abs=0.01)


@pytest.mark.parametrize(("away_m", "there"), [(5.0, 0), (20.0, 1)])
def test_nobody_appears_out_of_nothing_before_a_bumper(tmp_path: Path, away_m: float, there: int) -> None:
    clip = a_clip(tmp_path)
    late = tuple(replace(track, times_s=track.times_s + 1.0) for track in clip.tracks if track.number == 3)
    clip = replace(clip, tracks=late)
    traffic = ReplayedTraffic(clip, 0.0, appear_m=15.0)
    x, y = late[0].states[0, :2]
    vehicle = np.zeros((1, 7))
    vehicle[0, :2] = x + away_m, y
    for _ in range(75):
        traffic.step(vehicle, np.zeros(1), np.empty((1, 1, 2)), 0.02)
    assert len(traffic.bodies().numbers) == there


def test_a_pavement_recording_has_two_and_a_half_looks_a_second(tmp_path: Path) -> None:
    path = tmp_path / "obsmat.txt"
    path.write_text("".join(f"{10 * k} 1 {0.4 * k} 0 2 1.0 0 0\n" for k in range(5)))
    track = pavement_clip(path).tracks[0]
    assert np.diff(track.times_s) == pytest.approx([0.4] * 4)
    path.write_text("1 2 3\n")
    with pytest.raises(RecordingError, match="expected rows"):
        pavement_clip(path)

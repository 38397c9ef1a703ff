from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from simulator.traffic.recordings import (
    Clip,
    RecordingError,
    drone_clips,
    pavement_clip,
)
from simulator.traffic.replayed import ReplayedTraffic
from vehicle_agent.signals import PEDESTRIAN, VEHICLE

FPS = 24.0 / 1.001
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
    assert car.mean_speed_mps == pytest.approx(0.1 * FPS, rel=1e-6)
    assert clip.fps == FPS


def test_a_car_has_the_velocity_of_its_positions_and_not_the_lagging_estimate(tmp_path: Path) -> None:
    ped = "".join(f"3,{k},ped,{1.2 * k / FPS},2.0,1.2,0.0\n" for k in range(1, 100))
    veh = "".join(f"0,{k},veh,5.0,{4.0 * k / FPS},1.5707963,1.1\n" for k in range(1, 100))
    car = drone_clips(a_folder(tmp_path, ped, veh))[0].cars()[0]
    assert car.states[:, 4] == pytest.approx(4.0, abs=1e-6)


def test_a_person_has_the_velocity_of_their_positions_and_not_the_lagging_estimate(tmp_path: Path) -> None:
    """They walk for 2 s at 1.2 m/s and stand from then on; the file's estimate notices 0.25 s later."""
    stops, late = round(2.0 * FPS), round(0.25 * FPS)
    ped = "".join(
        f"3,{k},ped,{1.2 * min(k, stops) / FPS},2.0,{1.2 if k < stops + late else 0.0},0.0\n"
        for k in range(1, 100)
    )
    ped += "".join(f"4,{k},ped,9.0,{1.2 * k / FPS},0.0,1.2\n" for k in range(1, 100))
    person = drone_clips(a_folder(tmp_path, ped, ""))[0].tracks[0]
    walks, stands = person.times_s < (stops - 7) / FPS, person.times_s > (stops + 7) / FPS
    assert person.states[walks, 3] == pytest.approx(1.2, abs=1e-6)
    assert person.states[stands, 3] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("bad", ["3,1,ped,abc,2.0,1.2,0.0\n", "3,1,ped,nan,2.0,1.2,0.0\n", "3,1\n"])
def test_a_damaged_row_is_named_by_file_and_line(tmp_path: Path, bad: str) -> None:
    with pytest.raises(RecordingError, match=r"ped_filtered\.csv, line 2"):
        drone_clips(a_folder(tmp_path, bad, ""))


def walkers(frames: list[int], jump_m: float = 0.0, jumps: tuple[int, ...] = ()) -> str:
    """One person who walks at 1.2 m/s; in the frames of `jumps` they are elsewhere."""
    rows = ((k, 1.2 * k / FPS + (jump_m if k in jumps else 0.0)) for k in frames)
    return "".join(f"3,{k},ped,{x},2.0,1.2,0.0\n" for k, x in rows)


def test_one_id_twice_in_a_frame_is_named_by_file_and_line(tmp_path: Path) -> None:
    ped = walkers([*range(1, 80)]) + "3,40,ped,9.0,9.0,1.2,0.0\n"
    with pytest.raises(RecordingError, match=r"ped_filtered\.csv, line 81: id 3 is twice in frame 40"):
        drone_clips(a_folder(tmp_path, ped, ""))


def test_a_file_without_its_columns_is_refused(tmp_path: Path) -> None:
    (tmp_path / "square_01_traj_ped_filtered.csv").write_text("id,frame\n3,1\n")
    with pytest.raises(RecordingError, match=r"line 2: KeyError\('x_est'\)"):
        drone_clips(tmp_path)


def test_bytes_that_are_no_text_are_refused(tmp_path: Path) -> None:
    (tmp_path / "square_01_traj_ped_filtered.csv").write_bytes(b"id,frame\n\xff\xfe\n")
    with pytest.raises(RecordingError, match=r"ped_filtered\.csv"):
        drone_clips(tmp_path)


def test_a_gap_of_less_than_a_second_is_bridged(tmp_path: Path) -> None:
    clip = drone_clips(a_folder(tmp_path, walkers([*range(1, 60), *range(75, 140)]), ""))[0]
    assert (len(clip.tracks), clip.repairs.bridged_gaps, clip.repairs.cuts) == (1, 1, 0)
    between = ReplayedTraffic(clip, 67 / FPS).bodies()
    assert between.poses_map[0, 0] == pytest.approx(1.2 * 67 / FPS, abs=1e-6)


def test_a_longer_gap_makes_two_people_of_one(tmp_path: Path) -> None:
    clip = drone_clips(a_folder(tmp_path, walkers([*range(1, 60), *range(120, 180)]), ""))[0]
    assert [(track.number, track.recorded_id) for track in clip.tracks] == [(3, 3), (4, 3)]
    assert not len(ReplayedTraffic(clip, 90 / FPS).bodies().numbers)


def test_rows_that_jump_away_and_back_are_dropped(tmp_path: Path) -> None:
    clip = drone_clips(a_folder(tmp_path, walkers([*range(1, 100)], 5.0, (50, 51)), ""))[0]
    assert (len(clip.tracks), clip.repairs.dropped_rows) == (1, 2)
    assert np.abs(np.diff(clip.tracks[0].states[:, 0])).max() < 0.2


def test_an_id_that_goes_on_elsewhere_is_another_person(tmp_path: Path) -> None:
    clip = drone_clips(a_folder(tmp_path, walkers([*range(1, 100)], 5.0, tuple(range(50, 100))), ""))[0]
    assert (len(clip.tracks), clip.repairs.cuts) == (2, 1)


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_damaged_recording_is_repaired_or_refused(tmp_path: Path, data: st.DataObject) -> None:
    rows = [f"3,{k},ped,{1.2 * k / FPS},2.0,1.2,0.0" for k in range(1, 120)]
    cars = [f"0,{k},veh,{3.0 * k / FPS},0.0,0.0,3.0" for k in range(1, 120)]
    for lines in (rows, cars):
        for _ in range(data.draw(st.integers(0, 4))):
            at = data.draw(st.integers(0, len(lines) - 1))
            damage = data.draw(st.sampled_from(("gap", "jump", "twice", "cut", "nan")))
            if damage == "gap":
                del lines[at : at + data.draw(st.integers(1, 40))]
                lines.append(lines[0] if lines else "3,1,x,0,0,0,0")
            else:
                fields = lines[at].split(",")
                fields[3] = {"jump": "70.0", "twice": fields[3], "nan": "nan", "cut": ""}[damage]
                lines[at] = ",".join(fields) + (f"\n{lines[at]}" if damage == "twice" else "")
    refusal, clips = "", list[Clip]()
    try:
        clips = drone_clips(a_folder(tmp_path, "\n".join(rows), "\n".join(cars)))
    except RecordingError as error:
        refusal = str(error)
    assert bool(clips) != ("filtered.csv" in refusal)
    for track in (track for clip in clips for track in clip.tracks):
        assert np.isfinite(track.states).all()
        assert (np.diff(track.times_s) > 0.0).all()
        steps_m = np.hypot(*np.diff(track.states[:, :2], axis=0).T)
        assert (steps_m <= 0.5 + 25.0 * np.diff(track.times_s)).all()


def test_a_folder_without_recordings_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="drone recordings"):
        drone_clips(tmp_path)


def test_people_are_where_they_were_recorded_between_frames_too(tmp_path: Path) -> None:
    traffic = ReplayedTraffic(a_clip(tmp_path), 1.0)
    bodies = traffic.bodies()
    expected_m = 0.05 * FPS * 1.0
    assert bodies.poses_map[0, 0] == pytest.approx(expected_m, abs=1e-6)
    for _ in range(50):
        traffic.step(np.empty((0, 7)), np.empty(0), np.empty((0, 1, 2)), 0.02)
    assert traffic.bodies().poses_map[0, 0] == pytest.approx(2.0 * expected_m, abs=1e-6)


def test_who_left_the_picture_is_gone_and_who_did_not_walks_on(tmp_path: Path) -> None:
    traffic = ReplayedTraffic(a_clip(tmp_path), 240 / FPS + 2.0, without=frozenset({100_000}))
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
    assert traffic.removed == ({} if there else {3: (float(late[0].times_s[0]), float(x), float(y))})


def test_a_pavement_recording_has_two_and_a_half_looks_a_second(tmp_path: Path) -> None:
    path = tmp_path / "obsmat.txt"
    path.write_text("".join(f"{10 * k} 1 {0.4 * k} 0 2 1.0 0 0\n" for k in range(5)))
    track = pavement_clip(path).tracks[0]
    assert np.diff(track.times_s) == pytest.approx([0.4] * 4)
    path.write_text("1 2 3\n")
    with pytest.raises(RecordingError, match="expected rows"):
        pavement_clip(path)

"""Scans for the detector have boxes that hold their returns, and held-out campuses are never learned from."""

from pathlib import Path

import numpy as np
import pytest

from campusloop.scenes.detector_scenes.campuses import CAMPUSES, Campus, CampusScene
from campusloop.scenes.detector_scenes.recording import SceneRecorder, hits_of
from contract.roads.load import encode_map
from vehicle_agent.signals import PEDESTRIAN
from vehicle_agent.stacks.warm import straight_road


@pytest.fixture(scope="module")
def campus(tmp_path_factory: pytest.TempPathFactory) -> CampusScene:
    path: Path = tmp_path_factory.mktemp("campus") / "map.json"
    path.write_bytes(encode_map(straight_road()))
    return CampusScene(Campus(path, 7, (20.0, 80.0)))


def test_no_campus_of_one_split_is_in_another_one() -> None:
    seen: set[tuple[str, int]] = set()
    for campuses in CAMPUSES.values():
        names = {(campus.campus_map.parent.name, campus.seed) for campus in campuses}
        assert not names & seen
        seen |= names
    west = max(c.x_m[1] for s in ("train", "tune") for c in CAMPUSES[s])  # type: ignore[index]
    # Two scans of 46 m each do not meet.
    for held_out in CAMPUSES["held-out"]:
        if held_out.campus_map in {c.campus_map for c in CAMPUSES["train"]}:
            assert held_out.x_m[0] - west > 2 * 46.0


@pytest.mark.parametrize("varied", [True, False], ids=["varied", "plain"])
def test_a_scan_repeats_from_its_seed_and_its_boxes_hold_returns(campus: CampusScene, varied: bool) -> None:
    recorder = SceneRecorder(campus, varied)
    scan = recorder.record((1, 2, 3))
    again = SceneRecorder(campus, varied).record((1, 2, 3))
    assert (scan.points == again.points).all()
    assert (scan.boxes == again.boxes).all()
    assert scan.is_older.any()
    assert not scan.is_older.all()
    near = np.hypot(scan.boxes[:, 0], scan.boxes[:, 1]) < 15.0
    people = near & (scan.kinds == PEDESTRIAN)
    assert people.any() or near.any()
    assert (scan.hits[near] >= 5).mean() > 0.6
    # What moves has left its box of the older turn.
    older = hits_of(scan.points[scan.is_older, :2], scan.boxes)
    fast = (np.hypot(scan.boxes[:, 6], scan.boxes[:, 7]) * scan.older_s > scan.boxes[:, 3] + 0.6) & near
    assert (older[fast] <= scan.hits[fast]).all()
    assert (scan.points[:, 2] >= 0.14).all()


def test_scans_are_taken_in_the_part_of_the_campus_that_is_named(campus: CampusScene) -> None:
    rng = np.random.default_rng(1)
    places = np.array([campus.draw_place(rng) for _ in range(50)])
    assert places[:, 0].min() > 18.0
    assert places[:, 0].max() < 82.0

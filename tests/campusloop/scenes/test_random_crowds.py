"""Scenes from a seed, and what counts as a stall."""

from pathlib import Path

import numpy as np
import pytest

from campusloop.scenes.random_crowds import draw_scene, random_curve, scene_sources
from campusloop.scenes.stalls import widest_gap_m
from contract.geometry import curvatures
from simulator.traffic.recordings import RecordingError
from simulator.traffic.replayed import ReplayedTraffic
from simulator.traffic.social_crowd import SocialCrowd
from vehicle_agent.config import Profile

MAPS = tuple(sorted((Path(__file__).resolve().parents[3] / "maps").glob("*/map.json")))


@pytest.fixture
def recordings(tmp_path: Path) -> Path:
    """Six people who walk past each other for a minute."""
    rows = []
    for number in range(6):
        for k in range(150):
            x, y = -20.0 + 0.4 * 1.2 * k * (1 if number % 2 else -1), 1.5 * number
            rows.append(f"{6 * k} {number} {x} 0 {y} {1.2 * (1 if number % 2 else -1)} 0 0")
    (tmp_path / "square").mkdir()
    (tmp_path / "square" / "obsmat.txt").write_text("\n".join(rows) + "\n")
    return tmp_path


def test_a_seed_draws_the_same_scene_and_another_a_different_one(recordings: Path) -> None:
    found = scene_sources(MAPS, recordings)
    for seed in range(12):
        first, again, other = (draw_scene(found, Profile(), k) for k in (seed, seed, seed + 1000))
        assert first.scene.road_map == again.scene.road_map
        assert (first.path, first.crowd, first.people_per_100m2) == (
            again.path, again.crowd, again.people_per_100m2,
        )  # fmt: skip
        assert first.scene.road_map != other.scene.road_map
        assert first.without_people().actors is None
        assert 5.0 <= first.scene.start_s_m < first.scene.goal_s_m


def test_both_kinds_of_crowds_and_of_paths_are_drawn(recordings: Path) -> None:
    found = scene_sources(MAPS, recordings)
    drawn = [draw_scene(found, Profile(), seed) for seed in range(40)]
    assert {type(one.scene.actors) for one in drawn} == {ReplayedTraffic, SocialCrowd}
    assert 5 < sum(one.path == "curve" for one in drawn) < 35
    assert any(one.is_sparse for one in drawn)
    assert any(one.people_per_100m2 > 4.0 for one in drawn)


def test_a_vehicle_that_begins_with_a_speed_begins_on_a_way_that_its_wheels_follow(recordings: Path) -> None:
    """A scene's wheels are straight at first: 2.5 m/s into a bend would end beside the lane."""
    found = scene_sources(MAPS, recordings)
    moving = 0
    for seed in range(9_200, 9_300):
        scene = draw_scene(found, Profile(), seed).scene
        (lane,) = scene.road_map.lanes
        points = np.array(lane.points)
        s_m = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
        near = points[np.abs(s_m - scene.start_s_m) < 2.0]
        turn = np.unwrap(np.arctan2(*np.diff(near, axis=0).T[::-1]))
        if scene.start_mps > 0.0:
            moving += 1
            assert abs(turn[-1] - turn[0]) < 0.3
    assert moving > 25


def test_a_folder_without_recordings_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError):
        scene_sources((), tmp_path)


def test_random_curves_can_be_driven() -> None:
    for seed in range(50):
        points = random_curve(70.0, np.random.default_rng(seed))
        assert np.abs(curvatures(points)).max() <= 1.0 / 8.5
        steps = np.hypot(*np.diff(points, axis=0).T)
        assert steps == pytest.approx(0.5)


def test_the_widest_gap_beside_and_between_people() -> None:
    assert widest_gap_m([], 2.0) == 4.0
    assert widest_gap_m([(-0.25, 0.25)], 2.0) == 1.75
    assert widest_gap_m([(-2.5, -1.0), (1.0, 1.5)], 2.0) == 2.0
    assert widest_gap_m([(-3.0, 3.0)], 2.0) == 0.0
    assert widest_gap_m([(5.0, 5.5)], 2.0) == 4.0


def test_recorded_people_who_are_taken_out_of_a_scene_are_counted(recordings: Path) -> None:
    found = scene_sources(MAPS, recordings)
    at_start = set()
    for seed in range(60):
        drawn = draw_scene(found, Profile(), seed)
        actors = drawn.scene.actors
        if isinstance(actors, ReplayedTraffic):
            at_start.add(drawn.removed)
            actors.removed[99] = (0.0, 0.0, 0.0)
            assert drawn.removed == drawn.removed_at_start + 1
    assert 0 in at_start
    assert max(at_start) > 0

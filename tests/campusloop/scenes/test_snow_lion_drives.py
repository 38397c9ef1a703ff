"""The whole onboard loop of the Snow Lion stack in small scenes, over CAN, by what a bystander would see."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from campusloop.scenes.drive import Scene, SceneDrive, SceneRun
from campusloop.scenes.path_map import path_map
from simulator.traffic.recordings import RecordedTrack
from simulator.traffic.replayed import ReplayedTraffic
from simulator.traffic.scripted_clips import clip_of, standing, walker
from simulator.world import WorldOptions
from vehicle_agent.config import load_profile
from vehicle_agent.signals import PEDESTRIAN, VEHICLE, PlanAnswer, PlanJob

_PROFILES = Path(__file__).resolve().parents[3] / "vehicle_agent" / "profiles"
PROFILE = load_profile(_PROFILES / "snow-lion.toml")
LENGTH_M = 120


def a_scene(
    *people: RecordedTrack, start_mps: float = 3.0, limit_s: float = 30.0, goal_s_m: float = 60.0
) -> Scene:
    points = np.column_stack((np.arange(0.0, LENGTH_M + 1.0), np.zeros(LENGTH_M + 1)))
    return Scene(
        "scene",
        path_map("scene", points, width_m=4.0, speed_limit_mps=4.2),
        PROFILE,
        start_s_m=10.0,
        start_mps=start_mps,
        goal_s_m=goal_s_m,
        limit_s=limit_s,
        seed=1,
        actors=ReplayedTraffic(clip_of("scene", people), 0.0),
        options=WorldOptions(traffic=None),
    )


def driven(*people: RecordedTrack, start_mps: float = 3.0, limit_s: float = 30.0) -> SceneRun:
    return SceneDrive(a_scene(*people, start_mps=start_mps, limit_s=limit_s)).run()


def speeds(run: SceneRun) -> np.ndarray:
    column: np.ndarray = run.trace.array()[:, 4]
    return column


def test_on_a_free_road_it_is_soon_at_its_limit_and_smooth() -> None:
    run = driven(start_mps=0.0)
    assert run.time_s is not None
    assert run.time_s < 21.0
    assert speeds(run).max() == pytest.approx(4.17, abs=0.2)
    assert np.abs(run.trace.array()[100:, 5]).max() < 1.3


def test_somebody_who_crosses_is_let_go_and_passed() -> None:
    run = driven(walker(1, PEDESTRIAN, ((35.0, 6.0), (35.0, -8.0)), 1.3, 1.0))
    assert run.time_s is not None
    assert not run.metrics.front_contacts
    assert not run.metrics.other_contacts
    assert run.metrics.clearance_m > 0.3


def test_somebody_who_stands_in_the_way_is_stopped_for_at_a_distance() -> None:
    run = driven(standing(1, PEDESTRIAN, 35.0, 0.0), limit_s=15.0)
    assert run.time_s is None
    assert speeds(run)[-1] == 0.0
    gap_m = 35.0 - 0.25 - (run.trace.array()[-1, 1] + PROFILE.body.front_overhang_m)
    assert 0.5 < gap_m < 2.5
    assert run.trace.array()[:, 5].min() > -2.0


def test_somebody_who_stands_at_the_side_is_passed_slowly_and_with_room() -> None:
    run = driven(standing(1, PEDESTRIAN, 35.0, 1.5))
    assert run.time_s is not None
    assert not run.metrics.front_contacts
    beside = np.abs(run.trace.array()[:, 1] + 2.0 - 35.0) < 1.5
    assert speeds(run)[beside].max() < 3.6
    assert run.metrics.clearance_m > 0.4


def test_a_slower_car_ahead_is_followed() -> None:
    run = driven(walker(1, VEHICLE, ((28.0, 0.0), (200.0, 0.0)), 1.5), limit_s=20.0)
    assert not run.metrics.front_contacts
    assert speeds(run)[-100:].mean() == pytest.approx(1.5, abs=0.3)


def test_who_walks_into_its_flank_does_not_stop_it() -> None:
    run = driven(walker(1, PEDESTRIAN, ((14.0, -5.0), (22.0, -0.9)), 2.0))
    assert run.time_s is not None
    assert run.time_s < 16.0


class Slow:
    """A planner that answers the first jobs and then never again."""

    def __init__(self, planner: object, answers: int) -> None:
        self._planner, self.left = planner, answers

    def __call__(self, job: PlanJob) -> PlanAnswer:
        self.left -= 1
        answer: PlanAnswer = self._planner(job)  # type: ignore[operator]
        if self.left < 0:
            return msgspec.structs.replace(answer, line_id=-1)
        return answer


def test_a_planner_that_never_answers_again_ends_in_a_stop_that_says_why() -> None:
    drive = SceneDrive(a_scene(standing(1, PEDESTRIAN, 40.0, 3.0), limit_s=12.0))
    drive.wired.planner = Slow(drive.wired.planner, 12)  # type: ignore[assignment]
    run = drive.run()
    assert run.time_s is None
    assert speeds(run)[-1] == 0.0
    assert "no_plan" in dict(run.limited_by)
    assert run.trace.array()[:, 5].min() > -2.5


def test_the_same_scene_twice_is_the_same_bit_for_bit() -> None:
    people = walker(1, PEDESTRIAN, ((30.0, 6.0), (30.0, -8.0)), 1.3, 1.0)
    first, second = (driven(people).trace.array() for _ in range(2))
    assert first.tobytes() == second.tobytes()

"""The planning room in the tick: when it asks, what it drives, and what it does without an answer."""

import math

import msgspec
import numpy as np
import pytest

from campusloop.scenes.path_map import LANE_ID, path_map
from contract.geometry import Array, Pose2
from contract.roads.network import RoadNetwork
from contract.roads.routing import ReferenceLine, find_route, route_line
from contract.runlog.arrays import dec_hook, enc_hook
from tests.vehicle_agent.world.builders import some_tracks
from vehicle_agent.planning.motion.motion_planning import MotionPlanning, MotionPlanningState
from vehicle_agent.signals import (
    PEDESTRIAN,
    Ego,
    PlanAnswer,
    PlanJob,
    PlanMemory,
    Task,
    TaskMode,
    Tracks,
    World,
)

TICK_NS = 20_000_000
MAP = path_map(
    "line", np.column_stack((np.arange(0.0, 201.0), np.zeros(201))), width_m=4.0, speed_limit_mps=4.0
)
NETWORK = RoadNetwork(MAP)
ROOM = MotionPlanning(NETWORK, 4.0, 2.6)


def the_line() -> ReferenceLine:
    route = find_route(NETWORK, LANE_ID, 0.0, LANE_ID, 199.0)
    assert route is not None
    return route_line(NETWORK, route)


LINE = the_line()


def an_ego(now_ns: int, x_m: float, speed_mps: float = 3.0, std_m: float = 0.02, y_m: float = 0.0) -> Ego:
    return Ego(now_ns, Pose2(x_m, y_m, 0.0), speed_mps, 0.0, 0.0, 0.0, std_m, now_ns, True)


def a_task(s_m: float, mode: TaskMode = "drive", stop_s_m: float = 150.0, line_id: int = 1) -> Task:
    line = LINE if mode != "idle" or line_id else None
    return Task(
        mode, line, line_id, s_m, 0.0, stop_s_m, LANE_ID, s_m, "o", 1, "v", "", "", False, (), "", None
    )


def a_world(now_ns: int, tracks: Tracks | None = None) -> World:
    none = some_tracks()
    return World(now_ns, now_ns, np.empty((0, 2)), (), (), False, tracks if tracks is not None else none)


def an_answer(job: PlanJob, speed_mps: float = 3.0, lasts_s: float = 8.0) -> PlanAnswer:
    """Straight on at an even speed from the job's start."""
    t = np.arange(0.0, lasts_s + 0.05, 0.1)
    x = job.pose_map.x_m + speed_mps * t
    zero, speed = np.zeros(len(t)), np.full(len(t), speed_mps)
    rows: Array = np.column_stack((t, x, zero, zero, zero, speed, zero, x))
    return PlanAnswer(
        job.number, job.stamp_ns, job.line_id, rows, "speed_limit", math.inf, np.empty(0, np.int64), (),
        PlanMemory(),
    )  # fmt: skip


class Driver:
    """Feeds the room; the planner answers after two ticks when it is not `silent`."""

    def __init__(self, *, silent: bool = False) -> None:
        self.silent = silent
        self.state: MotionPlanningState = ROOM.initial()
        self.now_ns, self.x_m, self.speed_mps = TICK_NS, 20.0, 3.0
        self.jobs: list[PlanJob] = []
        self._due: list[tuple[int, PlanAnswer]] = []

    def step(self, tracks: Tracks | None = None, **task: object) -> object:
        self.now_ns += TICK_NS
        self.x_m += self.speed_mps * 0.02
        plans = tuple(answer for due_ns, answer in self._due if due_ns <= self.now_ns)
        self._due = [(due_ns, answer) for due_ns, answer in self._due if due_ns > self.now_ns]
        ego = an_ego(self.now_ns, self.x_m, self.speed_mps)
        world = a_world(self.now_ns, tracks)
        path, self.state = ROOM.step(self.state, ego, world, a_task(self.x_m, **task), plans)  # type: ignore[arg-type]
        for job in ROOM.jobs(self.state):
            self.jobs.append(job)
            if not self.silent:
                self._due.append((self.now_ns + 2 * TICK_NS, an_answer(job)))
        self.speed_mps = path.speed_mps if path.trajectory is not None else self.speed_mps
        return path

    def run(self, seconds: float, tracks: Tracks | None = None) -> None:
        for _ in range(round(seconds * 50)):
            self.step(tracks)


def test_a_free_vehicle_keeps_its_trajectory() -> None:
    driver = Driver()
    driver.run(1.0)
    asked = len(driver.jobs)
    driver.run(2.0)
    assert asked >= 1
    assert len(driver.jobs) == asked


def test_one_who_may_meet_somebody_plans_ten_times_a_second() -> None:
    driver = Driver()
    driver.run(1.0)
    asked = len(driver.jobs)
    driver.run(2.0, some_tracks((PEDESTRIAN, 40.0, 3.0, 0.0, -1.0)))
    assert 18 <= len(driver.jobs) - asked <= 21


def test_the_job_begins_where_the_trajectory_will_be_and_the_answer_goes_on_from_there() -> None:
    driver = Driver()
    driver.run(1.0)
    driver.run(0.2, some_tracks((PEDESTRIAN, 40.0, 3.0, 0.0, -1.0)))
    job = driver.jobs[-1]
    lead_s = (job.stamp_ns - driver.now_ns) * 1e-9
    assert job.pose_map.x_m == pytest.approx(driver.x_m + 3.0 * lead_s, abs=0.1)
    assert job.speed_mps == pytest.approx(3.0)


@pytest.mark.parametrize(("faster_mps", "begins_mps"), [(-0.5, 2.65), (-0.1, 3.0), (0.1, 3.0), (0.5, 3.35)])
def test_a_plan_does_not_run_away_from_the_vehicle(faster_mps: float, begins_mps: float) -> None:
    driver = Driver()
    driver.run(1.0)
    while len(driver.jobs) < 3:
        driver.speed_mps += faster_mps
        driver.step(some_tracks((PEDESTRIAN, 40.0, 3.0, 0.0, -1.0)))
    assert driver.jobs[-1].speed_mps == pytest.approx(begins_mps)


def test_a_planner_that_falls_silent_ends_in_a_comfortable_stop() -> None:
    driver = Driver()
    driver.run(1.0)
    driver.silent = True
    somebody = some_tracks((PEDESTRIAN, 60.0, 3.0, 0.0, -1.0))
    speeds = []
    for _ in range(350):
        path = driver.step(somebody)
        speeds.append(driver.speed_mps)
    assert speeds[-1] == 0.0
    assert path.limited_by == "no_plan"
    assert np.diff(speeds).min() > -1.5 * 0.02


def test_it_goes_on_when_the_planner_is_back() -> None:
    driver = Driver()
    driver.run(1.0)
    driver.silent = True
    somebody = some_tracks((PEDESTRIAN, 60.0, 3.0, 0.0, -1.0))
    driver.run(7.0, somebody)
    driver.silent = False
    driver.run(1.0, somebody)
    assert driver.speed_mps > 2.0


def test_without_a_line_it_stands() -> None:
    path, _ = ROOM.step(
        ROOM.initial(),
        an_ego(TICK_NS, 20.0),
        a_world(TICK_NS),
        msgspec.structs.replace(a_task(20.0), line=None),
        (),
    )
    assert path.speed_mps == 0.0
    assert path.limited_by == "no_order"
    assert path.trajectory is None


@pytest.mark.parametrize("case", ["lost", "blind"])
def test_without_a_position_or_sight_what_is_driven_becomes_a_stop(case: str) -> None:
    driver = Driver()
    driver.run(1.0)
    ego, world = an_ego(driver.now_ns + TICK_NS, driver.x_m), a_world(driver.now_ns + TICK_NS)
    if case == "lost":
        ego = msgspec.structs.replace(ego, valid=False)
    else:
        world = msgspec.structs.replace(world, blind=True)
    path, _ = ROOM.step(driver.state, ego, world, a_task(driver.x_m), ())
    assert path.trajectory is not None
    assert path.trajectory.rows[-1, 5] == 0.0
    assert path.limited_by == {"lost": "no_position", "blind": "blind"}[case]


@pytest.mark.parametrize("std_m", [0.5, math.inf, math.nan])
def test_a_poor_position_asks_for_half_a_metre_a_second(std_m: float) -> None:
    state = ROOM.initial()
    for k in range(1, 8):
        ego = an_ego(k * TICK_NS, 20.0, std_m=std_m)
        _, state = ROOM.step(state, ego, a_world(k * TICK_NS), a_task(20.0), ())
        for job in ROOM.jobs(state):
            assert (job.speed_mps_max, job.speed_reason) == (0.5, "poor_position")
            return
    raise AssertionError("nothing was asked")


def test_the_state_survives_a_crash_of_the_process() -> None:
    driver = Driver()
    driver.run(1.5, some_tracks((PEDESTRIAN, 40.0, 3.0, 0.0, -1.0)))
    data = msgspec.msgpack.encode(driver.state, enc_hook=enc_hook)
    again = msgspec.msgpack.decode(data, type=MotionPlanningState, dec_hook=dec_hook)
    ego, world = an_ego(driver.now_ns + TICK_NS, driver.x_m), a_world(driver.now_ns + TICK_NS)
    paths = [ROOM.step(state, ego, world, a_task(driver.x_m), ())[0] for state in (driver.state, again)]
    encoded = [msgspec.msgpack.encode(path, enc_hook=enc_hook) for path in paths]
    assert encoded[0] == encoded[1]


@pytest.mark.parametrize(("accel_mps2", "begins_mps2"), [(-5.7, -1.2), (-0.5, -0.5), (0.8, 0.8)])
def test_a_plan_does_not_begin_with_braking_harder_than_plans_brake(
    accel_mps2: float, begins_mps2: float
) -> None:
    """The guard has braked and lets go at once: a plan that went on from there would come to rest."""
    ticks = 5
    ego = msgspec.structs.replace(an_ego(ticks * TICK_NS, 20.0), accel_mps2=accel_mps2)
    state = msgspec.structs.replace(ROOM.initial(), ticks=ticks - 1)
    _, state = ROOM.step(state, ego, a_world(ego.stamp_ns), a_task(20.0), ())
    assert state.job is not None
    assert state.job.accel_mps2 == begins_mps2


def test_the_way_to_an_obstacle_is_told_from_the_bumper() -> None:
    """What cuts the way 20 m ahead of the rear axle's place, with the bumper at it then, is 20 m away."""
    driver = Driver()
    driver.run(0.5)
    cut = msgspec.structs.replace(an_answer(driver.jobs[-1]), number=99, cut_s_m=driver.x_m + 20.0)
    path, _ = ROOM.step(
        driver.state, an_ego(driver.now_ns, driver.x_m), a_world(driver.now_ns), a_task(driver.x_m), (cut,)
    )
    assert path.obstacle_m == pytest.approx(20.0)

"""Other planners in our scenes: they are driven, judged and talked to as docs/simulator/peers.md says."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.peers.drive import PeerDrive, braking, road_of, row_at
from benchmarks.peers.messages import Plan, PlanRequest, Road
from benchmarks.peers.on_vehicle import VehiclePeer, trajectory_rows
from benchmarks.peers.ours import OurPlanner
from benchmarks.peers.process import PeerError, PeerProcess
from benchmarks.peers.pursuit import Pursuit
from benchmarks.peers.score import Result, summary
from campusloop.scenes.drive import Scene, SceneDrive
from campusloop.scenes.path_map import LANE_ID, path_map
from campusloop.scenes.protection.cells import cells
from campusloop.scenes.stacks import profile_of
from contract.roads.network import RoadNetwork
from contract.roads.routing import Route, route_line
from vehicle_agent.planning.motion.corridor import corridor_of

FAKE = Path(__file__).with_name("fake_open_planner.py")
CROSSING = "day-walks-near-0.50-10.0"


def test_a_scenes_driver_is_told_the_road_and_reaches_the_goal_at_the_cap() -> None:
    run = PeerDrive(_street(), Pursuit(blind=True)).run()
    assert run.time_s == pytest.approx(40.0 / 3.0, abs=1.0)
    assert not run.metrics.front_contacts
    assert max(row[4] for row in run.trace.rows) <= 3.0 + 1e-9


def test_blind_pursuit_drives_into_who_crosses_and_braking_pursuit_does_not() -> None:
    profile = profile_of("snow_lion")
    cell = next(cell for cell in cells(profile.body) if cell.name == CROSSING)
    blind = PeerDrive(cell.scene(profile, 1), Pursuit(blind=True)).run()
    braking_run = PeerDrive(cell.scene(profile, 1), Pursuit(blind=False)).run()
    assert [number for _, number, _ in blind.metrics.front_contacts] == [1]
    assert not braking_run.metrics.front_contacts
    assert braking_run.time_s is not None


def test_without_a_plan_the_vehicle_brakes_to_a_stand_and_stays() -> None:
    run = PeerDrive(_street(limit_s=6.0), _Mute(after=10)).run()
    speeds = np.array([row[4] for row in run.trace.rows])
    assert run.time_s is None
    assert speeds[:50].min() > 1.9
    assert speeds[-1] == 0.0
    braked_m = run.driven_m - 2.0
    assert braked_m == pytest.approx(2.0**2 / (2.0 * 0.9 * 5.6), abs=0.06)
    assert dict(run.limited_by)["no_plan"] == 50


def test_a_plan_that_begins_elsewhere_is_none() -> None:
    run = PeerDrive(_street(limit_s=4.0), _Elsewhere()).run()
    assert dict(run.limited_by) == {"begins elsewhere": 40}
    assert run.driven_m == pytest.approx(2.0**2 / (2.0 * 0.9 * 5.6), abs=0.06)


def test_a_drive_whose_plans_take_too_long_is_unfinished_and_counts_by_its_cycles_alone() -> None:
    drive = PeerDrive(_street(), _Mute(after=1000, cycle_ms=100.0), planning_s_max=1.0)
    run = drive.run()
    assert drive.unfinished
    assert len(run.plan_cpu_ms) == 11
    found = summary([_result("snow_lion"), _result("slow", unfinished=True, contacts=1, cycle_ms=500.0)])
    assert found["slow.scenes"] == 0
    assert found["slow.contacts"] == 0
    assert found["versus.slow.cycle_ratio"] == pytest.approx(100.0)
    assert found["versus.slow.time_ratio"] is None


def test_a_planner_in_our_place_moves_our_vehicle_with_its_noise_and_delays() -> None:
    scene, driver = _street(), _Line()
    planner = VehiclePeer(scene, driver, 300.0)
    run = SceneDrive(scene, planner=planner).run()
    assert run.time_s == pytest.approx(20.0, abs=1.0)
    assert planner.words == {"straight": len(driver.asked)}
    assert planner.cycles_cpu_ms == [0.5] * len(driver.asked)
    # Where the vehicle is expected when the plan begins, not where it is: noise and lag are in it.
    assert 0.0 < max(abs(ask.y_m) for ask in driver.asked) < 0.3


def test_a_planner_in_our_place_without_a_plan_brakes_our_vehicle_to_a_stand() -> None:
    scene = _street(limit_s=8.0)
    planner = VehiclePeer(scene, _Mute(after=1), 300.0)
    run = SceneDrive(scene, planner=planner).run()
    assert run.time_s is None
    assert run.trace.array()[-1, 4] == pytest.approx(0.0, abs=0.02)
    assert planner.words["no_plan"] >= 1


def test_a_planner_that_takes_too_long_in_our_place_is_unfinished_and_stands() -> None:
    scene = _street(limit_s=8.0)
    planner = VehiclePeer(scene, _Mute(after=10_000, cycle_ms=600.0), 1.0)
    run = SceneDrive(scene, planner=planner).run()
    assert planner.unfinished
    assert planner.cycles_cpu_ms == [600.0, 600.0]
    assert run.time_s is None


def test_our_planner_under_exact_conditions_reaches_the_goal_at_the_cap() -> None:
    scene = _street()
    run = PeerDrive(scene, OurPlanner(scene)).run()
    assert run.time_s == pytest.approx(40.0 / 3.0, abs=1.0)
    assert max(row[4] for row in run.trace.rows) <= 3.01


def test_our_planner_under_exact_conditions_lets_who_crosses_pass() -> None:
    profile = profile_of("snow_lion")
    scene = next(cell for cell in cells(profile.body) if cell.name == CROSSING).scene(profile, 1)
    run = PeerDrive(scene, OurPlanner(scene)).run()
    assert run.time_s is not None
    assert not run.metrics.front_contacts


def test_the_rows_of_a_plan_get_their_place_on_the_line_and_rising_times() -> None:
    scene = _street()
    network = RoadNetwork(scene.road_map)
    line = route_line(network, Route((LANE_ID,), 0.0, 69.0, 69.0, 0.0))
    corridor = corridor_of(line, network)
    plan = np.array(
        [(t, 10.0 + 2.0 * t, 0.2, 3.1 * k, 2.0, 0.0, 0.0) for k, t in enumerate((0.0, 0.0, 1.0, 2.0))]
    )
    rows = trajectory_rows(plan, corridor)
    assert (np.diff(rows[:, 0]) > 0.0).all()
    assert rows[:, 7] == pytest.approx(rows[:, 1], abs=0.02)


def test_pairs_on_exact_terms_are_compared_with_ours_on_exact_terms() -> None:
    results = [
        _result("snow_lion", "a", time_s=20.0),
        _result("snow_lion_exact", "a", time_s=10.0),
        _result("other", "a", time_s=20.0),
        _result("other_exact", "a", time_s=20.0),
    ]
    found = summary(results)
    assert found["versus.other.time_ratio"] == pytest.approx(1.0)
    assert found["versus.other_exact.time_ratio"] == pytest.approx(2.0)
    assert "versus.snow_lion_exact.scenes" not in found


def test_the_stop_goes_on_along_the_plan_and_straight_where_that_ends() -> None:
    angles = np.linspace(0.0, 0.2, 11)
    plan = np.column_stack(
        (
            np.linspace(0.0, 1.0, 11),
            10.0 * np.sin(angles),
            10.0 * (1.0 - np.cos(angles)),
            angles,
            np.full(11, 2.0),
            np.zeros(11),
            np.full(11, 0.1),
        )
    )
    stop = braking(plan, 0.5, row_at(plan, 0.5), 4.0)
    assert stop[-1, 4] == 0.0
    assert stop[-1, 0] == pytest.approx(0.5)
    radius = np.hypot(stop[:, 1], stop[:, 2] - 10.0)
    assert radius == pytest.approx(np.full(12, 10.0), abs=1e-3)
    longer = braking(plan, 0.5, row_at(plan, 0.5), 0.5)
    assert math.hypot(*(longer[-1, 1:3] - plan[-1, 1:3])) == pytest.approx(4.0 - 1.0, abs=0.01)
    assert longer[-1, 3] == pytest.approx(0.2)


def test_pairs_are_compared_over_the_scenes_that_both_drove() -> None:
    results = [
        _result("snow_lion", "a", time_s=10.0),
        _result("snow_lion", "b", time_s=20.0),
        _result("snow_lion", "c", time_s=20.0),
        _result("other", "a", time_s=15.0, cycle_ms=250.0),
        _result("other", "b", time_s=5.0, contacts=2, cycle_ms=350.0),
    ]
    found = summary(results)
    assert found["snow_lion.success_pct"] == 100.0
    assert found["other.success_pct"] == 50.0
    assert found["other.contacts"] == 2
    assert found["other.scenes_with_contact"] == 1
    assert found["versus.other.scenes"] == 2
    assert found["versus.other.both_succeeded"] == 1
    assert found["versus.other.time_ratio"] == pytest.approx(1.5)
    assert found["versus.other.time_ratio_all"] == pytest.approx(20.0 / 30.0)
    assert found["versus.other.cycle_ratio"] == pytest.approx(60.0)


def test_who_stands_till_the_time_is_up_has_touched_nobody_and_yet_not_succeeded() -> None:
    found = summary([_result("snow_lion", reached=False, time_s=90.0)])
    assert found["snow_lion.success_pct"] == 0.0
    assert found["snow_lion.contacts"] == 0


def test_a_planner_in_its_process_says_who_it_is_and_answers_every_ask() -> None:
    with _fake() as planner:
        assert planner.ready.version != ""
        assert planner.ready.name == "fake straight"
        planner.begin(_road())
        plan = planner.plan(_ask(3.0))
        assert plan.rows[1][1] == pytest.approx(0.3)
        assert plan.cycle_cpu_ms >= 0.0
        assert plan.words == "as told"


def test_only_the_planning_call_itself_is_timed() -> None:
    with _fake() as planner:
        planner.begin(_road())
        plan = planner.plan(_ask(3.0))
    assert plan.prepare_cpu_ms > 20.0
    assert plan.cycle_cpu_ms < 0.5 * plan.prepare_cpu_ms


def test_a_planner_that_raises_has_no_plan_and_its_error_is_told() -> None:
    with _fake() as planner:
        planner.begin(_road())
        plan = planner.plan(_ask(-1.0))
        assert plan.rows == []
        assert plan.words == "ValueError: a negative speed"
        assert planner.plan(_ask(1.0)).rows


def test_a_planner_whose_process_ends_is_an_error_with_its_status() -> None:
    with _fake() as planner:
        planner.begin(_road())
        with pytest.raises(PeerError, match="status 7"):
            planner.plan(_ask(99.0))


def test_a_planner_that_never_answers_is_given_up() -> None:
    with _fake(answer_s=5.0) as planner:
        planner.begin(_road())
        with pytest.raises(PeerError, match="no answer in 5 s"):
            planner.plan(_ask(50.0))


def test_an_interpreter_that_is_not_there_is_an_error() -> None:
    with pytest.raises(PeerError, match="nowhere"):
        PeerProcess(["/nowhere/python"])


class _Mute:
    """Straight on at 2 m/s, then no plan any more."""

    def __init__(self, after: int, cycle_ms: float = 0.0) -> None:
        self._left, self._cycle_ms = after, cycle_ms

    def begin(self, road: Road) -> None:
        assert road.speed_mps_max == 3.0

    def plan(self, ask: PlanRequest) -> Plan:
        self._left -= 1
        if self._left < 0:
            return Plan([], "no_plan", self._cycle_ms, 0.0, 0.0)
        rows = [(t, ask.x_m + 2.0 * t, ask.y_m, 0.0, 2.0, 0.0, 0.0) for t in (0.0, 0.5, 1.0)]
        return Plan(rows, "", self._cycle_ms, 0.0, 0.0)


class _Elsewhere(_Mute):
    def __init__(self) -> None:
        super().__init__(1)

    def plan(self, ask: PlanRequest) -> Plan:
        return Plan([(0.0, ask.x_m + 3.0, 0.0, 0.0, 1.0, 0.0, 0.0)] * 2, "", 0.0, 0.0, 0.0)


class _Line(_Mute):
    """Straight on at 2 m/s for ever; remembers what it was asked."""

    def __init__(self) -> None:
        super().__init__(10_000)
        self.asked: list[PlanRequest] = []

    def plan(self, ask: PlanRequest) -> Plan:
        self.asked.append(ask)
        rows = [(t, ask.x_m + 2.0 * t, ask.y_m, 0.0, 2.0, 0.0, 0.0) for t in (0.0, 2.0, 4.0)]
        return Plan(rows, "straight", 0.5, 0.0, 0.0)


def _street(limit_s: float = 30.0) -> Scene:
    points = np.column_stack((np.arange(0.0, 70.0), np.zeros(70)))
    road_map = path_map("street", points, width_m=4.0, speed_limit_mps=3.0)
    return Scene("street", road_map, profile_of("snow_lion"), 10.0, 2.0, 50.0, limit_s, 1)


def _road() -> Road:
    return road_of(_street())


def _ask(v_mps: float) -> PlanRequest:
    return PlanRequest(0.0, 0.0, 0.0, 0.0, v_mps, 0.0, 0.0, [(1.0, 9.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 1.0)])


def _fake(answer_s: float = 60.0) -> PeerProcess:
    return PeerProcess([sys.executable, str(FAKE)], answer_s)


def _result(
    driver: str,
    scene: str = "a",
    *,
    time_s: float = 10.0,
    reached: bool = True,
    contacts: int = 0,
    cycle_ms: float = 5.0,
    unfinished: bool = False,
) -> Result:
    cycles = (cycle_ms, cycle_ms)
    return Result(
        driver, scene, "sparse", time_s, reached, contacts, 0, 0.5, 20.0, 4.0, cycles, (), unfinished
    )

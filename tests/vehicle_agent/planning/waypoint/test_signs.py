"""Stop and yield signs beside the way, on the road of `builders` (east along the x axis)."""

import math

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.geometry import Pose2
from tests.vehicle_agent.planning.builders import ROOM, TICK_NS, a_task, a_world, an_ego
from vehicle_agent.planning.waypoint.signs import SignRule
from vehicle_agent.planning.waypoint.waypoint_planning import WaypointPlanningState
from vehicle_agent.signals import Path, SeenSign, World

RULE = SignRule(body_front_m=ROOM.obstacle.body_front_m)
READING = msgspec.structs.replace(ROOM, signs=RULE)
HERE_M = 20.0
BUMPER_M = HERE_M + RULE.body_front_m


def a_sign(
    ahead_m: float, kind: str = "stop", y_m: float = -3.0, yaw_rad: float = math.pi, number: int = 1
) -> SeenSign:
    """A sign before which the bumper has to stand `ahead_m` from now."""
    place = Pose2(BUMPER_M + ahead_m + RULE.before_m, y_m, yaw_rad)
    return SeenSign(number, kind, place, ahead_m)  # type: ignore[arg-type]


def with_signs(*signs: SeenSign, cells: tuple[tuple[float, float], ...] = ()) -> World:
    return msgspec.structs.replace(a_world(*cells), signs=signs)


def planned(
    world: World, speed_mps: float = 3.0, state: WaypointPlanningState | None = None, tick: int = 1
) -> tuple[Path, WaypointPlanningState]:
    ego = an_ego(tick * TICK_NS, speed_mps=speed_mps)
    return READING.step(state or READING.initial(), ego, world, a_task())


def test_a_stop_sign_at_ten_metres_is_braked_for_at_the_papers_rate() -> None:
    path, state = planned(with_signs(a_sign(10.0)))
    assert state.signs.decel_mps2 == pytest.approx(0.45)
    assert path.limited_by == "stop_sign"
    assert path.accel_mps2 <= -0.4


def test_a_sign_that_is_named_late_is_braked_for_harder_and_a_far_one_not_yet() -> None:
    assert planned(with_signs(a_sign(4.0)))[1].signs.decel_mps2 == pytest.approx(9.0 / 8.0)
    far, _ = planned(with_signs(a_sign(25.0)))
    assert far.limited_by == "waypoint_speed"


@given(st.floats(0.5, 30.0), st.floats(0.0, 4.0))
def test_a_stop_sign_never_allows_more_than_can_be_braked(ahead_m: float, speed_mps: float) -> None:
    path, state = planned(with_signs(a_sign(ahead_m)), speed_mps)
    allowed = math.sqrt(2.0 * max(state.signs.decel_mps2, 0.45) * ahead_m)
    assert path.speed_mps <= max(allowed, 1e-9) + 1e-6


def test_the_vehicle_stands_two_seconds_and_goes_on_once() -> None:
    world = with_signs(a_sign(0.0))
    state = READING.initial()
    speeds = []
    for tick in range(1, 160):
        path, state = planned(world, 0.0, state, tick)
        speeds.append(path.speed_mps)
    stood = next(number for number, speed in enumerate(speeds) if speed > 0.0)
    assert stood * TICK_NS >= round(RULE.stand_s * 1e9)
    assert all(speed > 0.0 for speed in speeds[stood:])
    assert state.signs.served == (1,)


def test_it_waits_longer_while_the_path_is_not_free() -> None:
    world = with_signs(a_sign(0.0), cells=((BUMPER_M + 6.0, 0.0),))
    state = READING.initial()
    for tick in range(1, 300):
        path, state = planned(world, 0.0, state, tick)
        assert path.speed_mps == 0.0
    assert state.signs.served == ()


def test_a_vehicle_that_rolls_has_not_stopped() -> None:
    state = READING.initial()
    for tick in range(1, 200):
        _, state = planned(with_signs(a_sign(0.3)), 0.2, state, tick)
    assert state.signs.served == ()


@pytest.mark.parametrize(
    "sign",
    [
        a_sign(8.0, yaw_rad=0.0),  # for the oncoming lane
        a_sign(8.0, yaw_rad=0.5 * math.pi),  # for the crossing street
        a_sign(8.0, y_m=3.0),  # on the other side
        a_sign(8.0, y_m=-9.0),  # a road aside
        a_sign(8.0, y_m=0.2),  # on the road itself
        a_sign(8.0, kind="board"),
        a_sign(8.0, kind="other"),
        a_sign(-4.0),  # passed
    ],
)
def test_signs_that_are_not_for_this_way_change_nothing(sign: SeenSign) -> None:
    path, state = planned(with_signs(sign))
    assert (path.limited_by, path.speed_mps) == ("waypoint_speed", 3.0)
    assert state.signs.sign_id == 0


def test_where_traffic_keeps_left_signs_stand_on_the_left() -> None:
    left = msgspec.structs.replace(READING, signs=msgspec.structs.replace(RULE, side="left"))
    ego = an_ego(TICK_NS, speed_mps=3.0)
    path, _ = left.step(left.initial(), ego, with_signs(a_sign(8.0, y_m=3.0)), a_task())
    assert path.limited_by == "stop_sign"


def test_a_yield_sign_slows_and_does_not_stop() -> None:
    for ahead_m in (4.0, 1.0, 0.0, -1.0):
        path, _ = planned(with_signs(a_sign(ahead_m, kind="yield")))
        assert path.limited_by == "yield_sign"
        assert RULE.yield_mps <= path.speed_mps < 3.0


def test_the_next_sign_is_obeyed_after_the_first_was_served() -> None:
    state = READING.initial()
    both = with_signs(a_sign(0.0), a_sign(12.0, number=2))
    for tick in range(1, 130):
        _, state = planned(both, 0.0, state, tick)
    path, state = planned(both, 3.0, state, 131)
    assert state.signs.sign_id == 2
    assert path.limited_by in ("stop_sign", "waypoint_speed")


def test_a_stack_without_the_rule_ignores_signs() -> None:
    path, _ = ROOM.step(ROOM.initial(), an_ego(TICK_NS, speed_mps=3.0), with_signs(a_sign(6.0)), a_task())
    assert path.limited_by == "waypoint_speed"

"""Speed limits, who goes first, and the speed program."""

import msgspec
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from vehicle_agent.planning.motion.request import ClearanceLaw, DrivingLimits
from vehicle_agent.planning.motion.speed.speed_limits import (
    backward_in_time,
    backward_pass,
    clearance_speed_mps,
)
from vehicle_agent.planning.motion.speed.speed_qp import (
    SpeedBounds,
    SpeedCorridor,
    SpeedWeights,
    brake_envelope,
    solve_speed,
    started,
)
from vehicle_agent.planning.motion.speed.st_graph import StGraph, corridor
from vehicle_agent.planning.motion.speed.st_search import search

LIMITS = DrivingLimits()
BOUNDS = SpeedBounds(1.0, 0.8, 1.8, 1.9)
# Every second costs as much as any other.
EVEN = np.ones(41)
FADING = SpeedBounds(1.12, 0.8, 1.8, 1.7, 0.08)


def a_corridor(
    high_m: float = 1e3,
    limit_mps: float = 4.17,
    low_m: float = -1e3,
    gap_s: float = 0.0,
    answer_s: float = 0.0,
) -> SpeedCorridor:
    one = np.ones(40)
    return SpeedCorridor(
        low_m * one,
        high_m * one,
        gap_s * one,
        1e3 * one,
        0.0 * one,
        limit_mps * one,
        0.0 * one,
        answer_s * one,
        limit_mps * one,
    )


def test_the_clearance_law_passes_its_three_points_and_is_flat_outside() -> None:
    law = ClearanceLaw(0.2, 0.8, 1.6, 0.5, 2.0, 4.0)
    got = [clearance_speed_mps(law, c) for c in (-1.0, 0.2, 0.5, 0.8, 1.2, 1.6, 9.0)]
    assert got == pytest.approx([0.5, 0.5, 1.25, 2.0, 3.0, 4.0, 4.0])


def test_the_backward_pass_lets_every_limit_be_reached_by_comfortable_braking() -> None:
    u = np.arange(0.0, 40.0, 0.25)
    limit = np.where(u > 20.0, 1.0, 4.0)
    v, cause = backward_pass(u, limit, np.zeros(len(u), np.int64), 35.0, 0.8)
    assert (v <= limit).all()
    assert (np.diff(v**2) >= -2.0 * 0.8 * 0.25 - 1e-9).all()
    assert v[u >= 35.0].max() == 0.0
    assert cause[100] == 0
    assert cause[u > 34.8][0] == 3


def test_a_limit_that_comes_later_is_braked_for_in_time_and_one_that_is_over_is_not() -> None:
    u = np.arange(0.0, 30.0, 0.25)
    limit = np.full((41, len(u)), 4.0)
    limit[20:30, 40:60] = 1.0
    out = backward_in_time(limit, u, 0.8, 0.2)
    assert out[19, 45] == pytest.approx(1.16, abs=0.01)
    assert out[30, 45] == 4.0
    assert out[0, 100] == 4.0


@settings(max_examples=60, deadline=None)
@given(v0=st.floats(0.0, 5.6), a0=st.floats(-2.0, 1.2), high_m=st.floats(0.5, 60.0))
def test_the_program_always_has_a_solution_within_hard_bounds(v0: float, a0: float, high_m: float) -> None:
    plan = solve_speed(
        started(v0, a0, None, BOUNDS, 0.2), a_corridor(high_m), BOUNDS, 4.17, SpeedWeights(), 0.2
    )
    assert plan.solved
    assert plan.v_mps.min() > -1e-3
    assert plan.a_mps2[3:].max() <= 1.0 + 1e-3
    assert plan.a_mps2[3:].min() >= -1.8 - 1e-3
    assert np.abs(plan.jerk_mps3).max() <= 1.9 + 1e-3


@settings(max_examples=60, deadline=None)
@given(
    v0=st.floats(0.0, 5.6), a0=st.floats(-1.8, 1.0), held=st.floats(-2.5, 2.5), high_m=st.floats(0.5, 60.0)
)
@example(v0=3.0, a0=0.0, held=0.5, high_m=1.0)
@example(v0=5.6, a0=-1.3338846411972898, held=-0.4335107390916231, high_m=0.5)
def test_what_is_commanded_already_is_planned_as_it_will_be(
    v0: float, a0: float, held: float, high_m: float
) -> None:
    start = started(v0, a0, held, BOUNDS, 0.2)
    plan = solve_speed(start, a_corridor(high_m), BOUNDS, 4.17, SpeedWeights(), 0.2)
    assert plan.solved
    assert plan.v_mps.min() > -1e-3
    if start.held_jerk_mps3 is not None:
        assert plan.jerk_mps3[0] == pytest.approx(held, abs=1e-3)
    assert np.abs(plan.jerk_mps3[1:]).max() <= 1.9 + 1e-3


def test_room_to_answer_is_kept_before_who_moves() -> None:
    start = started(3.0, 0.0, None, BOUNDS, 0.2)
    plan = solve_speed(start, a_corridor(12.0, gap_s=0.35), BOUNDS, 4.17, SpeedWeights(), 0.2)
    assert (plan.u_m + 0.35 * plan.v_mps).max() < 12.02
    assert plan.u_m[-1] == pytest.approx(12.0, abs=0.15), "at rest the room is used up"


@settings(max_examples=40, deadline=None)
@given(v0=st.floats(0.0, 5.6), a0=st.floats(-1.8, 1.0))
def test_the_corridor_is_kept_when_braking_can_keep_it(v0: float, a0: float) -> None:
    needed = brake_envelope(v0, max(a0, -0.9 * (3.8 * v0) ** 0.5), 1.8, 1.9, 0.2, 40)
    plan = solve_speed(
        started(v0, a0, None, BOUNDS, 0.2), a_corridor(needed[-1, 0] + 0.3), BOUNDS, 4.17, SpeedWeights(), 0.2
    )
    assert plan.excess_m < 0.02


@settings(max_examples=60, deadline=None)
@given(v0=st.floats(0.0, 5.6), a0=st.floats(-2.0, 1.5), high_m=st.floats(0.5, 60.0))
@example(v0=4.0, a0=1.1, high_m=60.0)
def test_less_is_accelerated_at_speed_than_from_rest(v0: float, a0: float, high_m: float) -> None:
    plan = solve_speed(
        started(v0, a0, None, FADING, 0.2), a_corridor(high_m), FADING, 4.17, SpeedWeights(), 0.2
    )
    assert plan.solved
    # What the start has too much of is gone after a0 / jerk.
    assert (plan.a_mps2[5:] <= 1.12 - 0.08 * plan.v_mps[5:] + 1e-3).all()


@pytest.mark.parametrize("answer_s", [0.0, 0.55])
def test_it_sets_off_beside_people_so_that_its_answer_finds_it_at_their_limit(answer_s: float) -> None:
    road = a_corridor(limit_mps=1.0, answer_s=answer_s)
    plan = solve_speed(started(0.0, 0.0, None, FADING, 0.2), road, FADING, 4.17, SpeedWeights(), 0.2)
    ahead_mps = plan.v_mps + 0.55 * plan.a_mps2
    assert (ahead_mps.max() < 1.02) == (answer_s > 0.0)
    assert plan.v_mps[-1] == pytest.approx(1.0, abs=0.02)


def test_it_brakes_late_for_who_may_yet_let_it_pass() -> None:
    hurried, even = (
        solve_speed(started(3.0, 0.0, None, BOUNDS, 0.2), a_corridor(9.0), BOUNDS, 4.17, weights, 0.2)
        for weights in (SpeedWeights(), SpeedWeights(now=0.0))
    )
    assert hurried.v_mps[5] > even.v_mps[5] + 0.1, "faster a second from now"
    assert hurried.u_m[-1] <= 9.02, "and stands as far before them"


def test_a_gap_that_is_there_now_is_taken() -> None:
    u, free = np.arange(0.0, 48.0, 0.25), np.full((41, 192), 100.0)
    passed = []
    for urgency in (EVEN, SpeedWeights().urgency(41, 0.2)):
        # Somebody is 6 to 9 m ahead from 2.4 s on. A vehicle that speeds up is past 9 m by then.
        graph = a_graph(6.0, 9.0, 12, 22)
        way = search(graph, u, np.full(192, 4.17), free, 3.0, 0.0, LIMITS, urgency, 60_000)
        passed.append(len(corridor(graph, way.u_m).passes))
    assert passed == [0, 1]


def test_a_launch_uses_what_the_drive_gives() -> None:
    road = a_corridor()
    fading, flat = (
        solve_speed(started(0.0, 0.0, None, bounds, 0.2), road, bounds, 4.17, SpeedWeights(), 0.2)
        for bounds in (FADING, SpeedBounds(0.8, 0.8, 1.8, 1.7))
    )
    assert fading.a_mps2.max() > 1.0
    assert fading.u_m[20] > flat.u_m[20] + 1.0


def test_the_search_knows_that_less_is_accelerated_at_speed() -> None:
    u = np.arange(0.0, 48.0, 0.25)
    flat = DrivingLimits(accel_mps2_max=1.12)
    reached = []
    for limits in (flat, msgspec.structs.replace(flat, accel_fade_1ps=0.08)):
        free = np.full((41, len(u)), 100.0)
        way = search(a_graph(0.0, -1.0, 0, 0), u, np.full(len(u), 4.17), free, 2.0, 0.0, limits, EVEN, 60_000)
        steps = np.diff(way.v_mps) / 0.2
        middle_mps = 0.5 * (way.v_mps[1:] + way.v_mps[:-1])
        assert (steps <= limits.accel_mps2_max - limits.accel_fade_1ps * middle_mps + 0.05).all()
        reached.append(way.u_m[10])
    assert reached[1] < reached[0]


def test_a_free_road_is_used_up_to_the_limit() -> None:
    plan = solve_speed(started(0.0, 0.0, None, BOUNDS, 0.2), a_corridor(), BOUNDS, 4.17, SpeedWeights(), 0.2)
    assert plan.v_mps[-1] == pytest.approx(4.17, abs=0.02)
    # Jerk and acceleration at their bounds need 4.17 / 1.0 + 1.0 / 1.9 s.
    assert plan.v_mps[round(5.2 / 0.2)] > 4.0


def a_graph(low_m: float, high_m: float, from_k: int, to_k: int) -> StGraph:
    low, high = np.full((41, 1), np.inf), np.full((41, 1), -np.inf)
    low[from_k:to_k], high[from_k:to_k] = low_m, high_m
    return StGraph(0.2, low, high, low.copy(), high.copy(), np.zeros(1, np.int64))


def ways(graph: StGraph, v0: float, limit_mps: float = 4.17) -> tuple[str, np.ndarray]:
    u = np.arange(0.0, 48.0, 0.25)
    free = np.full((41, len(u)), 100.0)
    way = search(graph, u, np.full(len(u), limit_mps), free, v0, 0.0, LIMITS, EVEN, 60_000)
    assert way.found
    room = corridor(graph, way.u_m)
    return ("yield" if len(room.yields_to) else "pass" if len(room.passes) else "free"), way.u_m


def test_who_comes_late_is_passed_before_and_who_comes_soon_is_yielded_to() -> None:
    assert ways(a_graph(15.0, 20.0, 35, 41), 4.0)[0] == "pass"
    assert ways(a_graph(8.0, 14.0, 8, 20), 3.0)[0] == "yield"


def test_the_way_found_never_drives_through_a_taken_stretch() -> None:
    for low_m in np.arange(4.0, 30.0, 2.0):
        for from_k in range(4, 36, 4):
            _, u = ways(a_graph(low_m, low_m + 5.0, from_k, from_k + 6), 2.0)
            during = u[from_k : from_k + 6]
            inside = (during > low_m + 0.8) & (during < low_m + 4.2)
            assert not (inside & (np.gradient(during, 0.2) > 0.1)).any()


def test_a_search_without_room_for_its_nodes_says_so() -> None:
    u = np.arange(0.0, 48.0, 0.25)
    free = np.full((41, len(u)), 100.0)
    way = search(a_graph(8.0, 14.0, 8, 20), u, np.full(len(u), 4.17), free, 3.0, 0.0, LIMITS, EVEN, 50)
    assert not way.found
    assert way.nodes <= 50


def test_samples_at_one_place_leave_a_limit_as_it_is() -> None:
    u = np.array([0.0, 0.25, 0.25])
    limit = np.array([[3.0, 3.0, 3.0], [1.0, 0.5, 0.5], [0.5, 0.5, 0.5]])
    out = backward_in_time(limit, u, 0.8, 0.2)
    assert np.isfinite(out).all()
    assert (out <= limit).all()
    assert out[0, 0] <= 1.0 + 0.8 * 0.2


@pytest.mark.parametrize("behind_m", [0.0, 0.6, 50.0])
def test_what_lies_in_memory_behind_the_last_sample_limits_nothing(behind_m: float) -> None:
    memory = np.array([0.0, 0.5, 1.0, behind_m])
    limit = np.array([[4.0, 4.0, 4.0], [4.0, 4.0, 2.0], [0.0, 0.0, 0.0]])
    out = backward_in_time(limit, memory[:3], 0.8, 0.2)
    assert out[1] == pytest.approx([0.16, 0.16, 0.16])
    assert out[0] == pytest.approx([0.32, 0.32, 0.32])

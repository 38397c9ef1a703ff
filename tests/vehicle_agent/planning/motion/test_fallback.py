"""The stops that replace a plan: as mild as possible, as hard as necessary."""

import math
from typing import Any

import numpy as np
import pytest

from tests.vehicle_agent.planning.motion.scenes import a_corridor, a_request, people
from vehicle_agent.planning.motion.agents import moving_discs
from vehicle_agent.planning.motion.fallback import MotionCandidate, badness, on_arc, safest, stops
from vehicle_agent.planning.motion.path.gp_path import SolvedPath
from vehicle_agent.planning.motion.path.path_problem import road_from, start_on
from vehicle_agent.planning.motion.path.path_samples import sample_path
from vehicle_agent.planning.motion.plan import plan_motion
from vehicle_agent.planning.motion.request import Motion, MotionParams, WarmStart
from vehicle_agent.planning.motion.speed.speed_step import plan_speed

PARAMS = MotionParams()
LIMITS = PARAMS.limits
FRONT_M = PARAMS.vehicle.length_m - PARAMS.vehicle.rear_overhang_m
X, SPEED, ACCEL, S = 1, 5, 6, 7


def stopped(speed_mps: float = 3.0, **changed: Any) -> Motion:
    request = a_request(speed_mps=speed_mps, **changed)
    moving = moving_discs(people(), np.array([0.0]), 20.0)
    return on_arc(request, PARAMS, "off_line", moving)


def a_wall(ahead_m: float) -> np.ndarray:
    """So far before the bumper."""
    return np.array([[FRONT_M + ahead_m + 0.2, y, 0.2] for y in np.linspace(-1.0, 1.0, 6)])


def test_contacts_are_worse_than_any_number_of_other_violations() -> None:
    assert badness(("agent",)) > badness(("speed", "jerk", "lateral"))
    assert badness(("static", "agent")) > badness(("footprint",))
    assert badness(("speed", "jerk")) > badness(("speed",)) > badness(())


def test_off_its_line_the_vehicle_stops_comfortably_on_its_arc_and_says_why() -> None:
    motion = stopped()
    assert (motion.quality, motion.violations, motion.limited_by) == ("stop", ("off_line",), "infeasible")
    assert motion.rows[-1, SPEED] == 0.0
    assert motion.rows[:, ACCEL].min() == pytest.approx(-LIMITS.decel_mps2_comfort, abs=0.05)
    assert motion.path is None


@pytest.mark.parametrize(
    ("wall_m", "quality", "decel_mps2"),
    [
        (9.0, "stop", LIMITS.decel_mps2_comfort),
        (4.5, "stop", LIMITS.decel_mps2_max),
        (2.2, "emergency", 0.5 * LIMITS.hard_decel_mps2),
        (1.3, "emergency", LIMITS.hard_decel_mps2),
    ],
)
def test_it_brakes_as_hard_as_what_is_ahead_asks_for_and_no_harder(
    wall_m: float, quality: str, decel_mps2: float
) -> None:
    motion = stopped(static_discs=a_wall(wall_m))
    assert motion.quality == quality
    assert motion.rows[:, ACCEL].min() == pytest.approx(-decel_mps2, abs=0.1)
    assert motion.rows[-1, X] < wall_m


def test_where_even_the_hardest_stop_touches_the_mildest_of_the_equals_is_kept() -> None:
    motion = stopped(static_discs=a_wall(0.2))
    assert motion.rows[-1, SPEED] == 0.0
    assert motion.quality == "stop"


def test_the_place_on_the_line_goes_on_from_the_last_one_that_was_known() -> None:
    known = stopped(s_hint_m=12.5)
    assert known.rows[0, S] == 12.5
    assert stopped().rows[0, S] == a_corridor().s_m[0]


def test_doubted_predictions_are_counted() -> None:
    jumps = people((9.0, 0.0, 0.0, 0.0), (9.0, 3.0, 0.0, 0.0))
    jumps.poses_map[0, 10:, 0] += 500.0
    moving = moving_discs(jumps, np.array([0.0]), 20.0)
    motion = on_arc(a_request(speed_mps=1.0), PARAMS, "off_line", moving)
    assert dict(motion.diagnostics)["doubted"] == 1.0


def test_a_plan_that_would_touch_somebody_is_replaced_by_a_stop_that_names_what_was_wrong() -> None:
    crossing = people((FRONT_M + 1.4, 0.0, 0.0, 0.0))
    motion = plan_motion(a_request(speed_mps=3.0, agents=crossing), PARAMS)
    assert motion.quality in ("stop", "emergency")
    assert motion.replaced
    assert motion.rows[-1, SPEED] == pytest.approx(0.0, abs=0.05)
    assert motion.limited_by in ("emergency", "infeasible", "obstacle", "blocked")


def safest_past(disc: np.ndarray, warm: WarmStart | None) -> MotionCandidate:
    """The replacement of a plan that leads straight into a disc at 8 m/s; warm is the previous path."""
    request = a_request(speed_mps=8.0, room_m=3.0, static_discs=disc, warm=warm)
    moving = moving_discs(people(), np.arange(0.0, PARAMS.horizon_s + 0.01, PARAMS.row_s), 20.0)
    road = road_from(request, PARAMS)
    s0_m, start = start_on(road, request)
    straight = SolvedPath(s0_m, PARAMS.step_m, np.zeros((12, 3)), 0.0, 1, True)
    samples = sample_path(road.line, straight, PARAMS.sample_m)
    speed = plan_speed(request, PARAMS, road, samples, moving, disc)
    rows = stops(request, PARAMS, road, straight, samples, speed)[0].rows
    draft = MotionCandidate(straight, samples, speed, rows, "planned", ("static", "speed"))
    return safest(request, PARAMS, road, s0_m, start, moving, draft)


def a_path_to_the_left(from_m: float, to_m: float, begin_l_m: float = 0.0) -> WarmStart:
    """A path that moves 1 m to the left between s = 0 and s = 12 m."""
    s = np.arange(from_m, to_m + 0.1, 2.0)
    ahead = np.clip(s / 12.0, 0.0, 1.0)
    states = np.column_stack(
        (
            begin_l_m + 0.5 - 0.5 * np.cos(math.pi * ahead),
            math.pi / 24.0 * np.sin(math.pi * ahead),
            math.pi**2 / 288.0 * np.cos(math.pi * ahead),
        )
    )
    return WarmStart(s, states)


GRAZED = np.array([[FRONT_M + 3.0, -0.5 * PARAMS.vehicle.width_m - 0.2, 0.3]])


def test_where_even_a_stop_on_the_new_path_touches_something_the_previous_path_is_kept() -> None:
    assert "static" in safest_past(GRAZED, None).wrong
    best = safest_past(GRAZED, a_path_to_the_left(-4.0, 30.0))
    assert best.wrong == ()
    assert best.path.at(np.array([12.0]))[0, 0] == pytest.approx(1.0, abs=0.01)
    assert best.instead == ("static", "speed")


@pytest.mark.parametrize(
    "before",
    [
        a_path_to_the_left(-4.0, 6.0),
        a_path_to_the_left(-4.0, 30.0, begin_l_m=0.35),
        a_path_to_the_left(0.0, -1.0),
    ],
)
def test_a_previous_path_that_has_ended_or_is_elsewhere_is_not_driven_on(before: WarmStart) -> None:
    assert "static" in safest_past(GRAZED, before).wrong


def test_a_previous_path_that_reaches_eight_metres_ahead_is_enough_to_stop_on() -> None:
    best = safest_past(GRAZED, a_path_to_the_left(0.2, 8.2))
    assert len(best.path.states) == 5

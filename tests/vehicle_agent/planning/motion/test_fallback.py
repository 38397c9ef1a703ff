"""The stops that replace a plan: as mild as possible, as hard as necessary."""

from typing import Any

import numpy as np
import pytest

from tests.vehicle_agent.planning.motion.scenes import a_corridor, a_request, people
from vehicle_agent.planning.motion.agents import moving_discs
from vehicle_agent.planning.motion.fallback import badness, on_arc
from vehicle_agent.planning.motion.plan import plan_motion
from vehicle_agent.planning.motion.request import Motion, MotionParams

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

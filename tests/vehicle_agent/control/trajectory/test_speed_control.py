"""Control follows a plan, does not hurry after one that is ahead, and does not inch."""

import msgspec
import numpy as np

from vehicle_agent.control.actuators import MSPEED
from vehicle_agent.control.trajectory.observer import Observer
from vehicle_agent.control.trajectory.speed_control import SpeedControl

SPEED_MPS = 1.0


def throttle(plan_mps: float, ahead_m: float) -> float:
    """What a vehicle at 1 m/s gives for a plan at an even speed whose place is ahead_m before it."""
    observer, control = Observer(), SpeedControl()
    estimate = observer.initial()
    vehicle = estimate.vehicle.copy()
    vehicle[MSPEED] = SPEED_MPS
    estimate = msgspec.structs.replace(estimate, vehicle=vehicle)
    t = 0.1 * np.arange(81)
    s, flat = ahead_m + plan_mps * t, np.zeros(len(t))
    rows = np.column_stack((t, s, flat, flat, flat, flat + plan_mps, flat, s))
    moves = msgspec.structs.replace(
        control.initial(), pedals=msgspec.structs.replace(control.initial().pedals, holding=False)
    )
    result = control.step(moves, estimate, observer, np.zeros((20, 3)), rows, s, 0.0, 0.0, False)
    return result.state.pedals.throttle_ratio


def test_a_plan_that_is_far_ahead_asks_for_no_more_than_one_that_is_a_little_ahead() -> None:
    little, far, faster = throttle(1.1, 0.2), throttle(1.1, 0.4), throttle(1.6, 0.2)
    assert 0.0 < throttle(1.0, 0.0) < little
    assert far == little
    assert abs(faster - little) < 0.01


def opened(creep_mps: float) -> bool:
    """Whether a vehicle at rest lets its brake go for a plan that sets off to creep."""
    observer, control = Observer(), SpeedControl()
    t = 0.1 * np.arange(81)
    speeds = np.minimum(0.4 * t, creep_mps)
    s, flat = np.cumsum(speeds) * 0.1, np.zeros(len(t))
    rows = np.column_stack((t, s, flat, flat, flat, speeds, flat, s))
    state = control.initial()
    result = control.step(state, observer.initial(), observer, np.zeros((20, 3)), rows, s, 0.0, 0.0, False)
    return not result.state.pedals.holding


def test_a_vehicle_at_rest_creeps_but_does_not_inch() -> None:
    assert opened(0.25), "so fast the vehicle passes people who stand beside it"
    assert not opened(0.08), "people wait for one that inches"

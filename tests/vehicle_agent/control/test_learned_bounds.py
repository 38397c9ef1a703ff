"""A vehicle outside the identified range is stopped with a clear word, and drives again when it is not."""

import msgspec
import pytest

from contract.geometry import Pose2
from vehicle_agent.control.learned_bounds import LearnedBounds, LearnedBoundsState
from vehicle_agent.signals import Ego, VehicleMotion

BOUNDS = LearnedBounds()
MOTION = VehicleMotion(1, 2.0, 0.0, 0.0, 0.0, True, False, True, 1.0)
EGO = Ego(7, Pose2(0.0, 0.0, 0.0), 2.0, 0.0, 0.0, 0.0, 0.02, 1, True)


def after(seconds: float, state: LearnedBoundsState, **at_bound: bool) -> LearnedBoundsState:
    for _ in range(round(seconds / 0.02)):
        state, _ = BOUNDS.step(
            state, at_bound.get("steering", False), at_bound.get("pedals", False), EGO, MOTION
        )
    return state


@pytest.mark.parametrize("which", ["steering", "pedals"])
def test_a_correction_that_stays_at_its_bound_is_a_fault(which: str) -> None:
    assert not after(1.4, LearnedBoundsState(), **{which: True}).faults
    state = after(1.6, LearnedBoundsState(), **{which: True})
    assert [(fault.code, fault.severity) for fault in state.faults] == [(f"{which}_unlike_profile", "stop")]
    assert after(5.0, state, **{which: True}).faults == state.faults


def test_a_short_touch_is_none() -> None:
    state = LearnedBoundsState()
    for _ in range(10):
        state = after(1.2, after(1.0, state, steering=True))
    assert not after(0.3, state, steering=True).faults


def test_it_ends_at_a_stand_and_what_was_learned_begins_again() -> None:
    state = after(2.0, LearnedBoundsState(), pedals=True)
    standing = msgspec.structs.replace(MOTION, speed_mps=0.0)
    state, begins_again = BOUNDS.step(state, False, True, EGO, standing)
    assert begins_again
    assert state == LearnedBoundsState()
    assert BOUNDS.step(state, False, True, EGO, standing) == (LearnedBoundsState(), False)

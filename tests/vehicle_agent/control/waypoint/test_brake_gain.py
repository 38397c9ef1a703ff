import msgspec
import pytest

from contract.geometry import Pose2
from vehicle_agent.control.waypoint.brake_gain import BrakeGain, BrakeGainState
from vehicle_agent.signals import Ego, VehicleMotion

GAIN = BrakeGain()


def learned(
    true_share: float, seconds: float, command_mps2: float = -0.72, reported_brake: float = 0.4
) -> BrakeGainState:
    """The state after a steady braking of a vehicle whose brake gives true_share of its map."""
    state = BrakeGainState()
    motion = VehicleMotion(1, 2.0, 0.0, 0.0, reported_brake, True, False, True, 1.0)
    for tick in range(round(seconds * 50)):
        mapped_mps2 = (-command_mps2 - GAIN.coast_mps2) / state.share
        accel_mps2 = -(true_share * mapped_mps2 + GAIN.coast_mps2)
        ego = Ego(tick, Pose2(0.0, 0.0, 0.0), 2.0, accel_mps2, 0.0, 0.0, 0.02, tick, True)
        state = GAIN.step(state, command_mps2, 0.4, ego, motion)
    return state


@pytest.mark.parametrize("share", [0.8, 1.0, 1.2])
def test_the_share_of_a_weaker_or_stronger_brake_is_learned(share: float) -> None:
    assert learned(share, 60.0).share == pytest.approx(share, abs=0.02)


def test_one_short_braking_changes_little() -> None:
    assert abs(learned(0.7, 2.0).share - 1.0) < 0.03


def test_the_share_stays_within_its_bounds() -> None:
    assert learned(0.1, 300.0).share == GAIN.share_min
    assert learned(9.0, 300.0).share == GAIN.share_max


def test_a_gentle_braking_teaches_nothing() -> None:
    assert learned(0.5, 60.0, command_mps2=-0.2).share == 1.0


def test_a_brake_that_was_not_commanded_teaches_nothing() -> None:
    assert learned(2.0, 60.0, reported_brake=0.9).share == 1.0


def test_a_measurement_that_is_not_finite_teaches_nothing() -> None:
    motion = VehicleMotion(1, 2.0, 0.0, 0.0, 0.4, True, False, True, 1.0)
    ego = Ego(1, Pose2(0.0, 0.0, 0.0), 2.0, float("nan"), 0.0, 0.0, 0.02, 1, True)
    state = BrakeGainState(1.1, 5.0, -0.72)
    assert GAIN.step(state, -0.72, 0.4, ego, motion) == msgspec.structs.replace(
        state, steady_s=0.0, command_mps2=0.0
    )

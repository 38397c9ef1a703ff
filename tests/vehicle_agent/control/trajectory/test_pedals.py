"""From an acceleration to the pedals and back."""

import numpy as np
import pytest

from vehicle_agent.control.actuators import Drivetrain, pedal_accel_mps2
from vehicle_agent.control.trajectory.pedals import PedalController, PedalState

ROW = Drivetrain().row()


@pytest.mark.parametrize("accel", np.linspace(-2.5, 0.8, 34))
@pytest.mark.parametrize("speed", [0.0, 1.0, 3.0, 4.2])
def test_the_pedals_give_the_acceleration_they_were_asked_for(accel: float, speed: float) -> None:
    foot = PedalState(holding=False)
    for _ in range(3):
        foot = PedalController().step(foot, accel, speed, Drivetrain())
    given = pedal_accel_mps2(foot.throttle_ratio, foot.brake_ratio, speed, ROW)
    # Between the pedals nothing is pressed: there the vehicle coasts.
    assert given == pytest.approx(accel, abs=0.061 if abs(accel + 0.15) < 0.061 else 1e-3)


def test_the_foot_is_on_one_pedal_only_and_stays_there_for_a_whim() -> None:
    pedalling, foot = PedalController(), PedalState(holding=False)
    sides = []
    for whim in (0.03, -0.03, 0.03, -0.03):
        foot = pedalling.step(foot, -0.15 + whim, 2.0, Drivetrain())
        sides.append(foot.braking)
        assert foot.throttle_ratio == 0.0 or foot.brake_ratio == 0.0
    assert len(set(sides)) == 1


def test_when_the_vehicle_sets_off_the_brake_goes_only_while_the_throttle_comes() -> None:
    pedals, foot = PedalController(), PedalState()
    for _ in range(100):
        foot = pedals.hold(foot)
    brakes = []
    for _ in range(10):
        foot = pedals.step(foot, 0.5, 0.0, Drivetrain())
        assert foot.throttle_ratio > 0.0
        brakes.append(foot.brake_ratio)
    assert brakes[:6] == pytest.approx([0.4, 0.3, 0.2, 0.1, 0.0, 0.0], abs=1e-9)
    assert brakes[6:] == [0.0] * 4
    assert not foot.holding


def test_holding_comes_gently_and_stays() -> None:
    pedalling, foot = PedalController(), PedalState(holding=False)
    brakes = []
    for _ in range(100):
        foot = pedalling.hold(foot)
        brakes.append(foot.brake_ratio)
    assert np.diff(brakes).max() <= 0.02 + 1e-12
    assert brakes[-1] == pedalling.hold_ratio

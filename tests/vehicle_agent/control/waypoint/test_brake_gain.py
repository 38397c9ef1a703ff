import math

import msgspec
import pytest

from contract.geometry import Pose2
from simulator.vehicle.plant import CMD_BRAKE, CMD_DIRECTION, CMD_THROTTLE, Plant, PlantParams
from vehicle_agent.brake_map import BrakeMap
from vehicle_agent.control.waypoint.brake_gain import BrakeGain, BrakeGainState
from vehicle_agent.control.waypoint.twist import TwistController, TwistState
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


def overruns_m(brake_full_mps2: float, stops: int, gain: BrakeGain) -> list[float]:
    """How far the vehicle stops beyond each of the stops, with the map of a brake of 5.6 m/s2."""
    twist = TwistController(brakes=BrakeMap(0.2473, 0.5695, 0.1), coast_mps2=gain.coast_mps2)
    found, state = [], BrakeGainState()
    for _ in range(stops):
        plant = Plant((PlantParams(brake_full_mps2=brake_full_mps2),), (Pose2(0.0, 0.0, 0.0),))
        plant.commands[0, CMD_DIRECTION] = 1.0
        plant.place(0, Pose2(0.0, 0.0, 0.0), 3.0)
        pedals = TwistState()
        for tick in range(1000):
            truth = plant.view(0)
            left_m = max(0.0, 12.0 - truth.pose_map.x_m)
            wanted_mps = math.sqrt(2.0 * 0.7 * left_m) if left_m < 6.5 else 3.0
            slope_mps2 = -0.7 if left_m < 6.5 else 0.0
            ego = Ego(tick, truth.pose_map, truth.speed_mps, truth.accel_mps2, 0.0, 0.0, 0.02, tick, True)
            motion = VehicleMotion(tick, truth.speed_mps, 0.0, 0.0, truth.brake_ratio, True, False, True, 1.0)
            state = gain.step(state, pedals.accel_command_mps2, pedals.brake_ratio, ego, motion)
            pedals = twist.step(
                pedals, wanted_mps, slope_mps2, truth.speed_mps, truth.accel_mps2, state.share
            )
            plant.commands[0, CMD_THROTTLE] = pedals.throttle_ratio
            plant.commands[0, CMD_BRAKE] = pedals.brake_ratio
            plant.step(0.02)
            if truth.speed_mps == 0.0:
                break
        found.append(plant.view(0).pose_map.x_m - 12.0)
    return found


def test_stops_of_a_weaker_brake_come_nearer_to_those_of_the_maps_brake() -> None:
    gain = BrakeGain()
    nominal_m = overruns_m(5.6, 1, gain)[0]
    found_m = overruns_m(4.2, 10, gain)
    assert abs(found_m[-1] - nominal_m) < 0.6 * abs(found_m[0] - nominal_m)

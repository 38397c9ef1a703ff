"""What the module reports of a vehicle that rolls: each wheel turns as the ground under it goes by."""

import math

import pytest

from simulator.ecus.report_frames import TRACK_WIDTH_M, WHEEL_RADIUS_M
from simulator.ecus.safety_driver import SafetyDriver
from tests.simulator.ecus.can_driver import CanDriver
from vehicle_agent.can.dbc import layouts
from vehicle_agent.signals import Actuation, Gear

WHEELS = ("front_left", "front_right", "rear_left", "rear_right")


def driven(gear: Gear, steer_rad: float) -> tuple[dict[str, float], float, float, float]:
    """(the wheels' newest report, the speed, the turning rate, the wheelbase) after some seconds."""
    driver = CanDriver()
    driver.run(4.0, Actuation(True, gear, steer_rad, 0.3, 0.0))
    layout = layouts()["wheel_report"]
    newest = [frame for frame in driver.heard if frame.arbitration_id == layout.arbitration_id][-1]
    truth = driver.fleet.truth("s1")
    return (
        layout.unpack(newest.data),
        truth.speed_mps,
        truth.yaw_rate_radps,
        driver.profile.body.wheelbase_m,
    )


@pytest.mark.parametrize(("gear", "sign"), [("drive", 1.0), ("reverse", -1.0)])
def test_on_a_straight_all_wheels_turn_alike_and_the_way_the_vehicle_goes(gear: Gear, sign: float) -> None:
    wheels, speed_mps, _, _ = driven(gear, 0.0)
    assert sign * speed_mps > 0.5
    for name in WHEELS:
        assert wheels[name] * WHEEL_RADIUS_M == pytest.approx(speed_mps, abs=0.06), name


def test_on_a_bend_to_the_left_the_right_wheels_go_farther_and_the_front_ones_than_the_rear() -> None:
    wheels, speed_mps, spin, wheelbase_m = driven("drive", 0.3)
    assert spin > 0.1
    left, right = speed_mps - spin * TRACK_WIDTH_M / 2.0, speed_mps + spin * TRACK_WIDTH_M / 2.0
    for name, wanted_mps in (
        ("rear_left", left),
        ("rear_right", right),
        ("front_left", math.hypot(left, spin * wheelbase_m)),
        ("front_right", math.hypot(right, spin * wheelbase_m)),
    ):
        assert wheels[name] * WHEEL_RADIUS_M == pytest.approx(wanted_mps, abs=0.06), name


def test_the_wheel_turns_no_faster_than_the_command_says() -> None:
    driver = CanDriver()
    driver.run(1.0, Actuation(True, "drive", 0.0, 0.0, 0.0))
    driver.run(0.3, Actuation(True, "drive", 0.4, 0.0, 0.0))
    before_rad = driver.fleet.truth("s1").steer_rad
    driver.run(0.2, Actuation(True, "drive", 0.4, 0.0, 0.0))
    rate_radps = (driver.fleet.truth("s1").steer_rad - before_rad) / 0.2
    limit_radps = driver.profile.limits.steer_rate_radps_max
    assert 0.5 * limit_radps < rate_radps < 1.3 * limit_radps


def test_the_wheel_is_reported_as_turned_by_hand_only_while_hands_are_on_it() -> None:
    driver, layout = CanDriver(), layouts()["steering_report"]
    driver.run(3.0, Actuation(True, "drive", 0.3, 0.1, 0.0))

    def newest() -> dict[str, float]:
        frames = [frame for frame in driver.heard if frame.arbitration_id == layout.arbitration_id]
        return layout.unpack(frames[-1].data)

    assert abs(newest()["output"]) > 1.0
    assert newest()["manual"] == 0.0
    driver.module.driver = SafetyDriver(steer_rad=0.2)
    driver.run(1.0, Actuation(True, "drive", 0.3, 0.1, 0.0))
    assert newest()["manual"] == newest()["output"] != 0.0

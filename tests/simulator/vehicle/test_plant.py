import math
from itertools import pairwise

import numpy as np
import pytest

from contract.geometry import Pose2
from simulator.vehicle.plant import (
    CMD_BRAKE,
    CMD_DIRECTION,
    CMD_LOCK,
    CMD_STEER,
    CMD_THROTTLE,
    SIDE_SPEED,
    SPEED,
    STEER,
    Plant,
    PlantParams,
    brake_decel,
    plant_params,
)
from vehicle_agent.config import Body, Limits, Profile

ORIGIN = Pose2(0.0, 0.0, 0.0)


def a_plant(params: PlantParams | None = None, speed_mps: float = 0.0) -> Plant:
    plant = Plant((params or PlantParams(),), (ORIGIN,))
    plant.commands[0, CMD_DIRECTION] = 1.0
    plant.state[0, SPEED] = speed_mps
    return plant


def test_full_brake_from_3_mps_stops_in_1_6_m_and_0_8_s() -> None:
    plant = a_plant(speed_mps=3.0)
    plant.commands[0, CMD_BRAKE] = 1.0
    elapsed_s = 0.0
    while plant.view(0).speed_mps > 0.0:
        plant.step(0.005)
        elapsed_s += 0.005
        assert elapsed_s < 10.0, "the shuttle never stands"
    assert plant.view(0).odometer_m == pytest.approx(1.6, abs=0.1)
    assert elapsed_s == pytest.approx(0.8, abs=0.05)


def test_a_standing_vehicle_stands() -> None:
    plant = a_plant()
    for throttle, brake in ((0.0, 0.0), (0.0, 1.0), (0.04, 0.0)):
        plant.commands[0, CMD_THROTTLE], plant.commands[0, CMD_BRAKE] = throttle, brake
        plant.step(10.0)
        view = plant.view(0)
        assert (view.pose_map, view.speed_mps, view.accel_mps2) == (ORIGIN, 0.0, 0.0)


def test_a_command_acts_only_after_its_delay() -> None:
    params = PlantParams(throttle_delay_s=0.25, steer_delay_s=0.1)
    plant = a_plant(params)
    plant.commands[0, CMD_THROTTLE], plant.commands[0, CMD_STEER] = 1.0, 0.3
    plant.step(0.095)
    assert plant.state[0, STEER] == 0.0
    plant.step(0.02)
    assert plant.state[0, STEER] > 0.0
    assert plant.view(0).speed_mps == 0.0
    plant.step(0.3)
    assert plant.view(0).speed_mps > 0.0


def test_steering_never_turns_faster_than_its_rate_nor_past_its_lock() -> None:
    params = PlantParams(steer_delay_s=0.0, steer_rate_radps_max=0.8, steer_rad_max=0.48)
    plant = a_plant(params)
    plant.commands[0, CMD_STEER] = 2.0
    before = 0.0
    for _ in range(400):
        plant.step(0.005)
        now = float(plant.state[0, STEER])
        assert now - before <= 0.8 * 0.005 + 1e-12
        before = now
    assert before == pytest.approx(0.48, abs=1e-3)


def test_constant_steering_drives_the_circle_of_the_bicycle_model() -> None:
    params = PlantParams(rolling_drag_mps2=0.0, speed_drag_1ps=0.0)
    plant = a_plant(params, speed_mps=2.0)
    plant.state[0, STEER] = 0.3
    plant._history[0, :, CMD_STEER] = 0.3
    plant.commands[0, CMD_STEER] = 0.3
    radius_m = params.wheelbase_m / math.tan(0.3)
    for _ in range(200):
        plant.step(0.02)
        pose = plant.view(0).pose_map
        assert math.hypot(pose.x_m, pose.y_m - radius_m) == pytest.approx(radius_m, abs=1e-3)


def test_reverse_drives_backwards_and_park_holds() -> None:
    plant = a_plant()
    plant.commands[0, CMD_DIRECTION], plant.commands[0, CMD_THROTTLE] = -1.0, 0.5
    plant.step(2.0)
    assert plant.view(0).pose_map.x_m < -0.5
    plant.commands[0, CMD_DIRECTION], plant.commands[0, CMD_LOCK] = 0.0, 1.0
    plant.step(2.0)
    assert plant.view(0).speed_mps == 0.0


def test_the_brake_map_is_zero_at_rest_full_at_one_and_rising() -> None:
    decels = [brake_decel(b, 5.6, 0.1) for b in np.linspace(0.0, 1.0, 101)]
    assert decels[0] == 0.0
    assert decels[-1] == pytest.approx(5.6)
    assert all(a < b for a, b in pairwise(decels))


def test_driving_empties_the_battery_faster_than_standing() -> None:
    still, driving = a_plant(), a_plant()
    driving.commands[0, CMD_THROTTLE] = 0.5
    still.step(60.0)
    driving.step(60.0)
    assert 1.0 > still.view(0).battery_ratio > driving.view(0).battery_ratio > 0.9


def test_vehicles_do_not_disturb_each_other() -> None:
    pair = Plant((PlantParams(), PlantParams()), (ORIGIN, Pose2(50.0, 0.0, 1.0)))
    pair.commands[0, CMD_DIRECTION], pair.commands[0, CMD_THROTTLE] = 1.0, 0.6
    pair.step(5.0)
    alone = a_plant()
    alone.commands[0, CMD_THROTTLE] = 0.6
    alone.step(5.0)
    assert pair.view(0) == alone.view(0)
    assert pair.view(1).pose_map == Pose2(50.0, 0.0, 1.0)


def test_the_profile_gives_geometry_and_full_brake() -> None:
    params = plant_params(Profile(body=Body(wheelbase_m=1.75), limits=Limits(decel_mps2_max=4.0)))
    assert params.wheelbase_m == 1.75
    assert params.brake_full_mps2 == 4.0


def turning(speed_mps: float, steer_rad: float, **params: float) -> Plant:
    """A vehicle with tyres, after four seconds of driving a constant steering angle."""
    whole = PlantParams(tyres=True, rolling_drag_mps2=0.0, speed_drag_1ps=0.0, steer_delay_s=0.0, **params)
    plant = a_plant(whole, speed_mps)
    plant.commands[0, CMD_STEER] = steer_rad
    for _ in range(800):
        # Cornering costs speed; this is about turning.
        plant.state[0, SPEED] = speed_mps
        plant.step(0.005)
    return plant


def test_tyres_turn_a_steady_circle_by_the_understeer_gradient() -> None:
    p, v, steer = PlantParams(), 4.0, 0.05
    front = p.cog_ratio * p.wheelbase_m
    rear = p.wheelbase_m - front
    understeer = p.mass_kg / p.wheelbase_m * (rear / p.cornering_front_npr - front / p.cornering_rear_npr)
    plant = turning(v, steer)
    yaw_rate = plant.view(0).yaw_rate_radps
    assert yaw_rate == pytest.approx(v * steer / (p.wheelbase_m + understeer * v * v), rel=5e-3)
    slip = -p.mass_kg * front / (p.wheelbase_m * p.cornering_rear_npr) * v * yaw_rate
    assert plant.state[0, SIDE_SPEED] == pytest.approx(v * slip, rel=2e-2)


def test_friction_limits_how_hard_a_vehicle_with_tyres_can_turn() -> None:
    plant = turning(7.0, 0.4, friction=0.3)
    assert plant.view(0).yaw_rate_radps * 7.0 < 0.3 * 9.81 * 1.05


def test_at_walking_pace_tyres_roll_where_they_point() -> None:
    slow = turning(0.8, 0.3)
    assert slow.view(0).yaw_rate_radps == pytest.approx(0.8 * math.tan(0.3) / 2.6, rel=1e-6)
    assert slow.state[0, SIDE_SPEED] == 0.0


def test_tyres_are_steady_at_every_speed() -> None:
    for v in np.arange(0.0, 8.0, 0.25):
        plant = turning(float(v), 0.1)
        before = plant.view(0).yaw_rate_radps
        plant.state[0, SPEED] = v
        plant.step(0.005)
        assert plant.view(0).yaw_rate_radps == pytest.approx(before, abs=1e-3)


def test_a_heavier_vehicle_answers_its_pedals_less() -> None:
    heavy, usual = a_plant(PlantParams(load_kg=350.0)), a_plant()
    for plant in (heavy, usual):
        plant.commands[0, CMD_THROTTLE] = 0.5
        plant.step(1.0)
    drag = PlantParams().rolling_drag_mps2
    gained, at_most = heavy.view(0).accel_mps2 + drag, usual.view(0).accel_mps2 + drag
    assert gained == pytest.approx(at_most * 1400.0 / 1750.0, rel=0.05)


def test_wheels_that_stand_off_turn_what_reports_straight() -> None:
    plant = a_plant(PlantParams(steer_bias_rad=0.01), speed_mps=3.0)
    plant.step(1.0)
    assert plant.view(0).steer_rad == 0.0
    assert plant.view(0).yaw_rate_radps == pytest.approx(plant.view(0).speed_mps * math.tan(0.01) / 2.6)


def test_a_slope_rolls_a_vehicle_that_nothing_holds() -> None:
    plant = a_plant(PlantParams(grade_ratio=0.05))
    plant.step(2.0)
    assert plant.view(0).pose_map.x_m < -0.3
    plant.place(0, ORIGIN)
    plant.commands[0, CMD_BRAKE] = 1.0
    plant.step(1.0)
    plant.place(0, ORIGIN)
    plant.step(2.0)
    assert plant.view(0).speed_mps == 0.0


def test_road_under_one_vehicle_slows_it_alone() -> None:
    plant = Plant((PlantParams(), PlantParams()), (ORIGIN, ORIGIN))
    plant.state[:, SPEED] = 3.0
    plant.grades[0] = 0.04
    plant.step(0.5)
    slower, level = plant.view(0), plant.view(1)
    assert slower.speed_mps == pytest.approx(level.speed_mps - 0.5 * 9.81 * 0.04, rel=2e-3)
    assert (slower.grade_ratio, level.grade_ratio) == (0.04, 0.0)
    plant.grades[0] = 0.0
    plant.step(0.5)
    assert plant.view(0).accel_mps2 == pytest.approx(level.accel_mps2, abs=0.02)


def test_inclined_site_is_a_grade_uphill_and_downhill() -> None:
    plant = a_plant(PlantParams(slope_ratio=0.02, slope_direction_rad=0.0))
    assert plant.view(0).grade_ratio == pytest.approx(0.02)
    plant.place(0, Pose2(0.0, 0.0, math.pi))
    assert plant.view(0).grade_ratio == pytest.approx(-0.02)


def test_wheels_slip_under_the_force_of_the_drive_and_uphill() -> None:
    assert a_plant(speed_mps=3.0).view(0).wheel_ratio == 1.0
    plant = a_plant(PlantParams(wheel_slip_s2pm=0.01), speed_mps=3.0)
    plant.commands[0, CMD_THROTTLE] = 1.0
    plant.step(1.0)
    driven = plant.view(0)
    assert driven.accel_mps2 > 0.5
    assert driven.wheel_ratio == pytest.approx(1.0 + 0.01 * driven.accel_mps2)
    plant.grades[0] = 0.05
    assert plant.view(0).wheel_ratio == pytest.approx(driven.wheel_ratio + 0.01 * 9.81 * 0.05)


def test_braked_wheels_turn_too_slowly_and_worn_ones_too_fast() -> None:
    plant = a_plant(PlantParams(wheel_slip_s2pm=0.01), speed_mps=4.0)
    plant.commands[0, CMD_BRAKE] = 0.6
    plant.step(0.5)
    assert plant.view(0).wheel_ratio < 0.995
    assert a_plant(PlantParams(wheel_radius_ratio=0.98)).view(0).wheel_ratio == pytest.approx(1.0 / 0.98)

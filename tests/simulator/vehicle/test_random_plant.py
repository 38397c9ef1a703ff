import math
from dataclasses import fields

import numpy as np
import pytest

from contract.geometry import Pose2
from simulator.vehicle.plant import (
    CMD_BRAKE,
    CMD_DIRECTION,
    CMD_STEER,
    PLAYED,
    SPEED,
    STEER,
    Plant,
    PlantParams,
    brake_force_mps2,
    plant_params,
)
from simulator.vehicle.random_plant import PlantRanges, random_plant
from simulator.world import WorldOptions
from vehicle_agent.config import Profile

ORIGIN = Pose2(0.0, 0.0, 0.0)


def test_a_seed_gives_the_same_plant_and_another_seed_another() -> None:
    assert random_plant(Profile(), 3, "a") == random_plant(Profile(), 3, "a")
    assert random_plant(Profile(), 3, "a") != random_plant(Profile(), 4, "a")


def test_vehicles_of_one_seed_have_different_plants() -> None:
    drawn = WorldOptions(plant_seed=1).plants_of({"a": Profile(), "b": Profile()})
    assert drawn["a"] != drawn["b"]


def test_without_a_plant_seed_the_plants_are_nominal() -> None:
    assert WorldOptions().plants_of({"a": Profile()}) == {}


def test_a_named_plant_is_not_drawn() -> None:
    mine = PlantParams(mass_kg=1000.0)
    assert WorldOptions(plants={"a": mine}, plant_seed=1).plants_of({"a": Profile()}) == {"a": mine}


def test_shares_are_of_the_profiles_own_body() -> None:
    nominal = plant_params(Profile())
    for seed in range(20):
        drawn = random_plant(Profile(), seed)
        assert abs(drawn.load_kg) <= 0.2 * nominal.mass_kg
        assert drawn.wheelbase_m == pytest.approx(nominal.wheelbase_m, rel=0.02)
        assert 0.8 <= drawn.brake_delay_s / nominal.brake_delay_s <= 1.2


def test_every_range_changes_the_plant() -> None:
    fixed = PlantRanges(**{f.name: (_middle(f.default),) * 2 for f in fields(PlantRanges)})
    before = random_plant(Profile(), 1, ranges=fixed)
    for field in fields(PlantRanges):
        low, _ = field.default  # type: ignore[misc]
        moved = PlantRanges(
            **{f.name: getattr(fixed, f.name) for f in fields(PlantRanges)} | {field.name: (low, low)}
        )
        assert random_plant(Profile(), 1, ranges=moved) != before, field.name


def _middle(interval: object) -> float:
    low, high = interval  # type: ignore[misc]
    return 0.5 * (low + high) + 0.1 * (high - low)


def test_wheels_with_play_move_only_after_the_steering_has_taken_it_up() -> None:
    plant = Plant((PlantParams(steer_play_rad=0.02, steer_delay_s=0.0, steer_lag_s=0.0),), (ORIGIN,))
    plant.commands[0, CMD_STEER] = 0.1
    plant.step(1.0)
    assert plant.state[0, PLAYED] == pytest.approx(0.09)
    plant.commands[0, CMD_STEER] = 0.085
    plant.step(1.0)
    assert plant.state[0, STEER] == pytest.approx(0.085)
    assert plant.state[0, PLAYED] == pytest.approx(0.09)


def test_a_sloping_site_slows_a_vehicle_uphill_and_not_across() -> None:
    speeds = []
    for yaw_rad in (0.0, 0.5 * math.pi, math.pi):
        plant = Plant((PlantParams(slope_ratio=0.02, rolling_drag_mps2=0.0, speed_drag_1ps=0.0),), (ORIGIN,))
        plant.commands[0, CMD_DIRECTION] = 1.0
        plant.place(0, Pose2(0.0, 0.0, yaw_rad), 3.0)
        plant.step(1.0)
        speeds.append(float(plant.state[0, SPEED]))
    assert speeds == pytest.approx([3.0 - 0.1962, 3.0, 3.0 + 0.1962], abs=1e-6)


def test_a_drawn_brake_rises_with_the_pedal() -> None:
    for seed in range(10):
        row = random_plant(Profile(), seed).row()
        decels = [brake_force_mps2(float(b), 2.0, row) for b in np.linspace(0.0, 1.0, 30)]
        assert np.all(np.diff(decels) > 0.0)


def test_a_nominal_plant_moves_as_its_formula_says() -> None:
    plant = Plant((PlantParams(brake_delay_s=0.0, brake_lag_s=0.0),), (ORIGIN,))
    plant.commands[0, CMD_DIRECTION], plant.commands[0, CMD_BRAKE] = 1.0, 0.6
    plant.place(0, ORIGIN, 3.0)
    plant.step(0.005)
    decel = 0.1 * (57.0**0.6 - 1.0) + 0.12 + 0.02 * 3.0
    assert plant.view(0).accel_mps2 == pytest.approx(-decel)

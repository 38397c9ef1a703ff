"""A scooter that rides out from behind parked cars, before vehicles whose brakes are not the profile's."""

from pathlib import Path

import pytest

from campusloop.scenes.drive import SceneDrive
from campusloop.scenes.protection.braking_oracle import best_braking
from campusloop.scenes.protection.cells import cells
from vehicle_agent.config import load_profile

PROFILE = load_profile(Path(__file__).parents[4] / "vehicle_agent" / "profiles" / "snow-lion.toml")
# Drawn vehicles whose brakes are slower and weaker; with 2.2 m/s of who may come, both touched the scooter.
DRAWN = (("day", 100_305), ("night", 101_167))


@pytest.mark.parametrize(("light", "plant_seed"), DRAWN)
def test_who_comes_from_behind_parked_cars_is_not_touched_by_a_vehicle_with_weaker_brakes(
    light: str, plant_seed: int
) -> None:
    name = f"{light}-hidden-scooter-15-1.5-0.25-10.0"
    (cell,) = (cell for cell in cells(PROFILE.body) if cell.name == name)
    assert best_braking(cell, PROFILE.body, PROFILE.lidar.x_m).impact_mps is None
    run = SceneDrive(cell.scene(PROFILE, 1).with_plant(plant_seed)).run()
    assert not [number for _, number, _ in run.metrics.front_contacts if number == 1]
    assert run.time_s is not None

"""Facades as a beam meets them, whichever way round an outline runs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.roads.model import Building
from simulator.sensors.scene.buildings import add_buildings, altered_buildings
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.ground import Ground, GroundParams
from simulator.sensors.scene.materials import Material
from simulator.sensors.scene.mesh import Mesh
from simulator.sensors.scene.static_scene import CastScene
from tests.simulator.sensors.scene.campus import a_street

GROUND = Ground(a_street(60), 1, GroundParams(0.0, 0.0, 3.5, 0.0, 0.0))
OUTLINE = ((10.0, 8.0), (34.0, 8.0), (34.0, 20.0), (10.0, 20.0))


def facade(outline: tuple[tuple[float, float], ...], seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Where beams along +y from y = 0 meet the south wall at y = 8, and its materials there."""
    mesh = Mesh()
    add_buildings(mesh, GROUND, (Building(outline, 9.9),), seed)
    scene = CastScene(mesh.packed())
    across, up = np.meshgrid(np.arange(10.3, 33.7, 0.11), np.arange(0.2, 9.8, 0.13))
    origins = np.column_stack((across.ravel(), np.zeros(across.size), up.ravel())).astype(np.float32)
    rays = np.tile(np.array([0.0, 1.0, 0.0], dtype=np.float32), (len(origins), 1))
    reach, hit = scene.cast(origins, rays, np.full(len(origins), 50.0, dtype=np.float32))
    assert (hit >= 0).all()
    return reach.astype(np.float64), scene.surfaces.materials[hit]


@given(st.integers(0, 10_000), st.booleans(), st.integers(0, 3))
@settings(max_examples=25, deadline=None)
def test_panes_stand_back_and_the_wall_does_not(seed: int, is_turned: bool, first: int) -> None:
    outline = OUTLINE[first:] + OUTLINE[:first]
    reach, materials = facade(outline[::-1] if is_turned else outline, seed)
    panes = materials == Material.GLASS
    assert 0.1 < panes.mean() < 0.6
    assert ((reach[panes] > 8.11) & (reach[panes] < 8.31)).all()
    walls = (materials == Material.BRICK) | (materials == Material.PLASTER)
    # Columns stand up to 0.45 m before the wall.
    assert ((reach[walls] > 7.54) & (reach[walls] < 8.31)).all()
    assert (np.abs(reach[walls] - 8.0) < 1e-3).mean() > 0.7


def test_house_has_the_height_of_the_map() -> None:
    mesh = Mesh()
    add_buildings(mesh, GROUND, (Building(OUTLINE, 9.9),), 1)
    assert mesh.packed().triangles[:, :, 2].max() == pytest.approx(9.9)


@given(st.integers(0, 1000))
@settings(max_examples=50, deadline=None)
def test_more_changes_keep_those_that_were_there(seed: int) -> None:
    houses = tuple(
        Building(tuple((x + 50.0 * k, y) for x, y in OUTLINE), 6.0 + k, f"house {k}") for k in range(12)
    )
    few = altered_buildings(houses, WorldChanges(seed=seed, buildings_altered_ratio=0.2))
    many = altered_buildings(houses, WorldChanges(seed=seed, buildings_altered_ratio=0.7))
    unaltered = {house for house in houses if house in many}
    assert unaltered <= set(few)
    assert {house for house in few if house not in houses} <= set(many)
    assert altered_buildings(houses, WorldChanges(seed=seed)) == houses

"""Rays meet placed bodies where they meet the same triangles in a scene that is built for the moment."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulator.sensors.scene import shapes
from simulator.sensors.scene.mesh import joined
from simulator.sensors.scene.placed_bodies import PlacedBodies, Template
from simulator.sensors.scene.static_scene import CastScene

MESHES = (shapes.person(1.75, 0.3), shapes.car(), shapes.cyclist())
TEMPLATES = tuple(Template(mesh) for mesh in MESHES)


def rays_around(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """From near the origin, in the order of a sensor that turns: columns of 16 rays."""
    turn = np.sort(rng.uniform(0.0, 2.0 * math.pi, count // 16)).repeat(16)
    up = np.tile(np.linspace(-0.3, 0.1, 16), count // 16)
    level = np.cos(up)
    ways = np.column_stack((level * np.cos(turn), level * np.sin(turn), np.sin(up)))
    origins = np.column_stack((rng.uniform(-0.5, 0.5, (count, 2)), np.full(count, 1.8)))
    return origins.astype(np.float32), ways.astype(np.float32)


@given(seed=st.integers(0, 10_000), count=st.integers(0, 12), reach_m=st.sampled_from([4.0, 15.0, 60.0]))
def test_rays_meet_what_they_meet_in_a_built_scene(seed: int, count: int, reach_m: float) -> None:
    rng = np.random.default_rng(seed)
    chosen = np.sort(rng.integers(0, len(MESHES), count))
    # Some stand where the sensor is.
    poses = np.column_stack(
        (rng.normal(0.0, 8.0, (count, 2)), rng.uniform(-0.2, 0.2, count), rng.uniform(-4.0, 4.0, count))
    )
    scales = rng.uniform(0.7, 1.4, (count, 3))
    numbers = rng.permutation(1000)[:count]
    placed = PlacedBodies(TEMPLATES, chosen, poses, scales, numbers)
    origins, ways = rays_around(rng, 1600)
    reach = np.full(len(origins), reach_m, dtype=np.float32)
    near_m, triangles = placed.cast(origins, ways, reach)
    met = triangles >= 0
    np.testing.assert_array_equal(near_m[~met], reach[~met])
    assert count or not met.any()
    if not count:
        return
    built = CastScene(
        joined(
            [
                MESHES[kind].placed(poses[k : k + 1], scales[k : k + 1], numbers=numbers[k : k + 1])
                for k, kind in enumerate(chosen.tolist())
            ]
        )
    )
    there_m, there = built.cast(origins, ways, reach)
    # A ray along an edge may pass it by rounding.
    both = met & (there >= 0)
    assert np.count_nonzero(met ^ (there >= 0)) <= 3
    assert np.count_nonzero(np.abs(near_m[both] - there_m[both]) > 2e-3) <= 3
    same = both & (triangles == there)
    assert np.count_nonzero(both & ~same) <= 3 + 0.02 * np.count_nonzero(both)
    np.testing.assert_allclose(
        placed.surfaces.normals[triangles[same]], built.surfaces.normals[there[same]], atol=2e-3
    )
    np.testing.assert_array_equal(
        placed.surfaces.objects[triangles[same]], built.surfaces.objects[there[same]]
    )
    np.testing.assert_allclose(placed.triangles, built.triangles, atol=1e-4)


def test_a_body_behind_another_is_not_met() -> None:
    poses = np.array([[5.0, 0.0, 0.0, 0.0], [8.0, 0.0, 0.0, 0.0]])
    placed = PlacedBodies(TEMPLATES, np.array([1, 1]), poses, np.ones((2, 3)), np.array([7, 8]))
    origin, way = np.array([[0.0, 0.0, 0.7]], np.float32), np.array([[1.0, 0.0, 0.0]], np.float32)
    near_m, triangles = placed.cast(origin, way, np.array([50.0], np.float32))
    assert placed.surfaces.objects[triangles[0]] == 7
    assert near_m[0] == pytest.approx(5.0 - 2.2, abs=0.4)

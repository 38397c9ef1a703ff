import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simulator.sensors.scene.ray_bundles import passing


def passed(
    origins: np.ndarray, ways: np.ndarray, reach_m: np.ndarray, sphere: np.ndarray
) -> tuple[set[int], set[int]]:
    """(rays that meet the sphere within their reach, rays whose line meets it), as geometry has it."""
    apart = sphere[:3] - origins.astype(float)
    along = (apart * ways).sum(axis=1)
    inside = sphere[3] ** 2 - (apart**2).sum(axis=1) + along**2
    half = np.sqrt(np.maximum(inside, 0.0))
    meets = (inside > 1e-6) & (along + half > 1e-6) & (along - half < reach_m - 1e-6)
    return set(np.flatnonzero(meets)), set(np.flatnonzero(inside > -1e-3))


@settings(deadline=None, max_examples=60)
@given(
    seed=st.integers(0, 2**32 - 1),
    width_rad=st.sampled_from([0.0, 0.05, 0.6, 2.0, math.tau]),
    height_rad=st.sampled_from([0.0, 0.5, 3.0]),
    spread_m=st.sampled_from([0.0, 0.5]),
)
def test_every_ray_that_meets_a_body_is_named_and_few_others(
    seed: int, width_rad: float, height_rad: float, spread_m: float
) -> None:
    """Slices of a turn, rays all round, straight up and down; bodies near and far, and around the sensor."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 300))
    yaw = rng.uniform(-math.pi, math.pi) + np.sort(rng.uniform(-0.5, 0.5, n)) * width_rad
    rise = rng.uniform(-0.5, 0.5, n) * height_rad
    ways = np.column_stack((np.cos(rise) * np.cos(yaw), np.cos(rise) * np.sin(yaw), np.sin(rise)))
    ways = ways.astype(np.float32)
    origins = (rng.normal(0.0, 50.0, 3) + rng.normal(0.0, 1.0, (n, 3)) * spread_m).astype(np.float32)
    reach_m = rng.uniform(0.5, 80.0, n).astype(np.float32)
    distances_m = rng.choice([0.1, 2.0, 20.0, 100.0], 40)[:, None]
    spheres = np.column_stack(
        (origins.mean(axis=0) + rng.normal(0.0, 1.0, (40, 3)) * distances_m, rng.uniform(0.2, 3.0, 40))
    )
    rays, bodies = passing(origins, ways, reach_m, spheres)
    assert (np.diff(bodies) >= 0).all()
    for number, sphere in enumerate(spheres):
        named = set(rays[bodies == number])
        meet, pass_at_all = passed(origins, ways, reach_m, sphere)
        assert meet <= named <= pass_at_all


@pytest.mark.parametrize("count", [0, 1])
def test_without_rays_or_bodies_nothing_passes(count: int) -> None:
    ways, reach_m = np.zeros((count, 3), np.float32), np.ones(count, np.float32)
    rays, bodies = passing(ways, ways, reach_m, np.empty((0, 4)))
    assert len(rays) == len(bodies) == 0

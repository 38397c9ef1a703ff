"""Random numbers, beams, particles: what the filter is made of."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.occupancy.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from vehicle_agent.localization.monte_carlo.beam_support import supported
from vehicle_agent.localization.monte_carlo.likelihood_field import FieldParams, likelihood_field
from vehicle_agent.localization.monte_carlo.particles import (
    climb,
    kld_resampled,
    mean_over_beams,
    move,
    uniform_poses,
)
from vehicle_agent.localization.monte_carlo.random_numbers import generator, normal, uniform

KLD = (0.5, math.radians(15.0), 0.05, 2.33, 100, 5000)


def test_the_generator_draws_the_published_numbers() -> None:
    """xoshiro256** from the state 1, 2, 3, 4; the first outputs of the authors' program."""
    state = np.array([1, 2, 3, 4], dtype=np.uint64)
    expected = [11520, 0, 1509978240, 1215971899390074240]
    assert [uniform(state) for _ in expected] == [(value >> 11) / 2.0**53 for value in expected]


@given(st.integers(0, 2**64 - 1))
def test_equal_seeds_draw_equal_numbers_in_the_unit_interval(seed: int) -> None:
    first, second = generator(seed), generator(seed)
    drawn = [uniform(first) for _ in range(5)]
    assert drawn == [uniform(second) for _ in range(5)]
    assert all(0.0 <= value < 1.0 for value in drawn)


def test_normal_numbers_have_their_mean_and_deviation() -> None:
    state = generator(3)
    drawn = np.array([normal(state) for _ in range(20_000)])
    assert drawn.mean() == pytest.approx(0.0, abs=0.03)
    assert drawn.std() == pytest.approx(1.0, abs=0.03)


def test_a_reading_that_stands_alone_is_not_supported() -> None:
    angles = np.radians(np.arange(0.0, 90.0))
    ranges_m = np.full(90, 3.0)
    ranges_m[[10, 40, 41]] = [9.0, 1.0, 6.0]
    ranges_m[20] = np.nan
    kept = supported(ranges_m, angles, 30.0, 0.1, 4.0).tolist()
    assert kept == [i for i in range(90) if i not in (10, 20, 40, 41)]


@pytest.mark.parametrize("ranges_m", [np.zeros(0), np.full(9, np.nan), np.full(9, 81.9), np.full(9, -2.0)])
def test_a_scan_without_a_return_supports_nothing(ranges_m: np.ndarray) -> None:
    assert len(supported(ranges_m, np.arange(len(ranges_m)) * 0.1, 30.0, 0.1, 4.0)) == 0


def test_motion_without_noise_is_the_way() -> None:
    poses = np.array([[1.0, 2.0, math.pi / 2], [0.0, 0.0, math.pi]])
    move(poses, np.array([1.0, 0.5, 0.1]), 0.0, 0.0, 0.0, 0.0, 0.0, generator(1))
    assert poses == pytest.approx(np.array([[0.5, 3.0, math.pi / 2 + 0.1], [-1.0, -0.5, 0.1 - math.pi]]))


def a_wall() -> OccupancyMap:
    """2 x 2 m, a wall along x = 1.5 m, free before it, unknown behind."""
    cells = np.full((20, 20), FREE, dtype=np.uint8)
    cells[:, 15], cells[:, 16:] = OCCUPIED, UNKNOWN
    return OccupancyMap(cells, 0.1, 0.0, 0.0)


def test_the_field_is_greatest_at_the_wall_and_never_below_the_outliers() -> None:
    field = likelihood_field(a_wall(), FieldParams())
    assert field.hit[3, 15] == 1.0
    assert field.log_likelihood[3, 15] == pytest.approx(0.0, abs=1e-6)
    assert field.log_likelihood.min() >= field.outside - 1e-6
    assert (np.diff(field.hit[3, :16]) > 0.0).any()
    assert len(field.free) == 15 * 20


def test_a_map_without_a_wall_likes_no_beam() -> None:
    field = likelihood_field(OccupancyMap(np.full((3, 3), FREE, np.uint8), 0.1, 0.0, 0.0), FieldParams())
    assert (field.hit == 0.0).all()
    assert field.log_likelihood == pytest.approx(np.full((3, 3), field.outside))


def test_climbing_puts_the_beams_on_the_wall() -> None:
    field = likelihood_field(a_wall(), FieldParams())
    points = np.array([[0.5, -0.3], [0.5, 0.0], [0.5, 0.3]])
    poses = np.array([[0.8, 1.0, 0.08]])
    place = (field.outside, field.origin_x_m, field.origin_y_m, field.cell_m)
    before = mean_over_beams(poses, points, field.log_likelihood, *place)[0]
    climb(poses, points, field.log_likelihood, *place, 0.12, 0.05)
    assert mean_over_beams(poses, points, field.log_likelihood, *place)[0] > before
    assert poses[0, 0] + 0.5 == pytest.approx(1.55, abs=0.08)


def test_one_place_needs_few_particles_and_many_places_need_many() -> None:
    random = generator(5)
    one = np.zeros((3000, 3))
    many = np.random.default_rng(1).uniform([-50, -50, -3], [50, 50, 3], (3000, 3))
    weights = np.full(3000, 1.0 / 3000)
    assert len(kld_resampled(one, weights, *KLD, random)) == 100
    assert len(kld_resampled(many, weights, *KLD, random)) > 2000
    assert len(kld_resampled(many, weights, *KLD[:5], 700, random)) == 700


def test_resampling_follows_the_weights() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [5.0, 0.0, 0.0]])
    drawn = kld_resampled(poses, np.array([0.2, 0.8, 0.0]), 0.5, 0.3, 0.05, 2.33, 4000, 5000, generator(2))
    assert set(drawn[:, 0]) == {0.0, 9.0}
    assert (drawn[:, 0] == 9.0).mean() == pytest.approx(0.8, abs=0.03)


def test_uniform_poses_lie_in_free_cells() -> None:
    occupancy = a_wall()
    field = likelihood_field(occupancy, FieldParams())
    poses = uniform_poses(field.free, 300, 0.1, generator(4))
    assert all(occupancy.state_at(x, y) == FREE for x, y, _ in poses)
    assert poses[:, 2].min() < -2.0
    assert poses[:, 2].max() > 2.0

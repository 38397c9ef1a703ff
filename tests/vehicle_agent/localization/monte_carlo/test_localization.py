"""Monte-Carlo localization in a map whose walls are known, with broken beams and odometry that drifts."""

import msgspec
import numpy as np
import pytest

from contract.occupancy.occupancy_map import UNKNOWN, OccupancyMap
from tests.workshop.simulated_drive import SimulatedDrive, drive
from vehicle_agent.localization.laser.pose_arrays import between
from vehicle_agent.localization.monte_carlo.localization import (
    MapUnusable,
    MonteCarloEstimate,
    MonteCarloLocalization,
    MonteCarloParams,
    MonteCarloState,
)
from workshop.laser_mapping.occupancy import OccupancyParams, occupancy_map

DRIVE = drive(rounds=1.0, seed=4)
ANGLES = DRIVE.log.beams.angles_rad
MAP = occupancy_map(DRIVE.log, DRIVE.truth, OccupancyParams(), lambda steps: None)
ROOM = MonteCarloLocalization.in_map(MAP)


def broken(ranges_m: np.ndarray, share: float, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.where(rng.random(ranges_m.shape) < share, rng.uniform(0.2, 25.0, ranges_m.shape), ranges_m)


def driven(
    state: MonteCarloState, scans: range, ranges_m: np.ndarray, of: SimulatedDrive = DRIVE
) -> tuple[list[MonteCarloEstimate], np.ndarray, MonteCarloState]:
    """(estimates, errors in metres, the last state)."""
    estimates, errors = [], []
    for number in scans:
        estimate, state = ROOM.step(state, ranges_m[number], ANGLES, of.log.odometry[number])
        estimates.append(estimate)
        error = between(of.truth[number], estimate.pose_map)
        errors.append(float(np.hypot(error[0], error[1])))
    return estimates, np.array(errors), state


def test_it_follows_the_laser_with_a_third_of_the_beams_broken() -> None:
    ranges_m = broken(DRIVE.log.ranges_m, 0.3, 1)
    state = ROOM.near(7, DRIVE.truth[0], 0.1, 0.05, DRIVE.log.odometry[0])
    estimates, errors, _ = driven(state, range(120), ranges_m)
    assert np.sqrt((errors**2).mean()) < 0.06
    assert max(estimate.lost for estimate in estimates[10:]) < 0.2
    assert estimates[-1].particles == MonteCarloParams().particles_min


@pytest.mark.parametrize("start", [0, 70, 140, 200])
def test_it_is_found_from_anywhere(start: int) -> None:
    ranges_m = broken(DRIVE.log.ranges_m, 0.3, start)
    state = ROOM.anywhere(start, ranges_m[start], ANGLES, DRIVE.log.odometry[start])
    estimates, errors, _ = driven(state, range(start, start + 40), ranges_m)
    assert errors[-1] < 0.2
    assert estimates[-1].lost < 0.2


def test_a_laser_that_was_carried_away_knows_that_it_is_lost_and_is_found_again() -> None:
    state = ROOM.near(7, DRIVE.truth[0], 0.1, 0.05, DRIVE.log.odometry[0])
    _, _, state = driven(state, range(20), DRIVE.log.ranges_m)
    state = msgspec.structs.replace(state, odometry=DRIVE.log.odometry[130])
    estimates, errors, _ = driven(state, range(131, 180), DRIVE.log.ranges_m)
    assert errors[0] > 3.0
    assert max(estimate.lost for estimate in estimates[:20]) > 0.8
    assert errors[-1] < 0.2
    assert estimates[-1].lost < 0.2


def test_the_covariance_is_not_too_small() -> None:
    """Real logs have a mean of 2 to 3; a map without any error of its own gives less."""
    normalised = []
    for seed in (1, 2, 3):
        ranges_m = broken(DRIVE.log.ranges_m, 0.3, seed)
        state = ROOM.near(seed, DRIVE.truth[0], 0.1, 0.05, DRIVE.log.odometry[0])
        estimates, _, _ = driven(state, range(100), ranges_m)
        for number, estimate in enumerate(estimates[5:], start=5):
            away = estimate.pose_map - DRIVE.truth[number]
            away[2] = np.remainder(away[2] + np.pi, 2.0 * np.pi) - np.pi
            normalised.append(away @ np.linalg.solve(estimate.covariance, away))
    assert 0.3 < np.mean(normalised) < 3.5
    assert np.mean(np.array(normalised) < 7.815) > 0.93


def test_equal_states_and_scans_give_equal_estimates_and_leave_the_state_alone() -> None:
    state = ROOM.anywhere(3, DRIVE.log.ranges_m[10], ANGLES, DRIVE.log.odometry[10])
    before = (state.poses.copy(), state.weights.copy(), state.random.copy())
    first, _, first_state = driven(state, range(10, 16), DRIVE.log.ranges_m)
    second, _, second_state = driven(state, range(10, 16), DRIVE.log.ranges_m)
    assert all((a.pose_map == b.pose_map).all() for a, b in zip(first, second, strict=True))
    assert (first_state.poses == second_state.poses).all()
    assert (first_state.random == second_state.random).all()
    for kept, now in zip(before, (state.poses, state.weights, state.random), strict=True):
        assert (kept == now).all()


@pytest.mark.parametrize("value", [np.nan, np.inf, 0.0, -1.0, 81.91])
def test_saturated_scans_move_it_by_odometry_only(value: float) -> None:
    state = ROOM.near(7, DRIVE.truth[0], 0.02, 0.01, DRIVE.log.odometry[0])
    nothing = np.full_like(DRIVE.log.ranges_m, value)
    estimates, errors, state = driven(state, range(1, 8), nothing)
    assert errors[-1] < 0.5
    assert np.isfinite(state.poses).all()
    assert estimates[-1].covariance[0, 0] > estimates[0].covariance[0, 0]


def test_a_start_without_a_return_is_anywhere() -> None:
    state = ROOM.anywhere(1, np.full(181, np.nan), ANGLES, np.zeros(3))
    assert np.ptp(state.poses[:, 0]) > 15.0
    assert np.isfinite(state.poses).all()


def test_odometry_that_is_not_finite_is_left_out() -> None:
    state = ROOM.near(7, DRIVE.truth[0], 0.02, 0.01, DRIVE.log.odometry[0])
    estimate, after = ROOM.step(state, DRIVE.log.ranges_m[0], ANGLES, np.array([np.nan, 0.0, 0.0]))
    assert np.isfinite(estimate.pose_map).all()
    assert after is state


def test_a_standing_laser_that_is_found_keeps_its_particles() -> None:
    state = ROOM.near(7, DRIVE.truth[0], 0.05, 0.02, DRIVE.log.odometry[0])
    _, _, state = driven(state, range(30), DRIVE.log.ranges_m)
    estimate, after = ROOM.step(state, DRIVE.log.ranges_m[29], ANGLES, DRIVE.log.odometry[29])
    assert after is state
    assert estimate.lost < 0.05


def test_a_map_without_a_free_cell_is_refused() -> None:
    with pytest.raises(MapUnusable):
        MonteCarloLocalization.in_map(OccupancyMap(np.full((4, 4), UNKNOWN, np.uint8), 0.1, 0.0, 0.0))

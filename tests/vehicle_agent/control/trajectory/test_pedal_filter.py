"""The pedals' strength and the road's slope are told apart, from what the vehicle reports of its speed."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.control.trajectory.pedal_filter import (
    PedalFilter,
    PedalFilterState,
    initial_pedal_state,
    predict_speed,
    update_speed,
    with_known_speed,
    without_disturbance,
)

FILTER, DT_S = PedalFilter(), 0.02
ROW = FILTER.row()


def stop_and_go(
    rounds: int, drive_gain: float, brake_gain: float, disturbance_mps2: float, seed: int = 1
) -> PedalFilterState:
    """What is known of a vehicle after some set-offs and brakings, with a hundredth of noise."""
    rng = np.random.default_rng(seed)
    state = initial_pedal_state(FILTER)
    mean, P = state.mean, state.covariance
    true_mps = believed_mps = 1.0
    for k in range(round(rounds * 6.0 / DT_S)):
        phase_s = math.fmod(k * DT_S, 6.0)
        drive, brake = (0.7, 0.0) if phase_s < 2.0 else (0.0, 0.7) if phase_s > 4.0 else (0.2, 0.0)
        true_mps += (drive_gain * drive - brake_gain * brake + disturbance_mps2) * DT_S
        believed_mps += (mean[1] * drive - mean[2] * brake + mean[0]) * DT_S
        predict_speed(P, drive, brake, DT_S, ROW)
        believed_mps += update_speed(mean, P, true_mps + rng.normal(0.0, 0.01) - believed_mps, ROW)
    return PedalFilterState(mean, P)


@pytest.mark.parametrize("drive_gain", [0.75, 1.0, 1.4])
@pytest.mark.parametrize("brake_gain", [0.75, 1.3])
@pytest.mark.parametrize("disturbance_mps2", [-0.2, 0.0, 0.2])
def test_each_is_found_beside_the_others(
    drive_gain: float, brake_gain: float, disturbance_mps2: float
) -> None:
    known = stop_and_go(5, drive_gain, brake_gain, disturbance_mps2)
    assert known.drive_gain == pytest.approx(drive_gain, abs=0.06)
    assert known.brake_gain == pytest.approx(brake_gain, abs=0.06)
    assert known.disturbance_mps2 == pytest.approx(disturbance_mps2, abs=0.04)


def test_a_vehicle_like_its_profile_stays_so() -> None:
    known = stop_and_go(100, 1.0, 1.0, 0.0)
    assert abs(known.drive_gain - 1.0) < 0.05
    assert abs(known.brake_gain - 1.0) < 0.05


def test_without_by_wire_the_slope_is_forgotten_and_the_pedals_are_not() -> None:
    known = stop_and_go(5, 1.3, 0.8, 0.2)
    again = without_disturbance(known, FILTER)
    assert again.disturbance_mps2 == 0.0
    assert (again.drive_gain, again.brake_gain) == (known.drive_gain, known.brake_gain)


ticks = st.tuples(st.floats(0.0, 2.5), st.floats(0.0, 5.0), st.floats(-5.0, 5.0), st.sampled_from("rks"))


@settings(max_examples=100, deadline=None)
@given(st.lists(ticks, min_size=1, max_size=300))
def test_it_stays_within_its_bounds_and_sure_of_no_more_than_it_can_be(inputs: list[tuple]) -> None:
    state = initial_pedal_state(FILTER)
    for drive, brake, innovation_mps, what in inputs:
        mean, P = state.mean.copy(), state.covariance.copy()
        predict_speed(P, drive, brake, DT_S, ROW)
        if what == "r":
            update_speed(mean, P, innovation_mps, ROW)
        state = PedalFilterState(mean, P)
        if what == "s":
            state = with_known_speed(state)
        assert abs(state.disturbance_mps2) <= FILTER.disturbance_mps2_max
        assert FILTER.gain_min <= min(state.drive_gain, state.brake_gain)
        assert max(state.drive_gain, state.brake_gain) <= FILTER.gain_max
        assert np.linalg.eigvalsh(0.5 * (P + P.T)).min() > -1e-9
        assert np.abs(P - P.T).max() < 1e-9

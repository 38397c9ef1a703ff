"""The open-loop brake map."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulator.vehicle.plant import PlantParams, brake_decel
from vehicle_agent.brake_map import BrakeMap, fit_brake_map

DECELS = st.floats(0.0, 20.0, allow_nan=False)


@given(DECELS, DECELS, st.floats(0.01, 2.0), st.floats(-1.0, 2.0), st.floats(0.0, 3.0))
def test_more_deceleration_never_means_less_brake(
    a: float, b: float, gain: float, offset: float, knee: float
) -> None:
    brakes = BrakeMap(gain, offset, knee)
    low, high = sorted((a, b))
    assert 0.0 <= brakes.brake_ratio(low) <= brakes.brake_ratio(high) <= 1.0


def test_the_papers_map_is_the_papers_formula() -> None:
    brakes = BrakeMap()
    assert brakes.brake_ratio(1.0) == pytest.approx(0.90)
    assert brakes.brake_ratio(0.5) == pytest.approx(0.28 * np.log(0.5) + 0.90)
    assert brakes.brake_ratio(0.03) == 0.0
    assert brakes.brake_ratio(1.5) == 1.0


def test_no_deceleration_is_no_brake() -> None:
    assert BrakeMap(offset=2.0).brake_ratio(0.0) == 0.0


def test_a_map_that_would_fall_is_refused() -> None:
    with pytest.raises(ValueError, match="gain"):
        BrakeMap(gain=-0.1)


def test_the_vehicles_own_map_is_found_from_its_brakings() -> None:
    plant = PlantParams()
    ratios = np.linspace(0.05, 0.95, 19)
    decels = np.array([brake_decel(b, plant.brake_full_mps2, plant.brake_knee_mps2) for b in ratios])
    found = fit_brake_map(ratios, decels)
    for decel in (0.2, 0.6, 1.5, 4.0):
        given_back = brake_decel(found.brake_ratio(decel), plant.brake_full_mps2, plant.brake_knee_mps2)
        assert given_back == pytest.approx(decel, rel=0.05)


def test_two_brakings_are_too_few() -> None:
    with pytest.raises(ValueError, match="three"):
        fit_brake_map(np.array([0.2, 0.4]), np.array([0.5, 1.0]))

"""The integrals of a unit's samples are those of the motion that gave them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.transforms import rotation_of
from workshop.motion_calibration.integration import integrate, rotation_vectors

RATES = st.tuples(*[st.floats(-1.0, 1.0)] * 3)


@given(RATES)
def test_constant_rates_turn_by_their_time(rates: tuple[float, float, float]) -> None:
    stamps_s = np.linspace(0.0, 1.0, 101)
    at_s = np.array([-0.1, 0.0, 0.253, 1.0, 1.1])
    found, _ = integrate(stamps_s, np.tile(rates, (101, 1)), np.zeros((101, 3)), at_s)
    for number, time_s in ((1, 0.0), (2, 0.253), (3, 1.0)):
        assert found[number] == pytest.approx(rotation_of(time_s * np.array(rates)), abs=1e-9)
    assert np.isnan(found[[0, 4]]).all()


@given(RATES)
def test_a_rotation_vector_comes_back(vector: tuple[float, float, float]) -> None:
    assert rotation_vectors(rotation_of(np.array(vector))[None])[0] == pytest.approx(vector, abs=1e-9)


def test_a_constant_force_on_a_turning_unit_goes_where_it_pushes() -> None:
    stamps_s = np.linspace(0.0, 2.0, 401)
    rate = 0.7
    # The unit turns about z under a force that is constant in the start's frame.
    angles = rate * stamps_s
    forces = np.column_stack((np.cos(angles), -np.sin(angles), np.full(401, 9.81)))
    rates = np.tile([0.0, 0.0, rate], (401, 1))
    _, places = integrate(stamps_s, rates, forces, np.array([0.0, 1.0, 2.0]))
    assert places[1] == pytest.approx([0.5, 0.0, 4.905], abs=1e-4)
    assert places[2] == pytest.approx([2.0, 0.0, 19.62], abs=1e-4)

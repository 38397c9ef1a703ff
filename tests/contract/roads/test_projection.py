"""Degrees and metres, against PROJ."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Transformer

from contract.roads.model import Origin
from contract.roads.projection import map_from_wgs84, wgs84_from_map

origins = st.builds(Origin, st.floats(-70.0, 70.0), st.floats(-179.0, 179.0))
offsets = st.tuples(st.floats(-2000.0, 2000.0), st.floats(-2000.0, 2000.0))


@given(origins, offsets)
def test_metres_and_degrees_are_inverse(origin: Origin, offset: tuple[float, float]) -> None:
    latitude, longitude = wgs84_from_map(origin, np.array([offset]))
    assert map_from_wgs84(origin, latitude, longitude)[0] == pytest.approx(offset, abs=1e-6)


@given(origins, offsets)
def test_the_frame_agrees_with_an_azimuthal_projection_to_a_millimetre(
    origin: Origin, offset: tuple[float, float]
) -> None:
    latitude, longitude = wgs84_from_map(origin, np.array([offset]))
    oracle = Transformer.from_crs(
        "EPSG:4326",
        f"+proj=aeqd +lat_0={origin.latitude_deg} +lon_0={origin.longitude_deg} +datum=WGS84",
        always_xy=True,
    )
    assert oracle.transform(longitude[0], latitude[0]) == pytest.approx(offset, abs=1e-3)


def test_the_origin_is_zero_and_north_is_up() -> None:
    origin = Origin(31.3, 121.4)
    assert map_from_wgs84(origin, np.array([31.3]), np.array([121.4]))[0] == pytest.approx((0.0, 0.0))
    north, east = map_from_wgs84(origin, np.array([31.301, 31.3]), np.array([121.4, 121.401]))
    assert north[1] > 100.0
    assert abs(north[0]) < 1e-6
    assert east[0] > 90.0

"""Four points tell where pixels are on the ground, or that they cannot."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from campusloop.crossing_cameras.ground_pixels import GroundPixels, MappingError
from simulator.sensors.cameras.mounts import watching_camera

PLACES = np.array([[-6.0, -4.0], [6.0, -4.0], [6.0, 4.0], [-6.0, 4.0]])


def a_view(azimuth_rad: float, height_m: float) -> tuple[np.ndarray, np.ndarray, GroundPixels]:
    """K, T_pixel of a camera around the origin, and the mapping by the four places."""
    lens = np.array([14.0 * math.cos(azimuth_rad), 14.0 * math.sin(azimuth_rad), height_m])
    mount = watching_camera("mast", lens, np.array([0.0, 0.0, 0.0]))
    T_camera_map = np.linalg.inv(mount.T_base_camera)
    pixels = [(float(u), float(v)) for u, v in seen(mount.K, T_camera_map, PLACES)]
    return mount.K, T_camera_map, GroundPixels(pixels, [(float(x), float(y)) for x, y in PLACES])


def seen(K: np.ndarray, T_camera_map: np.ndarray, places: np.ndarray, z_m: float = 0.0) -> np.ndarray:
    points = np.column_stack((places, np.full(len(places), z_m), np.ones(len(places)))) @ T_camera_map.T
    pixels = points[:, :3] @ K.T
    return pixels[:, :2] / pixels[:, 2:]


@given(st.floats(-3.1, 3.1), st.floats(3.0, 8.0), st.floats(-6.0, 6.0), st.floats(-4.0, 4.0))
@settings(max_examples=60, deadline=None)
def test_places_and_pixels_agree_with_the_camera(
    azimuth_rad: float, height_m: float, x: float, y: float
) -> None:
    K, T_camera_map, ground = a_view(azimuth_rad, height_m)
    place = np.array([[x, y]])
    pixel = seen(K, T_camera_map, place)
    assert np.allclose(ground.places(pixel), place, atol=1e-5)
    assert np.allclose(ground.pixels(place), pixel, atol=1e-4)
    true_px = pixel[0, 1] - seen(K, T_camera_map, place, 1.7)[0, 1]
    assert ground.person_heights_px(place)[0] == pytest.approx(true_px, rel=0.2)


@pytest.mark.parametrize(
    ("pixels", "places"),
    [
        ([(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 0), (1, 1)]),
        ([(0, 0), (100, 0), (200, 0), (300, 0)], [(0, 0), (1, 0), (2, 0), (3, 0)]),
        ([(0, 0), (100, 0), (100, 100), (0, 100)], [(0, 0), (1, 0), (2, 0), (3, 0)]),
        ([(0, 0), (100, 0), (100, 100), (0, math.nan)], [(0, 0), (1, 0), (1, 1), (0, 1)]),
        ([(0, 0), (100, 0), (100, 100), (0, 100)], [(0, 0), (1, 0), (0, 1), (1, 1)]),
    ],
)
def test_points_that_give_no_mapping_are_refused(pixels: list, places: list) -> None:  # type: ignore[type-arg]
    with pytest.raises(MappingError):
        GroundPixels(pixels, places)

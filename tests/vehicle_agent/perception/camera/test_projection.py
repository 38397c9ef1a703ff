"""People are looked for where a pinhole camera shows them."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from simulator.sensors.cameras.mounts import CameraMount
from vehicle_agent.perception.camera.projection import person_regions, turned_region
from vehicle_agent.signals.pictures import PinholeCamera, optical_pose


def a_camera(yaw_rad: float = 0.0, down_rad: float = 0.0) -> PinholeCamera:
    mount = CameraMount("c", optical_pose(1.0, 0.2, 1.6, yaw_rad, down_rad))
    return PinholeCamera("c", mount.K, mount.T_base_camera, 640, 480)


@given(st.floats(5.0, 40.0), st.floats(-0.4, 0.4), st.floats(-3.0, 3.0), st.floats(-0.1, 0.2))
@settings(max_examples=60, deadline=None)
def test_the_ray_through_the_feet_meets_the_ground_at_the_feet(
    range_m: float, aside_rad: float, yaw_rad: float, down_rad: float
) -> None:
    camera = a_camera(yaw_rad, down_rad)
    angle = yaw_rad + aside_rad
    feet = np.array([[1.0 + range_m * math.cos(angle), 0.2 + range_m * math.sin(angle), 0.0]])
    regions = person_regions(camera, feet)
    u, v = regions.feet_px[0]
    ray = camera.T_base_camera[:3, :3] @ np.linalg.inv(camera.K) @ np.array([u, v, 1.0])
    lens = camera.T_base_camera[:3, 3]
    met = lens - ray * lens[2] / ray[2]
    assert np.allclose(met, feet[0], atol=1e-6)
    # A level pinhole camera shows a person as high as f h / z.
    if abs(down_rad) < 1e-9:
        assert math.isclose(regions.heights_px[0], camera.K[1, 1] * 1.7 / (range_m * math.cos(aside_rad)))


def test_only_whole_people_before_the_camera_are_seen() -> None:
    places = np.array([[15.0, 0.0, 0.0], [-15.0, 0.0, 0.0], [15.0, 14.0, 0.0], [2.2, 0.0, 0.0]])
    assert person_regions(a_camera(), places).is_seen.tolist() == [True, False, False, False]


@given(st.floats(0.0, 639.0), st.floats(0.0, 479.0), st.floats(10.0, 200.0))
def test_turned_twice_a_region_is_where_it_was(u: float, v: float, height_px: float) -> None:
    camera = a_camera()
    back = turned_region(camera, turned_region(camera, (u, v), height_px), height_px)
    assert np.allclose(back, (u, v))

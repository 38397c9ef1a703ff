"""A simulated camera shows what is before it, the same for the same seed, and less at night and in rain."""

import math
from dataclasses import replace

import numpy as np
import pytest

from simulator.sensors.cameras.camera import CameraSurroundings, SceneCamera, Shot
from simulator.sensors.cameras.clothed_people import PeopleDresser
from simulator.sensors.cameras.crossing_view import CrossingView
from simulator.sensors.cameras.faults import FaultyCamera
from simulator.sensors.cameras.figures import Wardrobe
from simulator.sensors.cameras.light import DAY, NIGHT, OVERCAST, RAIN, Light
from simulator.sensors.cameras.mounts import CameraMount, four_cameras, watching_camera
from simulator.sensors.scene.changes import SceneError, WorldChanges
from simulator.sensors.scene.ground import GroundParams
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.static_scene import StaticScene
from simulator.traffic.actors import Bodies, no_bodies, together
from tests.simulator.sensors.scene.campus import a_street
from vehicle_agent.config import Body
from vehicle_agent.perception.camera.projection import person_regions
from vehicle_agent.signals import PEDESTRIAN, VEHICLE
from vehicle_agent.signals.pictures import optical_pose

SCENE = StaticScene(a_street(), 1, WorldChanges(parked_ratio=0.0), GroundParams(grade_ratio=0.0))
MOUNT = CameraMount("front", optical_pose(0.0, 0.0, 1.6, 0.0), 160, 120)
T_MAP_BASE = SCENE.ground.poses(np.array([[30.0, -1.75, 0.0]]))[0]


def bodies(number: int, x_m: float, y_m: float, kind: int = PEDESTRIAN, yaw_rad: float = 1.57) -> Bodies:
    size = (0.5, 0.5) if kind == PEDESTRIAN else (4.4, 1.8)
    return Bodies(
        np.array([number]), np.array([kind]), np.array([[x_m, y_m, yaw_rad]]), np.zeros((1, 2)),
        np.array([size]),
    )  # fmt: skip


def around(those: Bodies) -> CameraSurroundings:
    scenes = MovingScenes(SCENE.ground, 1000)
    return CameraSurroundings(PeopleDresser(SCENE.ground).of(those), scenes.of(those.selected(~those.people)))


def shot(those: Bodies, light: Light = OVERCAST, seed: int = 1, stamp_ns: int = 5) -> Shot:
    return SceneCamera(MOUNT, SCENE, seed, light).take(T_MAP_BASE, stamp_ns, around(those))


def test_a_person_changes_the_picture_where_the_model_says_and_nowhere_else() -> None:
    camera = SceneCamera(MOUNT, SCENE, 1, replace(OVERCAST, noise=0.0))
    empty = camera.take(T_MAP_BASE, 5, around(no_bodies())).picture.pixels.astype(int)
    with_person = camera.take(T_MAP_BASE, 5, around(bodies(1, 42.0, -2.5))).picture.pixels.astype(int)
    rows, columns = np.nonzero(np.abs(with_person - empty).max(axis=2) > 25)
    region = person_regions(camera.model, np.array([[12.0, -0.75, 0.0]]))
    (u, v), height_px = region.feet_px[0], region.heights_px[0]
    assert len(rows) > 40
    assert np.abs(columns - u).max() < 0.55 * height_px
    assert v - 1.25 * height_px < rows.min() < v - 0.75 * height_px
    assert v - 0.15 * height_px < rows.max() < v + 0.2 * height_px


def test_the_same_seed_and_stamp_give_the_same_bytes_and_others_do_not() -> None:
    first = shot(bodies(1, 42.0, -2.5)).picture.pixels
    assert np.array_equal(first, shot(bodies(1, 42.0, -2.5)).picture.pixels)
    assert not np.array_equal(first, shot(bodies(1, 42.0, -2.5), seed=2).picture.pixels)
    assert not np.array_equal(first, shot(bodies(1, 42.0, -2.5), stamp_ns=6).picture.pixels)


def test_a_glimpse_is_the_picture_where_it_is_looked_at_and_coarse_elsewhere() -> None:
    camera = SceneCamera(MOUNT, SCENE, 1, OVERCAST)
    there = around(bodies(1, 42.0, -2.5))
    whole = camera.take(T_MAP_BASE, 5, there).picture.pixels.astype(int)
    region = person_regions(camera.model, np.array([[12.0, -0.75, 0.0]]))
    (u, v), height = np.rint(region.feet_px[0]).astype(int), round(float(region.heights_px[0]))
    window = np.array([[u - height // 2, v - height - 5, u + height // 2, v + 5]])
    glimpse = camera.glimpse(T_MAP_BASE, 5, there, window).pixels.astype(int)
    left, top, right, bottom = window[0]
    inside = np.abs(glimpse - whole)[top:bottom, left:right]
    # The exposure is that of a coarser picture: a few grey levels.
    assert np.percentile(inside, 99) <= 6
    assert abs(glimpse.mean() - whole.mean()) < 5.0
    assert (np.abs(glimpse - whole).max(axis=2) > 25).sum() > 50, "elsewhere edges are missing"
    assert np.array_equal(glimpse, camera.glimpse(T_MAP_BASE, 5, there, window).pixels)


def test_it_is_said_how_much_of_a_person_is_hidden() -> None:
    assert shot(bodies(1, 42.0, -2.5)).hidden[0] < 0.05
    behind = together(bodies(1, 42.0, -2.5), bodies(2, 38.0, -2.25, VEHICLE))
    assert 0.3 < shot(behind).hidden[0] < 0.9
    row = together(bodies(1, 42.0, -2.5), bodies(2, 38.0, -2.25))
    assert shot(row).hidden.max() > 0.5
    assert shot(bodies(1, 10.0, -2.5)).hidden[0] == 1.0


def test_night_is_dark_and_noisy_and_rain_takes_contrast() -> None:
    day, night, rain = (shot(no_bodies(), light).picture.pixels.astype(float) for light in (DAY, NIGHT, RAIN))
    # The sky is above: at night only the lamps' road is lit.
    assert night[:30].mean() < 0.5 * day[:30].mean()
    assert rain[40:60].std() < day[40:60].std()


def test_shade_of_a_body_falls_on_the_road_by_day_only() -> None:
    low = replace(DAY, sun_azimuth_rad=0.5 * math.pi, sun_height_rad=0.5, noise=0.0)
    road = (slice(62, 110), slice(20, 80))
    lit = shot(no_bodies(), low).picture.pixels[road].astype(float)
    shaded = shot(bodies(2, 38.0, 1.5, VEHICLE, 0.0), low).picture.pixels[road].astype(float)
    assert (lit - shaded).max() > 30.0


@pytest.mark.parametrize("fault", ["black", "covered", "frozen", "upside_down"])
def test_a_fault_shows_and_goes(fault: str) -> None:
    camera = FaultyCamera(SceneCamera(MOUNT, SCENE, 1, OVERCAST))
    good = camera.take(T_MAP_BASE, 1, around(no_bodies()))
    camera.fault = fault  # type: ignore[assignment]
    bad = camera.take(T_MAP_BASE, 2, around(no_bodies()))
    camera.fault = None
    again = camera.take(T_MAP_BASE, 2, around(no_bodies()))
    assert good is not None
    assert bad is not None
    assert again is not None
    assert bad.picture.stamp_ns == 2
    expected = {
        "black": np.zeros_like(good.picture.pixels), "covered": np.full_like(good.picture.pixels, 90),
        "frozen": good.picture.pixels, "upside_down": again.picture.pixels[::-1, ::-1],
    }  # fmt: skip
    assert np.array_equal(bad.picture.pixels, expected[fault])
    assert not np.array_equal(again.picture.pixels, bad.picture.pixels)


def test_a_dead_camera_gives_no_picture() -> None:
    camera = FaultyCamera(SceneCamera(MOUNT, SCENE, 1, OVERCAST))
    camera.fault = "dead"
    assert camera.take(T_MAP_BASE, 1, around(no_bodies())) is None


def test_figures_stand_on_the_ground_and_have_a_persons_size() -> None:
    wardrobe = Wardrobe()
    for style in range(Wardrobe.STYLES):
        for phase in np.linspace(0.0, 2.0 * math.pi, 7):
            corners = wardrobe.figure(style, float(phase), True).triangles.reshape(-1, 3)
            assert abs(corners[:, 2].min()) < 1e-6
            assert 1.6 < corners[:, 2].max() < 1.85
            assert np.abs(corners[:, 1]).max() < 0.4


def test_four_cameras_look_ahead_left_right_and_back() -> None:
    ahead = {mount.name: mount.T_base_camera[:3, 2] for mount in four_cameras(Body())}
    for name, way in (("front", (1, 0)), ("left", (0, 1)), ("right", (0, -1)), ("rear", (-1, 0))):
        assert np.dot(ahead[name][:2], way) > 0.98


def test_a_camera_at_a_crossing_shows_all_of_its_area() -> None:
    area = a_street().observation_areas[0]
    view = CrossingView(SCENE, area, 1, 1000, OVERCAST, (240, 180))
    pixels = np.array([pixel for pixel, _ in view.ground_points])
    assert (pixels > 0.0).all()
    assert (pixels < (240, 180)).all()
    assert view.take(0, bodies(1, 60.0, 0.0)).hidden[0] < 0.2


def test_what_no_camera_can_be_is_refused() -> None:
    with pytest.raises(SceneError):
        CameraMount("wide", np.eye(4), field_rad=3.2)
    with pytest.raises(SceneError):
        Light(sun=-1.0)
    with pytest.raises(SceneError):
        watching_camera("mast", np.array([1.0, 2.0, 5.0]), np.array([1.0, 2.0, 0.0]))

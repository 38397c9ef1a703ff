import math

import numpy as np

from simulator.sensors.scene.ground import Ground, GroundParams
from simulator.sensors.scene.materials import Material
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.traffic.actors import Bodies, no_bodies
from tests.simulator.sensors.scene.campus import a_street
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE

GROUND = Ground(a_street(), 3, GroundParams(grade_ratio=0.02))
FLEET_FROM = 1000


def bodies(
    kind: int, size: tuple[float, float], number: int = 5, speed_mps: float = 1.2, x_m: float = 30.0
) -> Bodies:
    return Bodies(
        np.array([number]), np.array([kind]), np.array([[x_m, -1.0, 0.5 * math.pi]]),
        np.array([[0.0, speed_mps]]), np.array([size]),
    )  # fmt: skip


def extents(of: Bodies) -> tuple[np.ndarray, np.ndarray]:
    corners = MovingScenes(GROUND, FLEET_FROM).of(of).triangles.reshape(-1, 3)
    return corners.min(axis=0), corners.max(axis=0)


def test_bodies_have_their_size_and_stand_on_the_ground() -> None:
    here = GROUND.road_m(np.array([30.0]), np.array([-1.0]))[0]
    for kind, number, size, height in (
        (VEHICLE, 5, (4.0, 1.7), 1.48), (VEHICLE, 5, (8.0, 2.4), 3.1),
        (VEHICLE, FLEET_FROM, (4.35, 1.63), 2.28), (CYCLIST, 5, (1.8, 0.6), 1.78),
    ):  # fmt: skip
        low, high = extents(bodies(kind, size, number))
        # The heading is along y.
        assert abs(high[1] - low[1] - size[0]) < 0.1
        assert abs(high[0] - low[0] - size[1]) < 0.1
        assert abs(low[2] - here) < 0.08
        assert abs(high[2] - here - height) < 0.06


def test_person_has_the_stature_of_a_person() -> None:
    low, high = extents(bodies(PEDESTRIAN, (0.5, 0.5)))
    assert 1.5 < high[2] - low[2] < 2.0
    assert high[0] - low[0] < 0.8


def test_legs_swing_with_the_way_and_not_while_standing() -> None:
    def stride(x_m: float, y_m: float, speed_mps: float) -> float:
        one = bodies(PEDESTRIAN, (0.5, 0.5), speed_mps=speed_mps)
        one.poses_map[0, :2] = x_m, y_m
        low, high = extents(one)
        return float(high[1] - low[1])

    walking = [stride(30.0, 0.1 * k, 1.2) for k in range(10)]
    standing = [stride(30.0, 0.1 * k, 0.0) for k in range(10)]
    assert max(walking) > max(standing) + 0.2
    assert max(standing) - min(standing) < 0.001


def test_scene_of_nobody_stops_no_ray() -> None:
    scene = MovingScenes(GROUND, FLEET_FROM).of(no_bodies())
    origins, rays = np.zeros((1, 3), dtype=np.float32), np.array([[1.0, 0.0, 0.0]], dtype=np.float32)
    assert scene.cast(origins, rays, np.array([50.0], dtype=np.float32))[1].tolist() == [-1]


def test_every_body_keeps_its_number() -> None:
    scene = MovingScenes(GROUND, FLEET_FROM).of(bodies(PEDESTRIAN, (0.5, 0.5), number=42))
    assert set(scene.surfaces.objects.tolist()) == {42}
    assert set(scene.surfaces.materials.tolist()) == {Material.CLOTHES}

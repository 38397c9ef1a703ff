import math

import numpy as np
import pytest

from simulator.sensors.lidars.mounts import four_lidars, in_makers_frame, mount, roof_lidar
from simulator.sensors.lidars.response import LidarResponse
from simulator.sensors.lidars.scanner import MovingBodies
from simulator.sensors.lidars.spinning_lidar import LidarScan, MountedLidar, SpinningLidar
from simulator.sensors.scene.materials import Material
from simulator.sensors.scene.mesh import Mesh, box
from simulator.sensors.scene.shapes import shuttle
from simulator.sensors.scene.static_scene import CastScene, StaticScene
from tests.simulator.sensors.lidars.drives import WALL, bare_scene, moving
from tests.simulator.sensors.scene.campus import a_street
from vehicle_agent.config import Body
from vehicle_agent.lidar.models import VLP16, XT16, LidarModel
from vehicle_agent.lidar.plausibility import cloud_faults

EXACT = LidarResponse(range_std_m=0.0, divergence_rad=0.0, dropout_ratio=0.0, bloom_ratio=0.0)


@pytest.fixture(scope="module")
def street() -> StaticScene:
    return StaticScene(a_street(), 3)


def a_lidar(
    scene: StaticScene,
    model: LidarModel = XT16,
    response: LidarResponse | None = None,
    seed: int = 1,
    **more: float,
) -> SpinningLidar:
    place = in_makers_frame(mount(0.0, 0.0, 2.0, 0.0), model)
    mounted = MountedLidar("top", place, model, response=response)
    return SpinningLidar(mounted, scene, np.random.default_rng(seed), **more)


def in_map(scan: LidarScan, trajectory) -> np.ndarray:
    poses = trajectory(scan.cloud.stamp_ns + scan.cloud.offsets_ns)
    return np.einsum("nij,nj->ni", poses[:, :3, :3], scan.points_base) + poses[:, :3, 3]


@pytest.mark.parametrize("model", [XT16, VLP16])
def test_points_of_a_moving_lidar_lie_on_the_wall_once_each_has_its_own_pose(model: LidarModel) -> None:
    trajectory = moving(5.0, 0.4)
    scan = a_lidar(bare_scene(WALL), model, EXACT).scan(trajectory, 0)
    points = in_map(scan, trajectory)
    wall = points[points[:, 2] > 0.05]
    assert len(wall) > 200
    assert np.abs(wall[:, 0] - 52.0).max() < 0.003
    # Without the motion they do not.
    assert np.abs(scan.points_base[points[:, 2] > 0.05, 0] + 40.0 - 52.0).max() > 0.1


def test_ground_is_at_the_height_below_the_lidar() -> None:
    trajectory = moving(0.0)
    points = in_map(a_lidar(bare_scene(), response=EXACT).scan(trajectory, 0), trajectory)
    near = points[np.hypot(points[:, 0] - 40.0, points[:, 1]) < 20.0]
    assert len(near) > 3000
    assert np.abs(near[:, 2]).max() < 0.001


@pytest.mark.parametrize("model", [XT16, VLP16])
def test_times_and_rings_are_those_of_the_model(street: StaticScene, model: LidarModel) -> None:
    scan = a_lidar(street, model).scan(moving(3.0), 5_000_000_000)
    cloud = scan.cloud
    assert cloud.stamp_ns == 5_000_000_000
    assert 0 <= cloud.offsets_ns.min() <= cloud.offsets_ns.max() < 100_000_000
    assert (np.diff(cloud.offsets_ns) >= 0).all()
    elevation = np.arctan2(cloud.points_sensor[:, 2], np.hypot(*cloud.points_sensor[:, :2].T))
    by_ring = np.sort(model.elevations_rad)
    assert np.abs(elevation - by_ring[cloud.rings]).max() < 1e-4
    assert cloud_faults(cloud) == ()


def test_same_seed_gives_the_same_bytes(street: StaticScene) -> None:
    one, same, other = (a_lidar(street, seed=seed).scan(moving(3.0), 0) for seed in (1, 1, 2))
    assert one.cloud.points_sensor.tobytes() == same.cloud.points_sensor.tobytes()
    assert one.cloud.intensities.tobytes() == same.cloud.intensities.tobytes()
    assert one.cloud.points_sensor.tobytes() != other.cloud.points_sensor.tobytes()


def test_four_lidars_see_the_street_and_the_vehicle_itself(street: StaticScene) -> None:
    body = Body()
    own = CastScene(shuttle(body.length_m, body.width_m, body.height_m, body.rear_overhang_m))
    for mounted in four_lidars(body):
        scan = SpinningLidar(mounted, street, np.random.default_rng(1), own).scan(moving(2.0), 0)
        inside = (
            (scan.points_base[:, 0] > -body.rear_overhang_m - 0.05)
            & (scan.points_base[:, 0] < body.front_overhang_m + 0.05)
            & (np.abs(scan.points_base[:, 1]) < 0.5 * body.width_m + 0.05)
        )
        assert 100 < np.count_nonzero(inside) < len(scan.cloud) - 5000
        assert cloud_faults(scan.cloud) == ()


def a_box_at(x_m: float, y_m: float) -> CastScene:
    mesh = Mesh()
    mesh.add(box((x_m - 0.5, y_m - 0.5, 0.0), (x_m + 0.5, y_m + 0.5, 1.9)), Material.CAR_PAINT)
    return CastScene(mesh.packed())


def test_bodies_that_move_are_seen_where_they_are_when_the_beam_passes() -> None:
    # The XT16's turn begins at the left of its own frame's y, that is ahead, and goes on clockwise.
    scene, trajectory = bare_scene(), moving(0.0)
    bodies = (MovingBodies(50_000_000, a_box_at(40.0, -8.0)), MovingBodies(100_000_000, a_box_at(40.0, 8.0)))
    points = in_map(a_lidar(scene, response=EXACT).scan(trajectory, 0, bodies), trajectory)
    standing = points[points[:, 2] > 0.3]
    assert np.count_nonzero(standing[:, 1] < -7.0) > 50
    assert np.count_nonzero(standing[:, 1] > 7.0) > 50
    late = (MovingBodies(50_000_000, a_box_at(40.0, 8.0)), MovingBodies(100_000_000, a_box_at(40.0, -8.0)))
    unseen = in_map(a_lidar(scene, response=EXACT).scan(trajectory, 0, late), trajectory)
    assert np.count_nonzero(unseen[:, 2] > 0.3) == 0


def test_a_body_behind_a_wall_is_not_seen() -> None:
    trajectory = moving(0.0)
    points = in_map(
        a_lidar(bare_scene(WALL), response=EXACT).scan(
            trajectory, 0, (MovingBodies(10**9, a_box_at(60.0, -1.75)),)
        ),
        trajectory,
    )
    assert points[:, 0].max() < 52.01


def sheet(x_m: float, material: Material, half_m: float = 0.5) -> CastScene:
    mesh = Mesh()
    mesh.add(box((x_m, -1.75 - half_m, 1.5), (x_m + 0.1, -1.75 + half_m, 1.5 + 2.0 * half_m)), material)
    return CastScene(mesh.packed())


def test_retro_reflectors_are_brighter_than_anything_else_and_bloom() -> None:
    scene, trajectory = bare_scene(), moving(0.0)
    found = {}
    for material in (Material.RETRO, Material.PLASTER):
        scan = a_lidar(scene).scan(trajectory, 0, (MovingBodies(10**9, sheet(50.0, material)),))
        plate = scan.points_base[:, 2] > 1.0
        found[material] = (
            scan.cloud.intensities[plate].max(),
            np.ptp(scan.points_base[plate, 1]),
            scan.ghosts,
        )
    assert found[Material.RETRO][0] > 150 > 101 > found[Material.PLASTER][0]
    assert found[Material.RETRO][1] > found[Material.PLASTER][1] + 0.02
    assert found[Material.RETRO][2] > 0 == found[Material.PLASTER][2]


def test_noise_grows_with_range_and_dark_surfaces_vanish_first() -> None:
    trajectory = moving(0.0)
    stds, seen = [], []
    for x_m in (50.0, 100.0, 150.0):
        for material in (Material.PLASTER, Material.RUBBER):
            lidar = a_lidar(bare_scene(), response=LidarResponse(range_std_m=0.01, dropout_ratio=0.0))
            errors = []
            count = 0
            for turn in range(8):
                scan = lidar.scan(
                    trajectory, turn * 100_000_000, (MovingBodies(10**12, sheet(x_m, material, 3.0)),)
                )
                plate = scan.points_base[scan.points_base[:, 2] > 1.0]
                count += len(plate)
                errors += (plate[:, 0] + 40.0 - x_m).tolist()
            seen.append(count)
            if material == Material.PLASTER:
                stds.append(np.std(errors))
    assert stds[0] < stds[1] < stds[2] < 0.1
    assert seen[0] > 0
    assert seen[5] == 0 < seen[4]


def test_rain_shortens_the_view_and_adds_drops(street: StaticScene) -> None:
    dry = a_lidar(street).scan(moving(0.0), 0)
    wet = a_lidar(street, rain_mm_per_h=30.0).scan(moving(0.0), 0)

    def far(scan: LidarScan) -> int:
        return int(np.count_nonzero(np.linalg.norm(scan.points_base, axis=1) > 30.0))

    assert far(wet) < far(dry)
    in_air = (wet.points_base[:, 2] > 1.5) & (np.hypot(*wet.points_base[:, :2].T) < 3.0)
    assert np.count_nonzero(in_air) > 20


def test_roof_lidar_looks_ahead_in_the_base_frame() -> None:
    trajectory = moving(0.0)
    for model in (VLP16, XT16):
        mounted = roof_lidar(Body(), model)
        assert mounted.T_base_sensor[:3, :3] @ mounted.T_base_sensor[:3, :3].T == pytest.approx(np.eye(3))
        lidar = SpinningLidar(mounted, bare_scene(WALL), np.random.default_rng(1))
        ahead = lidar.scan(trajectory, 0).points_base
        ahead = ahead[ahead[:, 2] > 0.5]
        assert np.abs(ahead[:, 0] - 12.0).max() < 0.2
        assert math.isclose(float(np.median(ahead[:, 1])), 0.0, abs_tol=3.0)


def test_a_vehicle_that_stands_sees_what_moves_past_it() -> None:
    lidar, trajectory = a_lidar(bare_scene(), response=EXACT), moving(0.0)
    seen = []
    for turn, y_m in enumerate((-8.0, 0.0, 8.0)):
        body = (MovingBodies(10**12, a_box_at(52.0, y_m)),)
        points = in_map(lidar.scan(trajectory, turn * 100_000_000, body), trajectory)
        box_points = points[points[:, 2] > 0.3]
        assert len(box_points) > 50
        seen.append(float(box_points[:, 1].mean()))
    np.testing.assert_allclose(seen, (-8.0, 0.0, 8.0), atol=0.6)


def test_a_vehicle_that_drives_on_leaves_its_standing_view() -> None:
    stood, drove = (a_lidar(bare_scene(WALL), response=EXACT) for _ in range(2))
    for turn in (0, 1):
        stood.scan(moving(0.0), turn * 100_000_000)
        drove.scan(moving(5.0), turn * 100_000_000)
    one, other = (lidar.scan(moving(5.0), 200_000_000) for lidar in (stood, drove))
    np.testing.assert_array_equal(one.points_base, other.points_base)

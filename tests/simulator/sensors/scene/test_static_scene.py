import numpy as np
import pytest

from simulator.sensors.scene.changes import SceneError, WorldChanges
from simulator.sensors.scene.ground import Ground, GroundParams
from simulator.sensors.scene.materials import Material
from simulator.sensors.scene.static_scene import StaticScene
from tests.simulator.sensors.scene.campus import a_street


@pytest.fixture(scope="module")
def scene() -> StaticScene:
    return StaticScene(a_street(), 3)


def down(scene: StaticScene, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Heights and materials of the ground below (n, 2) places, looked at from just above the kerb."""
    height = scene.ground.terrain_m(places[:, 0], places[:, 1]) + 0.5
    origins = np.column_stack((places, height)).astype(np.float32)
    rays = np.tile(np.array([0.0, 0.0, -1.0], dtype=np.float32), (len(places), 1))
    reach, hit = scene.cast(origins, rays, np.full(len(places), 5.0, dtype=np.float32))
    return height - reach, np.where(hit >= 0, scene.surfaces.materials[hit], 255)


def test_same_seed_gives_the_same_bytes(scene: StaticScene) -> None:
    again = StaticScene(a_street(), 3)
    assert again.triangles.tobytes() == scene.triangles.tobytes()
    assert again.surfaces.reflectivity.tobytes() == scene.surfaces.reflectivity.tobytes()


def test_another_seed_gives_another_street(scene: StaticScene) -> None:
    assert StaticScene(a_street(), 4).triangles.tobytes() != scene.triangles.tobytes()


def test_road_has_a_crown_and_the_pavement_is_a_kerb_higher(scene: StaticScene) -> None:
    y = np.array([0.0, -3.3, -3.7])
    heights, materials = down(scene, np.column_stack((np.full(3, 20.0), y)))
    relative = heights - scene.ground.terrain_m(np.full(3, 20.0), y)
    assert relative == pytest.approx([0.02 * 3.5, 0.02 * 0.2, 0.12], abs=0.006)
    assert materials.tolist() == [Material.ASPHALT, Material.ASPHALT, Material.PAVING]


def test_kerb_is_lowered_at_the_crossing(scene: StaticScene) -> None:
    heights, _ = down(scene, np.array([[60.0, -3.8]]))
    assert heights[0] - scene.ground.terrain_m(np.array([60.0]), np.array([-3.8]))[0] < 0.08


def test_mesh_has_no_hole_in_the_ground(scene: StaticScene) -> None:
    rng = np.random.default_rng(0)
    places = rng.uniform((-40.0, -50.0), (160.0, 50.0), (20_000, 2))
    _, materials = down(scene, places)
    assert np.count_nonzero(materials == 255) == 0


def test_wheels_stand_on_the_surface_that_rays_hit(scene: StaticScene) -> None:
    rng = np.random.default_rng(1)
    places = np.column_stack((rng.uniform(5.0, 110.0, 300), rng.uniform(-3.0, 3.0, 300)))
    heights, _ = down(scene, places)
    assert np.abs(heights - scene.ground.road_m(places[:, 0], places[:, 1])).max() < 0.01


def test_vehicle_on_one_side_of_the_crown_leans_outwards() -> None:
    ground = Ground(a_street(), 3, GroundParams(grade_ratio=0.0))
    pose = ground.poses(np.array([[30.0, -1.75, 0.0]]))[0]
    # The left wheels stand higher; the road is level along its way.
    assert pose[2, 1] == pytest.approx(0.02, abs=0.002)
    assert pose[2, 0] == pytest.approx(0.0, abs=1e-3)
    assert pose[:3, :3] @ pose[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)


def test_flat_ground_is_flat() -> None:
    ground = Ground(a_street(), 3, GroundParams(0.0, 0.0, 3.5, 0.0, 0.0))
    assert np.abs(ground.height_m(np.linspace(0, 100, 50), np.linspace(-20, 20, 50))).max() == 0.0


def test_nothing_stands_on_the_road(scene: StaticScene) -> None:
    things = scene.triangles[(scene.surfaces.objects >= 0) & (scene.surfaces.materials != Material.FOLIAGE)]
    low = things[things[:, :, 2].max(axis=1) < 2.2].reshape(-1, 3)
    assert scene.ground.inside_at(low[:, 0], low[:, 1]).max() < 0.15


def test_changes_leave_what_is_permanent_where_it_was(scene: StaticScene) -> None:
    changed = StaticScene(a_street(), 3, WorldChanges(seed=9, parked_ratio=1.0))

    def of(one: StaticScene, material: Material) -> np.ndarray:
        return np.unique(one.triangles[one.surfaces.materials == material].reshape(-1, 9), axis=0)

    for material in (Material.FOLIAGE, Material.BARK, Material.BRICK, Material.PLASTER, Material.KERBSTONE):
        assert np.array_equal(of(changed, material), of(scene, material))
    assert len(of(changed, Material.RUBBER)) > len(of(scene, Material.RUBBER))


def test_altered_buildings_differ_and_the_map_stays() -> None:
    road_map = a_street()
    changed = StaticScene(road_map, 3, WorldChanges(seed=1, buildings_altered_ratio=1.0))
    assert changed.buildings != road_map.buildings
    assert all(
        building not in changed.buildings or len(changed.buildings) > len(road_map.buildings)
        for building in road_map.buildings
    )


def test_works_stand_beside_the_road() -> None:
    scene = StaticScene(a_street(), 3, WorldChanges(seed=5, works=2))
    without = StaticScene(a_street(), 3, WorldChanges(seed=5))
    assert np.count_nonzero(scene.surfaces.materials == Material.RETRO) > np.count_nonzero(
        without.surfaces.materials == Material.RETRO
    )


@pytest.mark.parametrize("wrong", [{"parked_ratio": 1.5}, {"works": -1}, {"sway_m": -0.1}])
def test_impossible_changes_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(SceneError):
        WorldChanges(**wrong)  # type: ignore[arg-type]

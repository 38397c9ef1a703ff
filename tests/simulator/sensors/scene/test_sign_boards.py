"""The boards of the map's signs: where they stand, and which way they face."""

import msgspec
import numpy as np
import pytest

from contract.roads.model import RoadSign
from simulator.sensors.scene.ground import Ground, GroundParams
from simulator.sensors.scene.materials import Material
from simulator.sensors.scene.sign_boards import octagon, sign_on_post, sign_poses, triangle
from simulator.sensors.scene.static_scene import StaticScene
from tests.simulator.sensors.scene.campus import a_street

FLAT = GroundParams(grade_ratio=0.0)


def a_signed_street(*signs: RoadSign) -> object:
    return msgspec.structs.replace(a_street(), signs=signs)


def test_a_sign_stands_beyond_the_edge_on_its_side_and_faces_its_lane() -> None:
    road_map = a_signed_street(
        RoadSign("a", "stop", "east", 40.0), RoadSign("b", "yield", "west", 50.0, "left")
    )
    ground = Ground(road_map, 1, FLAT)  # type: ignore[arg-type]
    poses = sign_poses(road_map, ground)  # type: ignore[arg-type]
    assert poses[0, 0] == pytest.approx(40.0)
    assert poses[0, 2] == pytest.approx(0.0)
    # The lane back begins at 120 m; its left is the same verge.
    assert poses[1, 0] == pytest.approx(70.0)
    assert abs(poses[1, 2]) == pytest.approx(np.pi)
    for pose in poses:
        inside_m = float(ground.inside_at(pose[:1], pose[1:2])[0])
        assert -2.0 < inside_m <= -0.5
        assert pose[1] < -3.5


def test_boards_have_the_usual_size_and_height() -> None:
    stop = sign_on_post("stop")
    retro = stop.triangles[stop.materials == int(Material.RETRO)].reshape(-1, 3)
    assert np.ptp(retro[:, 1]) == pytest.approx(0.75, abs=1e-5)
    assert np.ptp(retro[:, 2]) == pytest.approx(0.75, abs=1e-5)
    assert retro[:, 2].min() == pytest.approx(2.1, abs=1e-5)
    assert np.ptp(octagon(0.9)[:, 0]) == pytest.approx(0.9)
    assert triangle()[:, 1].argmin() == 2, "its point is down"


def test_a_beam_of_its_lane_meets_the_board_and_one_from_behind_meets_metal() -> None:
    road_map = a_signed_street(RoadSign("a", "stop", "east", 40.0))
    scene = StaticScene(road_map, 1, ground=FLAT)  # type: ignore[arg-type]
    _, y_m, _ = sign_poses(road_map, scene.ground)[0]  # type: ignore[arg-type]
    # Beside the post, half a metre before and behind the board.
    origins = np.array([[39.5, y_m + 0.15, 2.6], [40.5, y_m + 0.15, 2.6]], np.float32)
    rays = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]], np.float32)
    ranges, triangles = scene.cast(origins, rays, np.full(2, 2.0, np.float32))
    assert scene.surfaces.materials[triangles].tolist() == [int(Material.RETRO), int(Material.METAL)]
    assert ranges == pytest.approx([0.46, 0.53], abs=0.02)


def test_a_map_without_signs_has_the_scene_that_it_had() -> None:
    plain = StaticScene(a_street(), 1, ground=FLAT)
    signed = StaticScene(a_signed_street(RoadSign("a", "stop", "east", 40.0)), 1, ground=FLAT)  # type: ignore[arg-type]
    assert len(plain.triangles) != len(signed.triangles)
    again = StaticScene(a_street(), 1, ground=FLAT)
    assert plain.triangles.tobytes() == again.triangles.tobytes()

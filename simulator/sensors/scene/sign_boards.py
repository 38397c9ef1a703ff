"""Boards of traffic signs on posts, and where those of a map stand."""

import math

import numpy as np

from contract.geometry import Array, arc_lengths, pose_at
from contract.roads.model import RoadMap, RoadSign, SignKind
from simulator.sensors.scene.ground import Ground
from simulator.sensors.scene.materials import Material
from simulator.sensors.scene.mesh import Mesh, PackedMesh, cylinder

# An octagon of 0.75 m between opposite sides, a triangle of 0.9 m (MUTCD, the common sizes), and the height
# of the lowest point of the board above the pavement.
STOP_M, YIELD_M, BOTTOM_M = 0.75, 0.9, 2.1
_BEYOND_M = 0.6
_STEP_M = 0.25
_FARTHEST_M = 6.0


def octagon(across_m: float = STOP_M) -> Array:
    """(8, 2) corners about the middle, y to the left and z up, of a regular octagon that stands on a side."""
    angles = math.pi / 8.0 + math.pi / 4.0 * np.arange(8)
    radius = 0.5 * across_m / math.cos(math.pi / 8.0)
    corners: Array = radius * np.column_stack((np.cos(angles), np.sin(angles)))
    return corners


def triangle(side_m: float = YIELD_M, *, upright: bool = False) -> Array:
    """(3, 2) corners of an equilateral triangle, its point down for `yield`."""
    height = side_m * math.sqrt(3.0) / 2.0
    way = 1.0 if upright else -1.0
    return np.array([[-0.5 * side_m, -way * height / 3.0], [0.5 * side_m, -way * height / 3.0],
                     [0.0, way * height * 2.0 / 3.0]])  # fmt: skip


def rectangle(width_m: float, height_m: float) -> Array:
    """(4, 2) corners."""
    w, h = 0.5 * width_m, 0.5 * height_m
    return np.array([[-w, -h], [w, -h], [w, h], [-w, h]])


def disc(diameter_m: float, corners: int = 24) -> Array:
    """(corners, 2)."""
    angles = 2.0 * math.pi * np.arange(corners) / corners
    return 0.5 * diameter_m * np.column_stack((np.cos(angles), np.sin(angles)))


def board_on_post(outline: Array, bottom_m: float = BOTTOM_M) -> PackedMesh:
    """A retro-reflective board that faces backwards (-x), metal behind it, on a post of 6 cm.

    outline (n, 2): y to the left and z up, convex; its lowest point stands bottom_m above the ground
    """
    lift = bottom_m - float(outline[:, 1].min())
    mesh = Mesh()
    mesh.add(cylinder(0.03, -0.3, bottom_m + float(np.ptp(outline[:, 1]))), Material.METAL)
    for x_m, material in ((-0.04, Material.RETRO), (-0.03, Material.METAL)):
        corners = np.column_stack((np.full(len(outline), x_m), outline[:, 0], outline[:, 1] + lift))
        middle = np.broadcast_to(corners.mean(axis=0), corners.shape)
        mesh.add(np.stack((middle, corners, np.roll(corners, -1, axis=0)), axis=1), material)
    return mesh.packed()


def sign_on_post(kind: SignKind) -> PackedMesh:
    """The usual board of a kind."""
    return board_on_post(octagon() if kind == "stop" else triangle())


def sign_poses(road_map: RoadMap, ground: Ground) -> Array:
    """(n, 3) x, y, yaw of the map's signs: beside their stop line, just beyond the road's edge."""
    lines = {lane.lane_id: np.array(lane.points) for lane in road_map.lanes}
    poses = [_pose(sign, lines[sign.lane_id], ground) for sign in road_map.signs]
    return np.array(poses, dtype=np.float64).reshape(-1, 3)


def _pose(sign: RoadSign, line: Array, ground: Ground) -> tuple[float, float, float]:
    """Sideways from the line until the road ends; where it does not, as in a wide junction, at 6 m."""
    x_m, y_m, yaw = pose_at(line, arc_lengths(line), sign.s_m)
    side = 1.0 if sign.side == "left" else -1.0
    across = np.arange(1.0, _FARTHEST_M, _STEP_M)
    px = x_m - side * across * math.sin(yaw)
    py = y_m + side * across * math.cos(yaw)
    beyond = np.flatnonzero(ground.inside_at(px, py) <= -_BEYOND_M)
    at = int(beyond[0]) if len(beyond) else len(across) - 1
    return float(px[at]), float(py[at]), float(yaw)

"""People around a camera at one moment, each in clothes of its own."""

import math

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.cameras.figures import Figure, Wardrobe
from simulator.sensors.scene.ground import Ground
from simulator.sensors.scene.materials import Material
from simulator.sensors.scene.mesh import PackedMesh
from simulator.sensors.scene.static_scene import Array32, CastScene
from simulator.traffic.actors import Bodies

# As in `scene.moving_scene`: legs that a lidar and a camera see swing alike.
_STEP_M = 0.7
_WALKING_MPS = 0.2

# Linear reflectances of red, green and blue.
_SKINS = np.array([(0.55, 0.36, 0.27), (0.42, 0.25, 0.17), (0.22, 0.12, 0.08), (0.60, 0.42, 0.33)])
_HAIRS = np.array([(0.02, 0.018, 0.016), (0.06, 0.035, 0.02), (0.25, 0.16, 0.07), (0.30, 0.30, 0.30)])
_TOPS = np.array(
    [
        (0.03, 0.03, 0.035), (0.65, 0.65, 0.62), (0.40, 0.05, 0.05), (0.04, 0.08, 0.30), (0.12, 0.13, 0.12),
        (0.45, 0.38, 0.12), (0.05, 0.18, 0.09), (0.30, 0.32, 0.36), (0.55, 0.28, 0.30), (0.02, 0.03, 0.08),
    ]
)  # fmt: skip
_BOTTOMS = np.array(
    [(0.02, 0.02, 0.025), (0.05, 0.07, 0.16), (0.10, 0.12, 0.20), (0.30, 0.25, 0.17), (0.14, 0.14, 0.14)]
)
_SHOES = np.array([(0.02, 0.02, 0.02), (0.50, 0.50, 0.50), (0.12, 0.07, 0.04)])


class ClothedPeople:
    """One moment's people: `scene` to cast rays at, `colours` (n, 3) of its triangles, their `numbers`."""

    def __init__(
        self, mesh: PackedMesh, colours: Array32, boxes_map: Array, numbers: NDArray[np.int64]
    ) -> None:
        """boxes_map (k, 4): x, y, z of the feet and the height of each person."""
        self.mesh, self.scene = mesh, CastScene(mesh)
        assert len(self.scene.triangles) == len(colours), "a figure has a triangle without an area"
        self.colours, self.boxes_map, self.numbers = colours, boxes_map, numbers


class PeopleDresser:
    """Dresses the pedestrians of a world. The same number always wears the same."""

    def __init__(self, ground: Ground, seed: int = 0) -> None:
        """seed: of the clothes."""
        self._ground, self._seed = ground, seed
        self._wardrobe = Wardrobe()
        self._clothes: dict[int, tuple[int, Array]] = {}

    def of(self, bodies: Bodies) -> ClothedPeople:
        """The people among the bodies; the others are left out."""
        people = bodies.selected(bodies.people)
        count = len(people.numbers)
        z_m = self._ground.height_m(people.poses_map[:, 0], people.poses_map[:, 1])
        scales = 0.9 + 0.02 * (people.numbers * 7 % 10)
        boxes = np.column_stack((people.poses_map[:, :2], z_m, 1.76 * scales)).reshape(count, 4)
        triangles, colours, owners = [], [], []
        for k in range(count):
            number = int(people.numbers[k])
            style, palette = self._worn(number)
            body = self._figure(people, k, style)
            triangles.append(_placed(body.triangles, people.poses_map[k], float(z_m[k]), float(scales[k])))
            colours.append(palette[body.parts])
            owners.append(np.full(len(body.parts), number, dtype=np.int32))
        every = np.concatenate(colours).astype(np.float32) if count else np.empty((0, 3), np.float32)
        return ClothedPeople(_mesh(triangles, owners), every, boxes, people.numbers)

    def _figure(self, people: Bodies, k: int, style: int) -> Figure:
        x_m, y_m, yaw_rad = people.poses_map[k]
        way_m = x_m * math.cos(yaw_rad) + y_m * math.sin(yaw_rad) + 0.37 * float(people.numbers[k])
        speed_mps = float(np.hypot(*people.velocities_map_mps[k]))
        phase_rad = math.pi * way_m / _STEP_M - 0.5 * math.pi
        return self._wardrobe.figure(style, phase_rad, speed_mps >= _WALKING_MPS)

    def _worn(self, number: int) -> tuple[int, Array]:
        """(style, colours (6, 3)) of one person."""
        if number not in self._clothes:
            rng = np.random.default_rng([self._seed, number, *b"clothes"])
            tables = (_SKINS, _HAIRS, _TOPS, _BOTTOMS, _SHOES, _TOPS)
            palette = np.stack([table[rng.integers(len(table))] for table in tables])
            self._clothes[number] = int(rng.integers(Wardrobe.STYLES)), palette
        return self._clothes[number]


def _placed(triangles: Array32, pose_map: Array, z_m: float, scale: float) -> Array32:
    cos, sin = math.cos(pose_map[2]), math.sin(pose_map[2])
    turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    moved = scale * (triangles @ turn) + np.array([pose_map[0], pose_map[1], z_m])
    placed: Array32 = moved.astype(np.float32)
    return placed


def _mesh(triangles: list[Array32], owners: list[NDArray[np.int32]]) -> PackedMesh:
    count = sum(len(part) for part in triangles)
    return PackedMesh(
        np.concatenate(triangles) if count else np.empty((0, 3, 3), np.float32),
        np.full(count, Material.CLOTHES, dtype=np.uint8),
        np.full(count, 0.38, dtype=np.float32),
        np.concatenate(owners) if count else np.empty(0, np.int32),
    )

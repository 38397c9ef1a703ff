"""Bodies of many builds, for scenes in which a detector learns: more of them than a world has."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.scene import shapes
from simulator.sensors.scene.ground import Ground
from simulator.sensors.scene.materials import Material
from simulator.sensors.scene.mesh import Mesh, PackedMesh, box, cylinder, joined, wheel
from simulator.sensors.scene.moving_scene import STRIDES, SWING_RAD, nothing, strides_of
from simulator.sensors.scene.static_scene import CastScene
from simulator.traffic.actors import Bodies
from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN, VEHICLE


@dataclass(frozen=True, slots=True, eq=False)
class Build:
    """One build of body. templates: one, or one for each stride; size_m: length, width, height of them."""

    kind: int
    templates: tuple[PackedMesh, ...]
    size_m: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """How each body looks. builds (n,) of `BUILDS`; scales (n, 3) of their templates; shades (n,)"""

    builds: NDArray[np.int64]
    scales: Array
    shades: Array


def _walker(extra: Array | None = None) -> Build:
    """A person with what they carry or wear; the size is that of the disc which stands for a person."""
    strides = np.linspace(-SWING_RAD, SWING_RAD, STRIDES)
    people = []
    for stride in strides:
        person = shapes.person(1.75, float(stride))
        if extra is not None:
            mesh = Mesh()
            mesh.add(extra, Material.CLOTHES, 0.8)
            person = joined([person, mesh.packed()])
        people.append(person)
    return Build(PEDESTRIAN, tuple(people), (0.5, 0.5, 1.75))


def _of(kind: int, size_m: tuple[float, float, float], *parts: tuple[Array, Material]) -> Build:
    mesh = Mesh()
    for triangles, material in parts:
        mesh.add(triangles, material)
    return Build(kind, (mesh.packed(),), size_m)


def _wheels(x_m: float, y_m: float, radius_m: float) -> Array:
    return np.concatenate([wheel(x, y, radius_m, 0.2) for x in (-x_m, x_m) for y in (-y_m, y_m)])


def _builds() -> tuple[Build, ...]:
    backpack = box((-0.38, -0.16, 1.0), (-0.12, 0.16, 1.45))
    coat = cylinder(0.24, 0.35, 1.0, 8, 0.16)
    umbrella = cylinder(0.5, 1.95, 2.1, 8, 0.05)
    paint, glass, metal, rubber = Material.CAR_PAINT, Material.GLASS, Material.METAL, Material.RUBBER
    return (
        _walker(), _walker(backpack), _walker(coat), _walker(umbrella),
        Build(CYCLIST, (shapes.cyclist(),), (1.75, 0.6, 1.75)),
        Build(
            CYCLIST, (joined([shapes.cyclist(), _box((-0.8, -0.25, 0.7), (-0.4, 0.25, 1.15))]),),
            (1.75, 0.6, 1.75),
        ),
        Build(VEHICLE, (shapes.car(),), (4.4, 1.8, 1.48)),
        # A van, and a car whose roof goes to its rear.
        _of(VEHICLE, (4.9, 1.95, 1.95), (box((-2.45, -0.97, 0.3), (2.45, 0.97, 1.0), 0.97), paint),
            (box((-2.4, -0.95, 1.0), (1.4, 0.95, 1.95), 0.93), paint),
            (box((1.4, -0.8, 1.0), (1.9, 0.8, 1.6), 0.8), glass),
            (_wheels(1.55, 0.86, 0.34), rubber)),
        _of(VEHICLE, (4.2, 1.8, 1.65), (box((-2.1, -0.9, 0.28), (2.1, 0.9, 0.9), 0.97), paint),
            (box((-2.05, -0.85, 0.9), (0.9, 0.85, 1.58), 0.82), glass),
            (box((-1.8, -0.7, 1.55), (0.6, 0.7, 1.65), 0.98), paint),
            (_wheels(1.35, 0.8, 0.33), rubber)),
        Build(VEHICLE, (shapes.truck(),), (7.0, 2.3, 3.1)),
        Build(VEHICLE, (shapes.shuttle(4.35, 1.63, 2.28, 2.175),), (4.35, 1.63, 2.28)),
        # What stands about and is none of these: bin, box, cone, pole, board, planter, panel, pillar.
        _of(OTHER, (0.6, 0.6, 1.0), (box((-0.3, -0.3, 0.0), (0.3, 0.3, 1.0), 0.95), metal)),
        _of(OTHER, (0.5, 0.3, 0.7), (box((-0.25, -0.15, 0.0), (0.25, 0.15, 0.7)), Material.CLOTHES)),
        _of(OTHER, (0.4, 0.4, 0.75), (cylinder(0.2, 0.0, 0.75, 8, 0.03), Material.RETRO)),
        _of(OTHER, (0.2, 0.2, 2.5), (cylinder(0.08, 0.0, 2.5), metal)),
        _of(OTHER, (0.7, 0.1, 1.1), (box((-0.35, -0.05, 0.0), (0.35, 0.05, 1.1)), Material.WOOD)),
        _of(OTHER, (1.6, 0.8, 0.8), (box((-0.8, -0.4, 0.0), (0.8, 0.4, 0.5)), Material.BRICK),
            (cylinder(0.4, 0.5, 0.9, 7, 0.2), Material.GRASS)),
        _of(OTHER, (2.4, 0.1, 2.0), (box((-1.2, -0.05, 0.0), (1.2, 0.05, 2.0)), metal)),
        _of(OTHER, (0.5, 0.5, 1.6), (cylinder(0.25, 0.0, 1.6, 8, 0.22), Material.BRICK)),
    )  # fmt: skip


def _box(low: tuple[float, float, float], high: tuple[float, float, float]) -> PackedMesh:
    mesh = Mesh()
    mesh.add(box(low, high), Material.METAL)
    return mesh.packed()


class VariedBodies:
    """Draws bodies' looks and makes scenes of them on one ground; the templates are made once."""

    def __init__(self, ground: Ground) -> None:
        self._ground = ground
        self.builds = _builds()

    def draw(self, kinds: NDArray[np.int64], rng: np.random.Generator) -> Looks:
        """A build of each kind, with a size and shade of its own."""
        of_kind = {
            kind: [i for i, b in enumerate(self.builds) if b.kind == kind] for kind in set(kinds.tolist())
        }
        builds = np.array([rng.choice(of_kind[int(kind)]) for kind in kinds], dtype=np.int64)
        scales = 1.0 + rng.uniform(-0.12, 0.12, (len(kinds), 3))
        # Children are smaller all over.
        small = (kinds == PEDESTRIAN) & (rng.random(len(kinds)) < 0.15)
        scales[small] *= rng.uniform(0.6, 0.85, (int(small.sum()), 1))
        return Looks(builds, scales, rng.uniform(0.4, 1.6, len(kinds)))

    def sizes_m(self, looks: Looks) -> Array:
        """(n, 3) length, width, height."""
        sizes = (
            np.array([self.builds[int(build)].size_m for build in looks.builds]).reshape(-1, 3) * looks.scales
        )
        people = np.array([self.builds[int(build)].kind == PEDESTRIAN for build in looks.builds], dtype=bool)
        # A person is a disc.
        sizes[people, :2] = sizes[people, :2].mean(axis=1, keepdims=True)
        return sizes

    def of(self, bodies: Bodies, looks: Looks) -> CastScene:
        """The scene of these bodies; those on wheels stand at the road's height, the others on the ground."""
        if not len(bodies.numbers):
            return CastScene(nothing())
        x, y, yaw = bodies.poses_map.T
        wheeled = (bodies.kinds == VEHICLE) | (bodies.kinds == CYCLIST)
        z = np.where(wheeled, self._ground.road_m(x, y), self._ground.height_m(x, y))
        poses = np.column_stack((x, y, z, yaw))
        strides = strides_of(bodies)
        parts = []
        for build_index in np.unique(looks.builds):
            templates = self.builds[int(build_index)].templates
            for stride, template in enumerate(templates):
                rows = looks.builds == build_index
                if len(templates) > 1:
                    rows &= strides == stride
                if rows.any():
                    parts.append(
                        template.placed(
                            poses[rows], looks.scales[rows], looks.shades[rows], bodies.numbers[rows]
                        )
                    )
        return CastScene(joined(parts))

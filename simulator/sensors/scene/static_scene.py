"""One scene of everything that stands still, for all vehicles of a world."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

from contract.geometry import Array
from contract.roads.model import RoadMap
from simulator.sensors.scene.buildings import add_buildings, altered_buildings
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.furniture import Furniture
from simulator.sensors.scene.ground import Ground, GroundParams
from simulator.sensors.scene.ground_mesh import add_ground
from simulator.sensors.scene.mesh import Mesh, PackedMesh, joined

Array32 = NDArray[np.float32]
# Twice the area of a triangle that no beam can hit, m2.
_AREA_MIN = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Surfaces:
    """What a hit triangle is: unit normals (n, 3), materials, reflectivity and objects (n,) each."""

    normals: Array32
    materials: NDArray[np.uint8]
    reflectivity: Array32
    objects: NDArray[np.int32]


class RayTarget(Protocol):
    """What rays are cast at."""

    @property
    def surfaces(self) -> Surfaces: ...

    @property
    def triangles(self) -> Array32: ...

    def cast(
        self, origins: Array32, directions: Array32, reach_m: Array32
    ) -> tuple[Array32, NDArray[np.int32]]: ...


class CastScene:
    """Triangles that rays can be cast at."""

    def __init__(self, mesh: PackedMesh) -> None:
        """Triangles without an area are left out."""
        normals = np.cross(
            mesh.triangles[:, 1] - mesh.triangles[:, 0], mesh.triangles[:, 2] - mesh.triangles[:, 0]
        )
        lengths = np.linalg.norm(normals, axis=1)
        whole = lengths > _AREA_MIN
        if not whole.all():
            mesh, normals, lengths = mesh.selected(whole), normals[whole], lengths[whole]
        normals /= lengths[:, None]
        self.surfaces = Surfaces(
            normals.astype(np.float32, copy=False), mesh.materials, mesh.reflectivity, mesh.objects
        )
        self.triangles = mesh.triangles
        self._scene: EmbreeScene | None = None
        if len(self.triangles):
            self._scene = EmbreeScene()
            # embreex keeps no reference of its own.
            self._mesh = TriangleMesh(self._scene, self.triangles)

    def cast(
        self, origins: Array32, directions: Array32, reach_m: Array32
    ) -> tuple[Array32, NDArray[np.int32]]:
        """(ranges, triangles) of the nearest hits, (n,) each; -1 where nothing is nearer than reach_m.

        origins, directions (n, 3), reach_m (n,): float32, contiguous; directions of length 1
        """
        if self._scene is None or not len(origins):
            return reach_m, np.full(len(origins), -1, dtype=np.int32)
        hits = self._scene.run(origins, directions, reach_m, query="INTERSECT", output=1)
        return hits["tfar"], hits["primID"]


class StaticScene(CastScene):
    """The surroundings of a map: ground, buildings, and what stands beside the roads.

    The same map, seed, changes and ground give the same triangles. `ground` has the heights; vehicles stand
    at `ground.poses`. `parked` (k, 6) has x, y, yaw, length, width, height of the parked vehicles.
    """

    def __init__(
        self,
        road_map: RoadMap,
        seed: int,
        changes: WorldChanges | None = None,
        ground: GroundParams | None = None,
        placed: Sequence[PackedMesh] = (),
        *,
        is_furnished: bool = True,
    ) -> None:
        """placed: what stands there besides, map frame; is_furnished: False for ground and buildings alone.

        Raises SceneError for a map without lanes.
        """
        self.changes = changes or WorldChanges()
        self.ground = Ground(road_map, seed, ground)
        self.buildings = altered_buildings(road_map.buildings, self.changes)
        mesh = Mesh()
        add_ground(mesh, self.ground)
        add_buildings(mesh, self.ground, self.buildings, seed)
        parts = [mesh.packed(), *placed]
        self.sway_phases: NDArray[np.float32] = np.zeros(1, np.float32)
        self.parked: Array = np.empty((0, 6))
        if is_furnished:
            furniture = Furniture(self.ground, road_map, seed, self.changes)
            self.sway_phases, self.parked = furniture.sway_phases, furniture.parked
            parts += furniture.parts
        super().__init__(joined(parts))
        self._build_hierarchy()

    def _build_hierarchy(self) -> None:
        """Embree sorts its triangles at the first ray, which takes too long for the first scan of a drive."""
        up = np.array([[0.0, 0.0, 1.0]], dtype=np.float32)
        self.cast(up, up, np.ones(1, dtype=np.float32))

"""The buildings of a map as a ray-casting scene."""

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from contract.roads.model import Building
from simulator.sensors.ray_hits import Array32


class WallScene:
    """Walls of extruded outlines, built once; roofs are above every sensor's view and left out."""

    def __init__(self, buildings: tuple[Building, ...]) -> None:
        triangles = [triangle for building in buildings for triangle in _walls(building)]
        self._scene: EmbreeScene | None = None
        if triangles:
            self._scene = EmbreeScene()
            self._mesh = TriangleMesh(self._scene, np.array(triangles, dtype=np.float32))

    def cast(self, origins: Array32, directions: Array32, reach: Array32) -> Array32:
        """(rays,) distance to the first wall, or `reach` where none is nearer."""
        if self._scene is None:
            return reach
        hit: Array32 = self._scene.run(origins, directions, reach, query="DISTANCE")
        return hit


def _walls(building: Building) -> list[list[tuple[float, float, float]]]:
    outline, top = building.outline, building.height_m
    triangles = []
    for (ax, ay), (bx, by) in zip(outline, outline[1:] + outline[:1], strict=True):
        triangles.append([(ax, ay, 0.0), (bx, by, 0.0), (bx, by, top)])
        triangles.append([(ax, ay, 0.0), (bx, by, top), (ax, ay, top)])
    return triangles

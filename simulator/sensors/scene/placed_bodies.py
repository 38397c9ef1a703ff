"""Copies of templates that move: rays are taken to the template, so that nothing is built for a moment."""

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.scene.mesh import PackedMesh
from simulator.sensors.scene.ray_bundles import passing
from simulator.sensors.scene.static_scene import Array32, CastScene, Surfaces

Ints = NDArray[np.int64]


class Template:
    """A shape that is placed many times, at the origin with x ahead."""

    def __init__(self, mesh: PackedMesh) -> None:
        self.scene = CastScene(mesh)
        surfaces = self.scene.surfaces
        # Without the triangles that no ray can meet.
        self.mesh = PackedMesh(
            self.scene.triangles, surfaces.materials, surfaces.reflectivity, surfaces.objects
        )
        corners = self.scene.triangles.reshape(-1, 3)
        self.middle: Array = 0.5 * (corners.min(axis=0) + corners.max(axis=0)).astype(np.float64)
        self.radius_m = float(np.linalg.norm(corners - self.middle, axis=1).max())


class PlacedBodies:
    """Bodies at one moment; rays are cast at them as at a `CastScene`."""

    def __init__(
        self, templates: Sequence[Template], chosen: Ints, poses: Array, scales: Array, numbers: Ints
    ) -> None:
        """chosen (k,), rising: the template of each body; poses (k, 4) x, y, z, yaw; scales (k, 3)."""
        self._templates, self._chosen = templates, chosen
        self._poses, self._scales, self._numbers = poses, scales, numbers
        sizes = np.array([len(templates[k].scene.triangles) for k in chosen.tolist()], dtype=np.int64)
        # The triangles of all bodies are counted through, body after body.
        self._first: Ints = np.cumsum(sizes) - sizes
        self._sizes = sizes
        self._spheres = _spheres(templates, chosen, poses, scales)

    @cached_property
    def triangles(self) -> Array32:
        """(n, 3, 3) in the map's frame."""
        parts = [
            self._templates[k].mesh.placed(self._poses[row : row + 1], self._scales[row : row + 1]).triangles
            for row, k in enumerate(self._chosen.tolist())
        ]
        return np.concatenate(parts) if parts else np.empty((0, 3, 3), dtype=np.float32)

    @cached_property
    def surfaces(self) -> Surfaces:
        """Of all triangles."""
        own = [self._templates[k].scene.surfaces for k in self._chosen.tolist()]
        if not own:
            return Surfaces(
                np.empty((0, 3), np.float32),
                np.empty(0, np.uint8),
                np.empty(0, np.float32),
                np.empty(0, np.int32),
            )
        return Surfaces(
            _turned(np.concatenate([one.normals for one in own]), self._sizes, self._poses, self._scales),
            np.concatenate([one.materials for one in own]),
            np.concatenate([one.reflectivity for one in own]),
            np.repeat(self._numbers.astype(np.int32), self._sizes),
        )

    def cast(
        self, origins: Array32, directions: Array32, reach_m: Array32
    ) -> tuple[Array32, NDArray[np.int32]]:
        """(ranges, triangles) of the nearest hits, as `CastScene.cast` gives them."""
        near_m, triangles = reach_m.copy(), np.full(len(origins), -1, dtype=np.int32)
        rays, bodies = passing(origins, directions, reach_m, self._spheres)
        if not len(rays):
            return near_m, triangles
        starts, ways = _taken_to_bodies(origins, directions, rays, bodies, self._poses, self._scales)
        reach = reach_m[rays]
        kinds = self._chosen[bodies]
        ends = [*np.flatnonzero(np.diff(kinds)) + 1, len(kinds)]
        begin = 0
        for end in ends:
            part = slice(begin, end)
            met_m, met = self._templates[kinds[begin]].scene.cast(starts[part], ways[part], reach[part])
            _keep_nearest(rays[part], bodies[part], met_m, met, self._first, near_m, triangles)
            begin = int(end)
        return near_m, triangles


def _spheres(templates: Sequence[Template], chosen: Ints, poses: Array, scales: Array) -> Array:
    """(k, 4) x, y, z and radius around each body."""
    spheres = np.empty((len(chosen), 4))
    if len(chosen):
        middles = np.array([templates[k].middle for k in chosen.tolist()]) * scales
        cos, sin = np.cos(poses[:, 3]), np.sin(poses[:, 3])
        spheres[:, 0] = poses[:, 0] + cos * middles[:, 0] - sin * middles[:, 1]
        spheres[:, 1] = poses[:, 1] + sin * middles[:, 0] + cos * middles[:, 1]
        spheres[:, 2] = poses[:, 2] + middles[:, 2]
        radii = np.array([templates[k].radius_m for k in chosen.tolist()])
        # Ranges are float32: a little more than the corners reach.
        spheres[:, 3] = radii * scales.max(axis=1) + 0.01
    return spheres


@njit(cache=True)
def _taken_to_bodies(
    origins: Array32, directions: Array32, rays: Ints, bodies: Ints, poses: Array, scales: Array
) -> tuple[Array32, Array32]:
    """The rays in their bodies' own frames and scales; the ways' length makes ranges stay what they are."""
    starts = np.empty((rays.shape[0], 3), dtype=np.float32)
    ways = np.empty((rays.shape[0], 3), dtype=np.float32)
    for j in range(rays.shape[0]):
        k, b = rays[j], bodies[j]
        cos, sin = math.cos(poses[b, 3]), math.sin(poses[b, 3])
        dx, dy, dz = origins[k, 0] - poses[b, 0], origins[k, 1] - poses[b, 1], origins[k, 2] - poses[b, 2]
        starts[j, 0] = (cos * dx + sin * dy) / scales[b, 0]
        starts[j, 1] = (cos * dy - sin * dx) / scales[b, 1]
        starts[j, 2] = dz / scales[b, 2]
        ways[j, 0] = (cos * directions[k, 0] + sin * directions[k, 1]) / scales[b, 0]
        ways[j, 1] = (cos * directions[k, 1] - sin * directions[k, 0]) / scales[b, 1]
        ways[j, 2] = directions[k, 2] / scales[b, 2]
    return starts, ways


@njit(cache=True)
def _keep_nearest(
    rays: Ints,
    bodies: Ints,
    met_m: Array32,
    met: NDArray[np.int32],
    first: Ints,
    near_m: Array32,
    triangles: NDArray[np.int32],
) -> None:
    for j in range(rays.shape[0]):
        k = rays[j]
        if met[j] >= 0 and met_m[j] < near_m[k]:
            near_m[k] = met_m[j]
            triangles[k] = first[bodies[j]] + met[j]


@njit(cache=True)
def _turned(normals: Array32, sizes: Ints, poses: Array, scales: Array) -> Array32:
    """The templates' normals (n, 3), `sizes` (k,) of them for each body, as they are in the map's frame."""
    out = np.empty_like(normals)
    t = 0
    for b in range(sizes.shape[0]):
        cos, sin = math.cos(poses[b, 3]), math.sin(poses[b, 3])
        for _ in range(sizes[b]):
            x, y = normals[t, 0] / scales[b, 0], normals[t, 1] / scales[b, 1]
            z = normals[t, 2] / scales[b, 2]
            length = math.sqrt(x * x + y * y + z * z)
            out[t, 0] = (cos * x - sin * y) / length
            out[t, 1] = (sin * x + cos * y) / length
            out[t, 2] = z / length
            t += 1
    return out

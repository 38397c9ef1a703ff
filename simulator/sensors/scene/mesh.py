"""Triangles with their material, shade and object, and the solids that they are made of."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.scene.materials import REFLECTIVITY, Material

Triangles = NDArray[np.float32]


@dataclass(slots=True)
class Mesh:
    """Triangles as they are collected.

    triangles    (n, 3, 3) corners, m
    materials    (n,) of `Material`
    reflectivity (n,) 0..1
    objects      (n,) which object a triangle belongs to, counted from 0; -1 for the ground and buildings
    """

    triangles: list[Triangles] = field(default_factory=list)
    materials: list[NDArray[np.uint8]] = field(default_factory=list)
    reflectivity: list[NDArray[np.float32]] = field(default_factory=list)
    objects: list[NDArray[np.int32]] = field(default_factory=list)

    def add(
        self, triangles: Array | Triangles, material: Material, shade: float = 1.0, number: int = -1
    ) -> None:
        """Triangles (n, 3, 3) of one material; shade multiplies its reflectivity."""
        count = len(triangles)
        self.triangles.append(np.asarray(triangles, dtype=np.float32).reshape(count, 3, 3))
        self.materials.append(np.full(count, material, dtype=np.uint8))
        self.reflectivity.append(np.full(count, min(1.0, REFLECTIVITY[material] * shade), dtype=np.float32))
        self.objects.append(np.full(count, number, dtype=np.int32))

    def packed(self) -> "PackedMesh":
        """One array of each."""
        if not self.triangles:
            return PackedMesh(
                np.empty((0, 3, 3), dtype=np.float32),
                np.empty(0, dtype=np.uint8),
                np.empty(0, dtype=np.float32),
                np.empty(0, dtype=np.int32),
            )
        return PackedMesh(
            np.concatenate(self.triangles),
            np.concatenate(self.materials),
            np.concatenate(self.reflectivity),
            np.concatenate(self.objects),
        )


@dataclass(frozen=True, slots=True, eq=False)
class PackedMesh:
    """Triangles in arrays, as in `Mesh`."""

    triangles: Triangles
    materials: NDArray[np.uint8]
    reflectivity: NDArray[np.float32]
    objects: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.triangles)

    def placed(
        self, poses: Array, scales: Array, shades: Array | None = None, first_number: int = 0
    ) -> "PackedMesh":
        """A copy for each pose.

        poses   (k, 4) x, y, z, yaw
        scales  (k, 3) along the copy's own axes
        shades  (k,) multiply the reflectivity
        """
        k, m = len(poses), len(self.triangles)
        corners = self.triangles.reshape(1, m * 3, 3) * scales[:, None, :].astype(np.float32)
        cos = np.cos(poses[:, 3])[:, None].astype(np.float32)
        sin = np.sin(poses[:, 3])[:, None].astype(np.float32)
        placed = np.empty((k, m * 3, 3), dtype=np.float32)
        placed[:, :, 0] = cos * corners[:, :, 0] - sin * corners[:, :, 1] + poses[:, 0, None]
        placed[:, :, 1] = sin * corners[:, :, 0] + cos * corners[:, :, 1] + poses[:, 1, None]
        placed[:, :, 2] = corners[:, :, 2] + poses[:, 2, None]
        reflectivity = np.tile(self.reflectivity, k)
        if shades is not None:
            reflectivity = np.minimum(1.0, reflectivity * np.repeat(shades, m)).astype(np.float32)
        return PackedMesh(
            placed.reshape(k * m, 3, 3),
            np.tile(self.materials, k),
            reflectivity,
            np.repeat(np.arange(first_number, first_number + k, dtype=np.int32), m),
        )


def joined(parts: list[PackedMesh]) -> PackedMesh:
    """All parts, in this order."""
    return PackedMesh(
        np.concatenate([part.triangles for part in parts]),
        np.concatenate([part.materials for part in parts]),
        np.concatenate([part.reflectivity for part in parts]),
        np.concatenate([part.objects for part in parts]),
    )


def quads(corners: Array) -> Array:
    """(2n, 3, 3) triangles of (n, 4, 3) quadrilaterals, corner after corner around each."""
    return np.concatenate((corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]))


def box(low: tuple[float, float, float], high: tuple[float, float, float], taper: float = 1.0) -> Array:
    """(10, 3, 3) a box without a floor; its top is narrower by `taper` along both axes."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    mx, my, hx, hy = 0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.5 * taper * (x1 - x0), 0.5 * taper * (y1 - y0)
    b = [(x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0)]
    t = [(mx - hx, my - hy, z1), (mx + hx, my - hy, z1), (mx + hx, my + hy, z1), (mx - hx, my + hy, z1)]
    sides = [[b[i], b[(i + 1) % 4], t[(i + 1) % 4], t[i]] for i in range(4)]
    return quads(np.array([*sides, t], dtype=np.float64))


def cylinder(
    radius_m: float, low_m: float, high_m: float, sides: int = 8, top_radius_m: float | None = None
) -> Array:
    """(2 sides, 3, 3) an upright mantle about the z axis."""
    angles = 2.0 * math.pi * np.arange(sides + 1) / sides
    ring = np.column_stack((np.cos(angles), np.sin(angles)))
    top = radius_m if top_radius_m is None else top_radius_m
    b = np.column_stack((radius_m * ring, np.full(sides + 1, low_m)))
    t = np.column_stack((top * ring, np.full(sides + 1, high_m)))
    return quads(np.stack((b[:-1], b[1:], t[1:], t[:-1]), axis=1))


def wheel(x_m: float, y_m: float, radius_m: float, width_m: float, sides: int = 10) -> Array:
    """A wheel that stands on z = 0 with its axle along y: mantle and outer face."""
    angles = 2.0 * math.pi * np.arange(sides + 1) / sides
    x, z = x_m + radius_m * np.cos(angles), radius_m + radius_m * np.sin(angles)
    inner, outer = (y_m - 0.5 * width_m, y_m + 0.5 * width_m)
    a = np.column_stack((x, np.full(sides + 1, inner), z))
    b = np.column_stack((x, np.full(sides + 1, outer), z))
    face = b if y_m > 0.0 else a
    middle = np.array([x_m, face[0, 1], radius_m])
    disc = np.stack((np.broadcast_to(middle, (sides, 3)), face[:-1], face[1:]), axis=1)
    return np.concatenate((quads(np.stack((a[:-1], a[1:], b[1:], b[:-1]), axis=1)), disc))

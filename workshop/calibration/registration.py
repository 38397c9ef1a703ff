"""One scan onto the surfaces of another, from a guess that may be metres off."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from contract.geometry import Array
from contract.transforms import moved, rotation_of
from workshop.calibration.cells import thin
from workshop.calibration.planes import Plane

_THIN_M = 0.2
_NEIGHBOURS = 12
_SURFACE_M = 1.2
_ON_PLANE_M = 0.1
_SOURCE_MAX = 3_000
# Distances to what a point may belong to, from coarse to fine, and steps with each.
_REACHES_M = (2.0, 1.0, 0.5, 0.25)
_STEPS = 8
_NEAR_M = 0.4
_ON_M = 0.12


@dataclass(frozen=True, slots=True, eq=False)
class Surfaces:
    """points (n, 3) of a scan and the normals (n, 3) of the surfaces around them."""

    points: Array
    normals: Array
    tree: cKDTree


def surfaces_of(points: Array, planes: Sequence[Plane] = ()) -> Surfaces:
    """The points of a scan (n, 3), thinned, that have a surface around them.

    Those on one of its planes have that plane's normal: where few beams meet the ground, the points around
    one are all of one ring and have none.
    """
    thinned = thin(points, _THIN_M)
    of_planes, normals_of_planes = [], []
    for plane in planes:
        beside = np.abs(thinned @ plane.normal + plane.offset_m) < _ON_PLANE_M
        members = thin(plane.points, _THIN_M)
        if beside.any():
            alone = cKDTree(members).query(thinned, distance_upper_bound=_THIN_M * 2.0)[0] == np.inf
            thinned = thinned[~beside | alone]
        of_planes.append(members)
        normals_of_planes.append(np.tile(plane.normal, (len(members), 1)))
    found, normals = _with_normals(thinned)
    found, normals = np.vstack([found, *of_planes]), np.vstack([normals, *normals_of_planes])
    return Surfaces(found, normals, cKDTree(found))


def _with_normals(thinned: Array) -> tuple[Array, Array]:
    if len(thinned) < _NEIGHBOURS:
        return thinned[:0], thinned[:0]
    distances, which = cKDTree(thinned).query(thinned, k=_NEIGHBOURS)
    around = thinned[which]
    centred = around - around.mean(axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(centred.swapaxes(1, 2) @ centred / around.shape[1])
    # Flat, no line, and near: else its normal means nothing.
    flat = (values[:, 0] < 0.1 * values[:, 1]) & (values[:, 1] > 0.05 * values[:, 2])
    flat &= distances[:, -1] < _SURFACE_M
    return thinned[flat], vectors[flat, :, 0]


def sample(points: Array) -> Array:
    """Some thousand points of a scan, evenly chosen."""
    thinned = thin(points, _THIN_M)
    return thinned[:: max(1, len(thinned) // _SOURCE_MAX)]


def register(source: Array, onto: Surfaces, guess: Array) -> Array:
    """T_onto_source by iterated point-to-plane steps; source (n, 3), guess (4, 4)."""
    transform = guess.copy()
    for reach_m in _REACHES_M:
        for _ in range(_STEPS):
            step = _step(moved(transform, source), onto, reach_m)
            rotation = rotation_of(step[:3])
            transform[:3, :3] = rotation @ transform[:3, :3]
            transform[:3, 3] = rotation @ transform[:3, 3] + step[3:]
            if np.abs(step).max() < 1e-5:
                break
    return transform


def fitting_share(source: Array, onto: Surfaces, transform: Array) -> float:
    """Share of the source's points that lie on a surface, of those that are near one and of all, multiplied.

    Points that are not near any surface say little (the other sensor does not see there), those near one that
    are not on it say that the pose is wrong.
    """
    points = moved(transform, source)
    distances, which = onto.tree.query(points, distance_upper_bound=_NEAR_M * 3)
    near = np.isfinite(distances)
    if not near.any():
        return 0.0
    apart = np.einsum("ij,ij->i", onto.normals[which[near]], points[near] - onto.points[which[near]])
    on = (np.abs(apart) < _ON_M) & (distances[near] < _NEAR_M)
    return math.sqrt(on.sum() / near.sum() * on.sum() / len(points))


def _step(points: Array, onto: Surfaces, reach_m: float) -> Array:
    """(6,) turn and shift that bring the points nearer to their surfaces."""
    distances, which = onto.tree.query(points, distance_upper_bound=reach_m)
    near = np.flatnonzero(np.isfinite(distances))
    if len(near) < 20:
        return np.zeros(6)
    normals = onto.normals[which[near]]
    apart = np.einsum("ij,ij->i", normals, points[near] - onto.points[which[near]])
    weights = 1.0 / (1.0 + (apart / (0.2 * reach_m)) ** 2)
    rows = np.column_stack((np.cross(points[near], normals), normals))
    information = (rows * weights[:, None]).T @ rows
    # Directions that no surface fixes do not move.
    information += 1e-4 * np.trace(information) / 6.0 * np.eye(6)
    return np.linalg.solve(information, -(rows * weights[:, None]).T @ apart)

"""A map laid on another of the same frame: point to plane, from a wide reach to a narrow one."""

import math
from collections.abc import Callable

import msgspec
import numpy as np
from scipy.spatial import cKDTree

from contract.geometry import Array
from contract.point_map.tiles import Surfels


class AlignmentParams(msgspec.Struct, frozen=True):
    """reach_m  from an element to its partner, one round after the other
    kernel_m    residuals of this size have a quarter of their weight (Geman-McClure)
    up_min      elements with so much of their normal upwards are ground, whose height comes first
    steps_max, step_min  of each round; m and rad
    partners_min  fewer pairs say nothing
    """

    reach_m: tuple[float, ...] = (1.5, 0.8, 0.6)
    kernel_m: tuple[float, ...] = (0.5, 0.2, 0.1)
    up_min: float = 0.9
    steps_max: int = 20
    step_min: float = 1e-4
    partners_min: int = 60


class Alignment(msgspec.Struct, frozen=True):
    """T (4, 4): takes the new map into the old one's place.

    residual_median_m, residual_p95_m  across the surfaces that both have, afterwards
    partners  pairs of elements
    """

    T: Array
    residual_median_m: float
    residual_p95_m: float
    partners: int


def aligned(new: Surfels, old: Surfels, params: AlignmentParams) -> Alignment | None:
    """How the new elements lie on the old ones; None if they have too little in common."""
    old_flat, new_flat = _flat(old), _flat(new)
    if len(old_flat) < params.partners_min or len(new_flat) < params.partners_min:
        return None
    T: Array = np.eye(4)
    T[2, 3] = _height_m(new_flat, old_flat, params)
    tree = cKDTree(old_flat.means)
    for reach_m, kernel_m in zip(params.reach_m, params.kernel_m, strict=True):
        for _ in range(params.steps_max):
            step = _step(T, new_flat, old_flat, tree, reach_m, kernel_m, params)
            if step is None:
                return None
            T = _moved(step) @ T
            if float(np.abs(step).max()) < params.step_min:
                break
    apart, _, _ = _pairs(T, new_flat, old_flat, tree, params.reach_m[-1])
    apart = np.abs(apart)
    apart = apart[apart < 3.0 * params.kernel_m[-1]]
    if len(apart) < params.partners_min:
        return None
    return Alignment(T, float(np.median(apart)), float(np.percentile(apart, 95)), len(apart))


def ground_heights(surfels: Surfels, up_min: float = 0.9, near_m: float = 1.5) -> Callable[[Array], Array]:
    """The heights (n,) of a map's ground at places (n, 2), NaN where it has none within near_m."""
    ground = surfels.means[np.abs(surfels.normals[:, 2]) > up_min]
    tree = cKDTree(ground[:, :2]) if len(ground) else None

    def heights(places: Array) -> Array:
        found: Array = np.full(len(places), np.nan)
        for number, near in enumerate([] if tree is None else tree.query_ball_point(places, near_m)):
            if near:
                found[number] = float(np.median(ground[near, 2]))
        return found

    return heights


def laid(surfels: Surfels, T: Array) -> Surfels:
    """The elements moved by T (4, 4)."""
    return Surfels(
        surfels.means @ T[:3, :3].T + T[:3, 3], surfels.normals @ T[:3, :3].T, surfels.std_m, surfels.seen
    )


def _flat(surfels: Surfels) -> Surfels:
    return surfels.selected(np.abs(surfels.normals).sum(axis=1) > 0.0)


def _height_m(new: Surfels, old: Surfels, params: AlignmentParams) -> float:
    """By which the new ground is to be raised: nothing else says it where fixes have no heights."""
    old_ground = old.means[np.abs(old.normals[:, 2]) > params.up_min]
    new_ground = new.means[np.abs(new.normals[:, 2]) > params.up_min]
    if not len(old_ground) or not len(new_ground):
        return 0.0
    apart_m, at = cKDTree(old_ground[:, :2]).query(new_ground[:, :2])
    near = apart_m < 1.0
    return float(np.median(old_ground[at[near], 2] - new_ground[near, 2])) if near.any() else 0.0


def _pairs(T: Array, new: Surfels, old: Surfels, tree: cKDTree, reach_m: float) -> tuple[Array, Array, Array]:
    """(distance of each new element from its partner's plane, its place, the partner's normal)."""
    places, normals = new.means @ T[:3, :3].T + T[:3, 3], new.normals @ T[:3, :3].T
    apart_m, at = tree.query(places, distance_upper_bound=reach_m)
    found = np.flatnonzero(np.isfinite(apart_m))
    found = found[np.abs(np.einsum("ij,ij->i", normals[found], old.normals[at[found]])) > 0.9]
    n = old.normals[at[found]]
    return np.einsum("ij,ij->i", n, places[found] - old.means[at[found]]), places[found], n


def _step(
    T: Array, new: Surfels, old: Surfels, tree: cKDTree, reach_m: float, kernel_m: float,
    params: AlignmentParams,
) -> Array | None:  # fmt: skip
    """(4,) x, y, z and yaw, about the pairs' middle turned to the frame's origin; None without pairs.

    Both maps are level: roll and pitch would only follow noise.
    """
    apart, places, n = _pairs(T, new, old, tree, reach_m)
    if len(apart) < params.partners_min:
        return None
    middle = places.mean(axis=0)
    arms = places - middle
    rows = np.column_stack((n, n[:, 1] * arms[:, 0] - n[:, 0] * arms[:, 1]))
    weights = (kernel_m**2 / (kernel_m**2 + apart**2)) ** 2
    H = (rows * weights[:, None]).T @ rows
    # What nothing holds, as a street's length between two even walls, stays as the fixes have it.
    H += np.diag([1.0, 1.0, 1.0, 100.0]) * 1e-3 * len(apart)
    found = np.linalg.solve(H, -(rows * weights[:, None]).T @ apart)
    turned = _moved(np.array([0.0, 0.0, 0.0, found[3]]))[:3, :3] @ middle
    step: Array = np.array([*(found[:3] + middle - turned), found[3]])
    return step


def _moved(step: Array) -> Array:
    T: Array = np.eye(4)
    c, s = math.cos(float(step[3])), math.sin(float(step[3]))
    T[:2, :2] = [[c, -s], [s, c]]
    T[:3, 3] = step[:3]
    return T

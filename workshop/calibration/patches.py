"""Patches: small planes of the scene that two or more lidars see."""

from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from contract.transforms import inverse, moved
from workshop.calibration.adjustment import Patch
from workshop.calibration.cells import cell_numbers
from workshop.calibration.planes import fit_plane


@dataclass(frozen=True, slots=True)
class PatchSearch:
    """How the scene is cut into patches.

    cell_m         edge of the cells at first; one that holds no plane is halved
    cell_m_min     edge of the smallest
    points_min     of one lidar on a patch
    deviation_m    of the points from a patch's plane, of the lidar that has most there
    points_max     of one lidar on a patch that are used, evenly chosen
    """

    cell_m: float = 4.0
    cell_m_min: float = 0.5
    points_min: int = 6
    deviation_m: float = 0.05
    points_max: int = 400


# A patch whose points are nearly on a line has no direction: its second spread over its edge.
_SPREAD_MIN = 0.06
_SHIFT = 0.371


def find_patches(clouds: list[Array], transforms: Array, gate_m: float, search: PatchSearch) -> list[Patch]:
    """The patches of clouds (n, 3), each in its own frame, at poses (k, 4, 4) right within gate_m."""
    owner = np.repeat(np.arange(len(clouds)), [len(cloud) for cloud in clouds])
    points = np.vstack([moved(t, cloud) for t, cloud in zip(transforms, clouds, strict=True)])
    patches: list[Patch] = []
    left = np.arange(len(points))
    edge_m = search.cell_m
    backs = [inverse(transform) for transform in transforms]
    while edge_m >= search.cell_m_min and len(left):
        # Cells are shifted so that the ground does not lie on their faces.
        cells = cell_numbers(points[left], edge_m, _SHIFT)
        order = np.argsort(cells, kind="stable")
        bounds = np.flatnonzero(np.diff(cells[order])) + 1
        remaining = []
        for members in np.split(left[order], bounds):
            patch = _patch(points[members], owner[members], backs, edge_m, gate_m, search)
            if patch is None:
                remaining.append(members)
            else:
                patches.append(patch)
        left = np.sort(np.concatenate(remaining)) if remaining else left[:0]
        edge_m *= 0.5
    return patches


def _patch(
    points: Array, owner: np.ndarray, backs: list[Array], edge_m: float, gate_m: float, search: PatchSearch
) -> Patch | None:
    counts = np.bincount(owner, minlength=len(backs))
    if np.count_nonzero(counts >= search.points_min) < 2:
        return None
    most = points[owner == int(np.argmax(counts))]
    centred = most - most.mean(axis=0)
    values = np.linalg.eigvalsh(centred.T @ centred / len(most))
    if values[0] > search.deviation_m**2 or values[1] < (_SPREAD_MIN * edge_m) ** 2:
        return None
    normal, offset, _ = fit_plane(most)
    near = np.abs(points @ normal + offset) < gate_m
    kept: list[Array] = []
    for number, back in enumerate(backs):
        mine = np.flatnonzero(near & (owner == number))
        # A lidar's own points must lie on the plane, too: half of its cell may be something else.
        if len(mine) < search.points_min or len(mine) < 0.5 * counts[number]:
            mine = mine[:0]
        step = max(1, -(-len(mine) // search.points_max))
        kept.append(moved(back, points[mine[::step]]))
    return Patch(tuple(kept)) if sum(len(part) > 0 for part in kept) >= 2 else None

"""A new point map beside the one in force, element by element and tile by tile.

  same    both have a surface here
  new     the new map has a surface where the old one had none, though it knew the surroundings
  moved   a surface of the new map stands beside one of the old map that is not there any more
  gone    beams went through a surface of the old map
  unseen  the scans did not see this surface of the old map: nothing is said of it, and it stays
  added   a surface of the new map where the old one knew nothing, or one that goes on

All is counted in elements, of which each voxel has one: shares of them are about shares of surface.
"""

from collections.abc import Sequence

import msgspec
import numpy as np
from scipy.spatial import cKDTree

from contract.geometry import Array, BoolArray, IntArray
from contract.point_map.tiles import Surfels
from vehicle_agent.localization.odometry.voxel_map import Array32
from workshop.cloud_mapping.surfaces import SurfaceParams, seen_through

SAME, NEW, MOVED, GONE, UNSEEN, ADDED = range(6)
# Elements that a surface must have near by to be one that goes on.
_CONTINUED_MIN = 3


class ComparisonParams(msgspec.Struct, frozen=True):
    """What is the same, and what of a tile is called a change.

    reach_m     to an element of the same surface
    across_m    a surface that is farther away, across itself, is another one
    loose_m     the same for elements without a normal, as of leaves
    near_m      farther from all old elements the old map knew nothing
    moved_m     farther a surface has not moved: one is gone, and another one is new
    through_min keyframes whose beams went through an element that is gone
    spread_rounds  of half a metre, by which a gone surface is taken to reach beyond the beams
    changed_min, changed_ratio  elements, and their share, from which on a tile is called changed
    """

    reach_m: float = 0.8
    across_m: float = 0.2
    loose_m: float = 0.7
    near_m: float = 2.0
    moved_m: float = 2.5
    through_min: int = 3
    spread_rounds: int = 5
    changed_min: int = 15
    changed_ratio: float = 0.05


class Changes(msgspec.Struct, frozen=True):
    """new: (n,) SAME, NEW, MOVED or ADDED of each new element; old: (m,) SAME, MOVED, GONE or UNSEEN."""

    new: IntArray
    old: IntArray


class TileChange(msgspec.Struct, frozen=True):
    """One tile: counts of elements, and the shares of those of which something is known.

    is_added  the old map has no such tile
    """

    ix: int
    iy: int
    same: int
    new: int
    moved: int
    gone: int
    unseen: int
    added: int
    changed_ratio: float
    is_changed: bool
    is_added: bool


def changes_of(
    new: Surfels, old: Surfels, clouds: Sequence[Array32], poses: Array, surfaces: SurfaceParams,
    params: ComparisonParams,
) -> Changes:  # fmt: skip
    """new lies on old; clouds and their poses (k, 4, 4): the scans of which new was made."""
    new_is, old_is = np.full(len(new), ADDED), np.full(len(old), UNSEEN)
    if not len(old) or not len(new):
        return Changes(new_is, old_is)
    old_tree, new_tree = cKDTree(old.means), cKDTree(new.means)
    new_is[old_tree.query(new.means)[0] < params.near_m] = NEW
    new_is[_continues(new, old, old_tree, params)] = ADDED
    new_is[_has_same(new, old, old_tree, params)] = SAME
    old_is[_has_same(old, new, new_tree, params)] = SAME
    through = seen_through(old, clouds, poses, surfaces)
    is_gone = (old_is != SAME) & (through >= params.through_min)
    is_gone &= through > surfaces.through_ratio * _seen_since(old, new, new_tree, params)
    old_is[is_gone] = GONE
    _pair_moved(new, old, new_is, old_is, params)
    _spread(old, old_tree, old_is, params)
    return Changes(new_is, old_is)


def _has_same(ones: Surfels, others: Surfels, tree: cKDTree, params: ComparisonParams) -> BoolArray:
    """(n,) the others have a surface where these elements are."""
    near = tree.query_ball_point(ones.means, params.reach_m)
    counts = np.array([len(found) for found in near])
    a = np.repeat(np.arange(len(ones)), counts)
    b = np.concatenate([np.asarray(found, dtype=np.int64) for found in near])
    step = ones.means[a] - others.means[b]
    n_a, n_b = ones.normals[a], others.normals[b]
    flat = (np.abs(n_a).sum(axis=1) > 0.0) & (np.abs(n_b).sum(axis=1) > 0.0)
    across = np.maximum(np.abs(np.einsum("ij,ij->i", n_b, step)), np.abs(np.einsum("ij,ij->i", n_a, step)))
    parallel = np.abs(np.einsum("ij,ij->i", n_a, n_b)) > 0.8
    fits = np.where(
        flat, parallel & (across < params.across_m), np.linalg.norm(step, axis=1) < params.loose_m
    )
    found: BoolArray = np.zeros(len(ones), dtype=bool)
    found[a[fits]] = True
    return found


def _continues(new: Surfels, old: Surfels, tree: cKDTree, params: ComparisonParams) -> BoolArray:
    """(n,) it lies on a surface that the old map knows near by, as ground between the rings of its scans."""
    found: BoolArray = np.zeros(len(new), dtype=bool)
    for one in np.flatnonzero(np.abs(new.normals).sum(axis=1) > 0.0).tolist():
        near = np.array(tree.query_ball_point(new.means[one], params.near_m), dtype=np.int64)
        step, n = new.means[one] - old.means[near], old.normals[near]
        on_it = (np.abs(np.einsum("ij,ij->i", n, step)) < params.across_m) & (
            np.abs(n @ new.normals[one]) > 0.8
        )
        found[one] = int(on_it.sum()) >= _CONTINUED_MIN
    return found


def _seen_since(old: Surfels, new: Surfels, tree: cKDTree, params: ComparisonParams) -> Array:
    """(m,) keyframes that saw something of any kind right there, as a tree whose leaves beams pass."""
    apart_m, at = tree.query(old.means)
    seen: Array = np.where(apart_m < 0.5 * params.reach_m, new.seen[at], 0.0)
    return seen


def _pair_moved(
    new: Surfels, old: Surfels, new_is: IntArray, old_is: IntArray, params: ComparisonParams
) -> None:
    """A new surface beside an old one that is not seen any more, parallel to it: it has moved.

    Before the old place it hides it: no beam proves that it is gone.
    """
    flat_new = np.flatnonzero((new_is == NEW) & (np.abs(new.normals).sum(axis=1) > 0.0))
    flat_old = np.flatnonzero((old_is != SAME) & (np.abs(old.normals).sum(axis=1) > 0.0))
    if not len(flat_new) or not len(flat_old):
        return
    # Ground does not move aside: what is new above or below it is new.
    flat_new = flat_new[np.abs(new.normals[flat_new, 2]) < 0.5]
    flat_old = flat_old[np.abs(old.normals[flat_old, 2]) < 0.5]
    tree = cKDTree(old.means[flat_old]) if len(flat_old) else None
    if tree is None:
        return
    for one in flat_new:
        for other in flat_old[tree.query_ball_point(new.means[one], params.moved_m)]:
            n, step = old.normals[other], new.means[one] - old.means[other]
            across = float(n @ step)
            along = float(np.linalg.norm(step - across * n))
            if abs(float(n @ new.normals[one])) > 0.8 and along < params.reach_m:
                new_is[one] = MOVED
                old_is[other] = MOVED


def _spread(old: Surfels, tree: cKDTree, old_is: IntArray, params: ComparisonParams) -> None:
    """The rest of a surface, most of whose neighbours are gone, is gone with them.

    Beams that go over the wall behind it come back from nowhere, so that none proves it.
    """
    for _ in range(params.spread_rounds):
        waiting = np.flatnonzero(old_is == UNSEEN).tolist()
        found: list[tuple[int, int]] = []
        for one in waiting:
            near = np.array(tree.query_ball_point(old.means[one], params.reach_m))
            n, step = old.normals[one], old.means[near] - old.means[one]
            on_it = (np.abs(step @ n) < params.across_m) & (np.abs(old.normals[near] @ n) > 0.8)
            # An element without a normal, as at a wall's edge, goes with all that are near it.
            on_it |= not n.any()
            kinds = old_is[near[on_it]]
            gone, moved = int((kinds == GONE).sum()), int((kinds == MOVED).sum())
            if gone + moved > max(1, 2 * int((kinds == SAME).sum())):
                found.append((one, GONE if gone >= moved else MOVED))
        for number, kind in found:
            old_is[number] = kind


def tile_changes(
    new: Surfels, old: Surfels, changes: Changes, tile_m: float, params: ComparisonParams
) -> tuple[TileChange, ...]:
    """Of each tile in which there is something new to say, by place."""
    new_at = np.floor(new.means[:, :2] / tile_m).astype(np.int64).reshape(-1, 2)
    old_at = np.floor(old.means[:, :2] / tile_m).astype(np.int64).reshape(-1, 2)
    known = {(int(x), int(y)) for x, y in old_at}
    found = []
    for ix, iy in sorted({(int(x), int(y)) for x, y in new_at} | known):
        here_new = changes.new[(new_at == (ix, iy)).all(axis=1)]
        here_old = changes.old[(old_at == (ix, iy)).all(axis=1)]
        counts = {kind: int((here_new == kind).sum()) for kind in (SAME, NEW, MOVED, ADDED)}
        gone, unseen = int((here_old == GONE).sum()), int((here_old == UNSEEN).sum())
        if not len(here_new) and not gone:
            continue
        changed = counts[NEW] + counts[MOVED] + gone
        ratio = changed / max(1, changed + counts[SAME])
        is_changed = changed >= params.changed_min and ratio >= params.changed_ratio
        found.append(
            TileChange(
                ix, iy, counts[SAME], counts[NEW], counts[MOVED], gone, unseen, counts[ADDED],
                round(ratio, 4), is_changed, (ix, iy) not in known,
            )
        )  # fmt: skip
    return tuple(found)

"""What clusters and another finder found in one scan, as one list of objects."""

import math

import numpy as np

from contract.geometry import Array, BoolArray
from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN, VEHICLE
from vehicle_agent.signals.objects import SeenObjects

# Less sure objects of the other finder are left to the clusters.
SCORE_MIN = 0.35
# A cluster so far outside an object's box is still part of it; less far if it looks like a person or cyclist.
_MARGIN_M, _PERSON_MARGIN_M = 0.3, 0.05


def union(clusters: SeenObjects, finder: SeenObjects, alone: BoolArray | None = None) -> SeenObjects:
    """The finder's objects, and the clusters in none of them: what no network has learned stays seen.

    alone  (k,) which of the finder's objects are where the points show nobody: there it need not be sure of
           what has no kind

    An object of the finder that has no kind gives way to a cluster in it. A vehicle whose returns show its
    box has the cluster's: a network's is off by some tenths of a metre, differently in each scan, and the
    shift of a plain flank between two scans is a guess. Both are of the same scan, in the same base frame.
    """
    sure, has_kind = finder.scores >= SCORE_MIN, finder.kinds != OTHER
    known = sure & has_kind
    finder = _with_fitted(finder, clusters)
    # A person or cyclist close to a car is not a part of it.
    is_person = (clusters.kinds == PEDESTRIAN) | (clusters.kinds == CYCLIST)
    margins = np.where(is_person, _PERSON_MARGIN_M, _MARGIN_M)
    places = clusters.poses_base[:, :2]
    left = ~_inside(places, finder.poses_base[known], finder.sizes_m[known], margins).any(axis=1)
    within = _inside(places, finder.poses_base, finder.sizes_m, margins).any(axis=0)
    trusted = sure if alone is None else sure | alone
    kept = known | (trusted & ~has_kind & ~within)
    return SeenObjects(
        clusters.stamp_ns,
        np.concatenate((finder.kinds[kept], clusters.kinds[left])),
        np.concatenate((finder.scores[kept], clusters.scores[left])),
        np.vstack((finder.poses_base[kept], clusters.poses_base[left])),
        np.vstack((finder.sizes_m[kept], clusters.sizes_m[left])),
        np.vstack((finder.velocities_base_mps[kept], clusters.velocities_base_mps[left])),
        np.concatenate((finder.fitted()[kept], clusters.fitted()[left])),
    )


def _with_fitted(finder: SeenObjects, clusters: SeenObjects) -> SeenObjects:
    """The finder's objects; vehicles have the fitted box of the cluster whose middle is in theirs."""
    candidates = np.flatnonzero(clusters.fitted())
    if not len(candidates):
        return finder
    margins = np.full(len(candidates), _MARGIN_M)
    inside = _inside(clusters.poses_base[candidates, :2], finder.poses_base, finder.sizes_m, margins)
    inside[:, finder.kinds != VEHICLE] = False
    # Where the network has two cars in one place, the surer one has the cluster.
    inside[:, finder.scores < SCORE_MIN] = False
    poses, sizes = finder.poses_base.copy(), finder.sizes_m.copy()
    velocities, fitted = finder.velocities_base_mps.copy(), finder.fitted().copy()
    for row, cluster in zip(inside, candidates.tolist(), strict=True):
        if not row.any():
            continue
        k = int(np.argmax(np.where(row, finder.scores, -math.inf)))
        yaw = clusters.poses_base[cluster, 2]
        # A box does not tell where a car's front is; the network does.
        ahead = math.cos(yaw - poses[k, 2]) >= 0.0
        poses[k, :2] = clusters.poses_base[cluster, :2]
        poses[k, 2] = yaw if ahead else math.remainder(yaw + math.pi, 2.0 * math.pi)
        sizes[k, :2] = clusters.sizes_m[cluster, :2]
        velocities[k], fitted[k] = math.nan, True
    return SeenObjects(finder.stamp_ns, finder.kinds, finder.scores, poses, sizes, velocities, fitted)


def _inside(points: Array, poses: Array, sizes: Array, margins: Array) -> BoolArray:
    """(n, k) which points (n, 2) lie in or margins (n,) beside which boxes: poses (k, 3), sizes (k, 3)."""
    apart = points[:, None, :] - poses[None, :, :2]
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    along = np.abs(cos * apart[..., 0] + sin * apart[..., 1]) <= 0.5 * sizes[:, 0] + margins[:, None]
    across = np.abs(-sin * apart[..., 0] + cos * apart[..., 1]) <= 0.5 * sizes[:, 1] + margins[:, None]
    inside: BoolArray = along & across
    return inside

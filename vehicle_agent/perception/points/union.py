"""What clusters and another finder found in one scan, as one list of objects."""

import numpy as np

from contract.geometry import Array, BoolArray
from vehicle_agent.signals import OTHER
from vehicle_agent.signals.objects import SeenObjects

# Less sure objects of the other finder are left to the clusters.
SCORE_MIN = 0.35
# A cluster so far outside an object's box is still part of it.
_MARGIN_M = 0.3


def union(clusters: SeenObjects, finder: SeenObjects) -> SeenObjects:
    """The finder's objects, and the clusters in none of them: what no network has learned stays seen.

    An object of the finder that has no kind gives way to a cluster in it. Both are of the same scan, in the
    same base frame.
    """
    sure, has_kind = finder.scores >= SCORE_MIN, finder.kinds != OTHER
    known = sure & has_kind
    left = ~_inside(clusters.poses_base[:, :2], finder.poses_base[known], finder.sizes_m[known]).any(axis=1)
    within = _inside(clusters.poses_base[:, :2], finder.poses_base, finder.sizes_m).any(axis=0)
    kept = known | (sure & ~has_kind & ~within)
    return SeenObjects(
        clusters.stamp_ns,
        np.concatenate((finder.kinds[kept], clusters.kinds[left])),
        np.concatenate((finder.scores[kept], clusters.scores[left])),
        np.vstack((finder.poses_base[kept], clusters.poses_base[left])),
        np.vstack((finder.sizes_m[kept], clusters.sizes_m[left])),
        np.vstack((finder.velocities_base_mps[kept], clusters.velocities_base_mps[left])),
    )


def _inside(points: Array, poses: Array, sizes: Array) -> BoolArray:
    """(n, k) which points (n, 2) lie in which boxes: poses (k, 3), sizes (k, 3)."""
    apart = points[:, None, :] - poses[None, :, :2]
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    along = np.abs(cos * apart[..., 0] + sin * apart[..., 1]) <= 0.5 * sizes[:, 0] + _MARGIN_M
    across = np.abs(-sin * apart[..., 0] + cos * apart[..., 1]) <= 0.5 * sizes[:, 1] + _MARGIN_M
    inside: BoolArray = along & across
    return inside

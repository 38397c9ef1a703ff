"""What clusters and a network found in one scan, as one list of objects."""

import numpy as np

from contract.geometry import Array, BoolArray
from vehicle_agent.signals.objects import SeenObjects

# Less sure objects of the network are left to the clusters.
SCORE_MIN = 0.35
# A cluster so far outside an object's box is still part of it.
_MARGIN_M = 0.3


def union(clusters: SeenObjects, network: SeenObjects) -> SeenObjects:
    """The network's objects, and the clusters in none of them: what no network has learned stays seen.

    Both are of the same scan, in the same base frame.
    """
    sure = network.scores >= SCORE_MIN
    left = ~_inside(clusters.poses_base[:, :2], network.poses_base[sure], network.sizes_m[sure])
    return SeenObjects(
        clusters.stamp_ns,
        np.concatenate((network.kinds[sure], clusters.kinds[left])),
        np.concatenate((network.scores[sure], clusters.scores[left])),
        np.vstack((network.poses_base[sure], clusters.poses_base[left])),
        np.vstack((network.sizes_m[sure], clusters.sizes_m[left])),
        np.vstack((network.velocities_base_mps[sure], clusters.velocities_base_mps[left])),
    )


def _inside(points: Array, poses: Array, sizes: Array) -> BoolArray:
    """(n,) which points (n, 2) lie in any box: poses (k, 3), sizes (k, 3)."""
    apart = points[:, None, :] - poses[None, :, :2]
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    along = np.abs(cos * apart[..., 0] + sin * apart[..., 1]) <= 0.5 * sizes[:, 0] + _MARGIN_M
    across = np.abs(-sin * apart[..., 0] + cos * apart[..., 1]) <= 0.5 * sizes[:, 1] + _MARGIN_M
    inside: BoolArray = np.any(along & across, axis=1)
    return inside

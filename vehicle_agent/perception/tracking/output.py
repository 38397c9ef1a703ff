"""The tracks that are shown, as the vehicle's rooms take them."""

import math

import numpy as np

from contract.geometry import Array, BoolArray, Pose2, inverse, transform_points
from vehicle_agent.perception.tracking.motion import PX, VX, combined
from vehicle_agent.perception.tracking.params import TrackerParams
from vehicle_agent.perception.tracking.tracks import TrackTable
from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN, TrackPercept

# A thing of no kind is shown while it moves at least so fast, m/s.
_MOVING_MPS = 0.4
# Least length and width of a rider's cycle, also where the rider alone is seen, m.
_CYCLE_M = (1.6, 0.5)


def percept_of_tracks(
    tracks: TrackTable, stamp_ns: int, pose_map: Pose2, params: TrackerParams
) -> TrackPercept:
    """The confirmed tracks in the base frame; things of no kind only when they move."""
    mean, covariance = combined(tracks.means, tracks.covariances, tracks.weights)
    kinds = np.argmax(tracks.evidence, axis=1).astype(np.int64)
    velocities = significant(mean[:, VX : VX + 2], covariance[:, VX : VX + 2, VX : VX + 2], params.still)
    shown = _shown(tracks, kinds, mean, velocities, params)
    mean, velocities, kinds = mean[shown], velocities[shown], kinds[shown]
    sizes = tracks.sizes_m[shown, :2].copy()
    people = kinds == PEDESTRIAN
    cyclists = kinds == CYCLIST
    sizes[cyclists] = np.maximum(sizes[cyclists], _CYCLE_M)
    sizes[people] = sizes[people].mean(axis=1)[:, None]
    yaws = tracks.yaws[shown].copy()
    walking = people & (np.hypot(velocities[:, 0], velocities[:, 1]) > 0.3)
    yaws[walking] = np.arctan2(velocities[walking, 1], velocities[walking, 0])
    turned = Pose2(0.0, 0.0, -pose_map.yaw_rad)
    poses: Array = np.column_stack(
        (
            transform_points(inverse(pose_map), mean[:, PX:VX]),
            [math.remainder(yaw - pose_map.yaw_rad, 2.0 * math.pi) for yaw in yaws],
        )
    ).reshape(-1, 3)
    return TrackPercept(
        stamp_ns, tracks.ids[shown].copy(), kinds, poses, transform_points(turned, velocities), sizes
    )


def significant(velocities: Array, covariances: Array, still: float) -> Array:
    """(n, 2) velocities (n, 2), shrunk where they are within their own covariance (n, 2, 2).

    A Wiener gain: the squared deviation d2 gives the share d2 / (d2 + still). The jitter of what stands
    almost vanishes, while the velocity of what moves stays.
    """
    if not len(velocities):
        return velocities.copy()
    inverse_covariances = np.linalg.inv(covariances + 1e-6 * np.eye(2))
    squared = np.einsum("ni,nij,nj->n", velocities, inverse_covariances, velocities)
    shrunk: Array = velocities * (squared / (squared + still))[:, None]
    return shrunk


def _shown(
    tracks: TrackTable, kinds: np.ndarray, mean: Array, velocities: Array, params: TrackerParams
) -> BoolArray:
    scans = np.minimum(params.shown_scans, 1 + params.shown_share * tracks.hits)
    shown: BoolArray = tracks.is_confirmed & ((tracks.misses <= scans) | tracks.is_below)
    moved = np.hypot(mean[:, 0] - tracks.begins_map[:, 0], mean[:, 1] - tracks.begins_map[:, 1])
    moves = (
        (moved >= params.moved_m)
        & (np.hypot(velocities[:, 0], velocities[:, 1]) >= _MOVING_MPS)
        & (tracks.sizes_m[:, 0] <= params.other_m_max)
    )
    shown &= (kinds != OTHER) | moves
    return shown

"""Scan-matched dead reckoning: the laser's way since the start, by its scans and the wheels' odometry.

Each scan is matched to the lines of the last few keyframes, beginning where odometry says. Odometry is the
prior, so that a corridor's length comes from the wheels. Where the match is poor, a window around the prior
is searched. Where nothing matches, odometry alone moves the pose.
"""

import math

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.localization.laser.correlation import (
    Raster,
    SearchWindow,
    correlate,
    rasterized,
)
from vehicle_agent.localization.laser.point_index import PointIndex, index_points
from vehicle_agent.localization.laser.point_to_line import Match, MatchParams, match_to_lines
from vehicle_agent.localization.laser.pose_arrays import between, composed, moved
from vehicle_agent.localization.laser.surfaces import Surface, SurfaceParams, scan_surface


class DeadReckoningParams(msgspec.Struct, frozen=True):
    """Scan-matched dead reckoning.

    keyframe_m, keyframe_rad  a scan becomes a keyframe this far from the last one
    keyframes_max             how many keyframes a scan is matched to
    standing_m, standing_rad  odometry that moved less than this leaves the pose as it is
    odometry_m, odometry_rad  standard deviation of a step of odometry, at least
    odometry_ratio            and this share of its length and of its turn
    slip_rad_per_m            and this much turn for each metre
    inlier_ratio_min          a match with fewer inliers is poor
    search_m, search_rad      half the window that is searched after a poor match, plus the step's own length
    search_penalty            score taken from a pose at the window's border: along a corridor, poses behind
                              the true one see more known walls
    search_gain_min           share of inliers by which what was found must be better than the poor match
    raster_m                  cell of the search, and the standard deviation of its nearness
    raster_reach_m            reference points farther from the laser than this are not searched
    reset_m                   a longer step of odometry is a reset of its counters, and not believed
    """

    surface: SurfaceParams = SurfaceParams()
    match: MatchParams = MatchParams()
    keyframe_m: float = 0.3
    keyframe_rad: float = 0.26
    keyframes_max: int = 15
    standing_m: float = 0.002
    standing_rad: float = 0.002
    odometry_m: float = 0.05
    odometry_rad: float = 0.009
    odometry_ratio: float = 0.2
    slip_rad_per_m: float = 0.09
    inlier_ratio_min: float = 0.6
    search_m: float = 0.4
    search_rad: float = 0.44
    search_penalty: float = 0.3
    search_gain_min: float = 0.1
    raster_m: float = 0.1
    raster_reach_m: float = 20.0
    reset_m: float = 5.0


class Keyframe(msgspec.Struct, frozen=True):
    """pose (3,) of the laser in the frame of dead reckoning, and what it saw there."""

    pose: Array
    surface: Surface


class DeadReckoningState(msgspec.Struct, frozen=True):
    """pose (3,) after the last scan; odometry (3,) the wheels' pose of the laser then; reference, raster: the
    keyframes' points, as they are searched."""

    pose: Array
    odometry: Array
    keyframes: tuple[Keyframe, ...]
    reference: PointIndex
    raster: Raster


class DeadReckoning(msgspec.Struct, frozen=True):
    """The laser after one scan.

    pose         (3,) in the frame of dead reckoning: where the laser was at the first scan
    information  (3, 3) inverse covariance of the step since the last scan, in the frame's axes
    match        how the scan matched; None for a scan that was not matched
    is_keyframe  whether the scan is one of those to which the next ones are matched
    """

    pose: Array
    information: Array
    match: Match | None
    is_keyframe: bool
    surface: Surface


def step(
    state: DeadReckoningState | None,
    ranges_m: Array,
    angles_rad: Array,
    odometry: Array,
    params: DeadReckoningParams,
) -> tuple[DeadReckoning, DeadReckoningState]:
    """The laser's pose at this scan.

    state     of the last scan; None before the first
    odometry  (3,) pose of the laser by the wheels, in any frame that stays
    """
    surface = scan_surface(ranges_m, angles_rad, params.surface)
    if state is None:
        pose = np.zeros(3)
        return (
            DeadReckoning(pose, np.zeros((3, 3)), None, True, surface),
            _with_keyframe((), pose, odometry, surface, params),
        )
    way = between(state.odometry, odometry)
    if math.hypot(way[0], way[1]) > params.reset_m:
        way = np.zeros(3)
        state = msgspec.structs.replace(state, odometry=odometry)
    prior_information = _odometry_information(way, params)
    if math.hypot(way[0], way[1]) < params.standing_m and abs(way[2]) < params.standing_rad:
        # The odometry of the last scan stays, so that slow motion adds up.
        return DeadReckoning(state.pose, prior_information, None, False, surface), state
    predicted = composed(state.pose, way)
    match = _matched(state, surface, predicted, way, prior_information, params)
    pose = match.pose if match.inlier_ratio > 0.0 else predicted
    output = DeadReckoning(pose, match.information + prior_information, match, False, surface)
    apart = between(state.keyframes[-1].pose, pose)
    if math.hypot(apart[0], apart[1]) < params.keyframe_m and abs(apart[2]) < params.keyframe_rad:
        return output, msgspec.structs.replace(state, pose=pose, odometry=odometry)
    kept = state.keyframes[-params.keyframes_max + 1 :]
    return (
        msgspec.structs.replace(output, is_keyframe=True),
        _with_keyframe(kept, pose, odometry, surface, params),
    )


def _matched(
    state: DeadReckoningState,
    surface: Surface,
    predicted: Array,
    way: Array,
    prior_information: Array,
    params: DeadReckoningParams,
) -> Match:
    match = match_to_lines(surface, state.reference, predicted, prior_information, params.match)
    if match.inlier_ratio >= params.inlier_ratio_min:
        return match
    window = SearchWindow(
        params.search_m + math.hypot(way[0], way[1]), min(params.search_rad + abs(way[2]), math.pi)
    )
    penalty = np.array([params.search_penalty, params.search_penalty])
    found = correlate(surface.points_laser, state.raster, predicted, window, penalty)
    # The prior's mean was wrong: only its shape is kept, around what was found.
    searched = match_to_lines(surface, state.reference, found.pose, prior_information, params.match)
    if searched.inlier_ratio > match.inlier_ratio + params.search_gain_min:
        return searched
    return match


def _odometry_information(way: Array, params: DeadReckoningParams) -> Array:
    """(3, 3) diagonal."""
    length_m = math.hypot(way[0], way[1])
    std_m = params.odometry_m + params.odometry_ratio * length_m
    std_rad = params.odometry_rad + params.odometry_ratio * abs(way[2]) + params.slip_rad_per_m * length_m
    return np.diag([std_m**-2, std_m**-2, std_rad**-2])


def _with_keyframe(
    keyframes: tuple[Keyframe, ...],
    pose: Array,
    odometry: Array,
    surface: Surface,
    params: DeadReckoningParams,
) -> DeadReckoningState:
    keyframes = (*keyframes, Keyframe(pose, surface))
    points, normals = joined(keyframes)
    reference = index_points(points, normals, params.match.distance_m_first)
    near = points[np.hypot(points[:, 0] - pose[0], points[:, 1] - pose[1]) < params.raster_reach_m]
    raster = rasterized(near, params.raster_m, params.raster_m, params.search_m + 1.0)
    return DeadReckoningState(pose, odometry, keyframes, reference, raster)


def joined(keyframes: tuple[Keyframe, ...]) -> tuple[Array, Array]:
    """Points and normals (n, 2) of the keyframes, in the frame of their poses."""
    total = sum(len(keyframe.surface) for keyframe in keyframes)
    points, normals = np.empty((total, 2)), np.empty((total, 2))
    first = 0
    for keyframe in keyframes:
        last = first + len(keyframe.surface)
        moved(
            keyframe.surface.points_laser,
            keyframe.surface.normals_laser,
            keyframe.pose,
            points[first:last],
            normals[first:last],
        )
        first = last
    return points, normals

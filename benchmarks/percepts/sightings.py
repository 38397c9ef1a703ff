"""What a vehicle's percepts say of each road user around it, scan after scan. Pure."""

from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, IntArray, Pose2, inverse, transform_points
from simulator.traffic.actors import Bodies
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.signals import ObstaclePercept, TrackPercept

# Of the outline, in which returns, cells and a track's middle count as the road user's.
_RETURNS_MARGIN_M, _CELLS_MARGIN_M, _TRACK_MARGIN_M = 0.1, 0.3, 0.7
# Returns between kerb and head.
_FROM_Z_M, _TO_Z_M = 0.25, 2.2
# A road user of whom so many returns come could be known.
RETURNS_MIN = 5
# It is new in view when it had fewer for so many scans; it counts as never tracked after so many with more.
NEW_AFTER_SCANS, NEVER_AFTER_SCANS = 10, 10
_BAND_M = 2.0
# What reaches over the edge of the grid is cut there.
_EDGE_M = 1.0
# The outlines of two whose middles are farther apart do not meet.
_NEAR_M = 6.0


@dataclass(frozen=True, slots=True)
class Sighting:
    """One road user in one scan.

    kind      index into TRACK_KINDS
    range_m   from the rear axle
    returns   on it
    tracked   there is a track on it; named: of its kind
    in_cells  there is an obstacle cell on it
    velocity_off_mps  of the nearest track on it that has its kind, None without one
    """

    scan: int
    number: int
    kind: int
    range_m: float
    returns: int
    tracked: bool
    named: bool
    in_cells: bool
    velocity_off_mps: float | None = None


def sightings(
    scan: int,
    points_base: Array,
    bodies: Bodies,
    pose_map: Pose2,
    cells: ObstaclePercept,
    tracks: TrackPercept,
    grid: PointGrid,
) -> list[Sighting]:
    """Of all whose middle is within the grid's reach, seen or not. points_base (n, 3).

    The simulated ways know nothing of each other: those who stand in one another are left out.
    """
    found = []
    to_base = inverse(pose_map)
    places = transform_points(to_base, bodies.poses_map[:, :2])
    velocities = transform_points(Pose2(0.0, 0.0, to_base.yaw_rad), bodies.velocities_map_mps)
    ahead, aside = places.T
    in_reach = (
        (ahead < grid.reach_front_m - _EDGE_M)
        & (ahead > _EDGE_M - grid.reach_back_m)
        & (np.abs(aside) < grid.reach_side_m - _EDGE_M)
    )
    for k in np.flatnonzero(in_reach & ~_in_another(bodies)):
        x_m, y_m = places[k]
        yaw_rad = float(bodies.poses_map[k, 2]) - pose_map.yaw_rad
        half = 0.5 * bodies.sizes_m[k]
        # First a box along the axes, of all points.
        radius = float(np.hypot(*half)) + _TRACK_MARGIN_M
        near = (
            (np.abs(points_base[:, 0] - x_m) < radius)
            & (np.abs(points_base[:, 1] - y_m) < radius)
            & (points_base[:, 2] > _FROM_Z_M)
            & (points_base[:, 2] < _TO_Z_M)
        )
        outline = Pose2(float(x_m), float(y_m), yaw_rad), half
        returns = int(np.count_nonzero(_within(points_base[near, :2], *outline, _RETURNS_MARGIN_M)))
        on_it = _within(tracks.poses_base[:, :2], *outline, _TRACK_MARGIN_M)
        kind = int(bodies.kinds[k])
        named = np.flatnonzero(on_it & (tracks.kinds == kind))
        found.append(
            Sighting(
                scan,
                int(bodies.numbers[k]),
                kind,
                float(np.hypot(x_m, y_m)),
                returns,
                bool(on_it.any()),
                len(named) > 0,
                bool(_within(cells.cells_base, *outline, _CELLS_MARGIN_M).any()),
                _velocity_off_mps(tracks, named, places[k], velocities[k]) if len(named) else None,
            )
        )
    return found


def _velocity_off_mps(tracks: TrackPercept, rows: IntArray, place: Array, velocity_mps: Array) -> float:
    nearest = rows[np.argmin(np.hypot(*(tracks.poses_base[rows, :2] - place).T))]
    return float(np.hypot(*(tracks.velocities_base_mps[nearest] - velocity_mps)))


def _in_another(bodies: Bodies) -> Array:
    """(n,) bool: which outlines meet another one, as no two bodies can."""
    corners = np.array([(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0), (0.0, 0.0)])
    poses = [Pose2(*map(float, pose)) for pose in bodies.poses_map]
    outlines = [
        transform_points(pose, 0.5 * corners * size) for pose, size in zip(poses, bodies.sizes_m, strict=True)
    ]
    meets = np.zeros(len(poses), np.bool_)
    for k, (pose, size) in enumerate(zip(poses, bodies.sizes_m, strict=True)):
        for j in np.flatnonzero(np.hypot(*(bodies.poses_map[:, :2] - bodies.poses_map[k, :2]).T) < _NEAR_M):
            if j != k and _within(outlines[j], pose, 0.5 * size, 0.0).any():
                meets[[j, k]] = True
    return meets


def _within(points: Array, pose: Pose2, half_m: Array, margin_m: float) -> Array:
    """(n,) bool: of (n, 2) points, those in a box of these half sizes."""
    own = transform_points(inverse(pose), points)
    return (np.abs(own[:, 0]) < half_m[0] + margin_m) & (np.abs(own[:, 1]) < half_m[1] + margin_m)


def seen_shares(found: list[Sighting]) -> Array:
    """(n,): the returns of each, as a share of what a road user of its kind in full view has at its range.

    That is the 90th percentile of all of this kind in the same 2 m of range.
    """
    kinds = np.array([one.kind for one in found])
    bands = np.array([one.range_m for one in found]) // _BAND_M
    returns = np.array([one.returns for one in found], np.float64)
    shares = np.zeros(len(found))
    for kind in np.unique(kinds):
        for band in np.unique(bands[kinds == kind]):
            of_band = (kinds == kind) & (bands == band)
            full = max(float(np.percentile(returns[of_band], 90)), 1.0)
            shares[of_band] = np.minimum(returns[of_band] / full, 1.0)
    return shares


@dataclass(frozen=True, slots=True)
class Appearance:
    """A road user comes into view: scans until a track and until a cell; None: never while it was in view."""

    kind: int
    range_m: float
    track_after: int | None
    cell_after: int | None


def appearances(found: list[Sighting]) -> list[Appearance]:
    """In the order of the road users' numbers. Those who go again before NEVER_AFTER_SCANS count if found."""
    told: list[Appearance] = []
    first_scan = min((one.scan for one in found), default=0)
    for number in sorted({one.number for one in found}):
        own = {one.scan: one for one in found if one.number == number}
        # Out of reach until then.
        hidden, begun = min(own) - first_scan, None
        for scan in range(min(own), max(own) + 2):
            one = own.get(scan)
            if one is not None and one.returns >= RETURNS_MIN:
                if begun is None and hidden >= NEW_AFTER_SCANS:
                    begun = scan
                hidden = 0
                continue
            hidden += 1
            if begun is not None:
                told += _appearance([own[k] for k in range(begun, scan)])
                begun = None
    return told


def _appearance(view: list[Sighting]) -> list[Appearance]:
    first = view[0]
    track = next((one.scan - first.scan for one in view if one.tracked), None)
    cell = next((one.scan - first.scan for one in view if one.in_cells), None)
    if len(view) < NEVER_AFTER_SCANS and (track is None or cell is None):
        return []
    return [Appearance(first.kind, first.range_m, track, cell)]

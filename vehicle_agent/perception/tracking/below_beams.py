"""People close to the body, over whose heads all beams pass.

Lidars on the roof and its corners do not see what is low and near. Who walks up to the bumper, or along the
flank, is seen by less and less of their head, and then not at all. They have not gone: whoever leaves is seen
as they leave.
"""

from typing import NamedTuple

import numpy as np

from contract.geometry import Array, BoolArray, IntArray, Pose2, inverse, transform_points
from vehicle_agent.perception.tracking.motion import PX, TURN, VX, Z_VAR, ZVX, ZX
from vehicle_agent.perception.tracking.params import EVIDENCE_MAX, TrackerParams
from vehicle_agent.perception.tracking.tracks import TrackTable, no_tracks
from vehicle_agent.signals import PEDESTRIAN
from vehicle_agent.signals.objects import SeenObjects

# Standard deviations of the place and velocity of who is not seen, m and m/s.
_PLACE_STD_M, _VELOCITY_STD_MPS = 0.4, 0.6
# They may have taken a step either way, and no more: else they would be seen.
_SOMEWHERE_THERE = np.diag([_PLACE_STD_M**2] * 2 + [_VELOCITY_STD_MPS**2] * 2 + [0.0])
# Who walked along the flank and does not come out at the corner has turned in, so far before the bumper, m.
_CORNER_M = 0.2
# Whoever was slower than this when last seen stands: the rest is the track's error, m/s.
_WALKS_MPS = 0.3
# Who leaves is seen so far outside the area, and beside the body so far behind its beginning, m.
_BOUNDS_M, _BEHIND_M = 1.0, 3.0


class NearArea(NamedTuple):
    """Where all of a person may be below the beams, base frame: before the bumper and beside the body.

    begin_m, end_m, side_m  x from, x to, and how far to either side
    bumper_m, half_width_m  behind the one and within the other is the body, where nobody can stand
    """

    begin_m: float
    bumper_m: float
    end_m: float
    half_width_m: float
    side_m: float

    def contains(self, places_base: Array, margin_m: float = 0.0) -> BoolArray:
        """(n,) which places (n, 2) lie in it, or no farther than margin_m from its outer bounds."""
        x, aside = places_base[:, 0], np.abs(places_base[:, 1])
        within: BoolArray = (x > self.begin_m - margin_m) & (x < self.end_m + margin_m)
        within &= (aside < self.side_m + margin_m) & ~((x < self.bumper_m) & (aside < self.half_width_m))
        return within

    def walking_on(self, places_base: Array, velocities_base: Array, drift: float) -> Array:
        """(n, m, 2) velocities (n, m, 2) a scan later, of people at places (n, 2) whom no beam meets.

        Beside the body whoever walks goes on along it. If they went straight on beyond the bumper, they would
        be seen at the corner: they have turned in. Anybody else stays, but for drift.
        """
        x, y = places_base[:, 0, None], places_base[:, 1, None]
        along, across = velocities_base[..., 0], velocities_base[..., 1]
        is_aside = np.abs(y) >= self.half_width_m
        is_beside = is_aside & (x < self.bumper_m + _CORNER_M)
        walks_on = is_beside & (np.abs(along) >= _WALKS_MPS)
        turns_in = is_aside & ~is_beside & (along > np.abs(across))
        after: Array = np.empty_like(velocities_base)
        after[..., 0] = np.where(walks_on, along, np.where(turns_in, 0.0, drift * along))
        after[..., 1] = np.where(is_beside, 0.0, np.where(turns_in, -np.sign(y) * along, drift * across))
        return after

    def is_left_at(self, places_base: Array) -> BoolArray:
        """(n,) places (n, 2) where who leaves comes into view: at its bounds, and beside the body."""
        x, aside = places_base[:, 0], np.abs(places_base[:, 1])
        at: BoolArray = (x > self.begin_m - _BEHIND_M) & (x < self.end_m + _BOUNDS_M)
        at &= aside < self.side_m + _BOUNDS_M
        return at


NO_AREA = NearArea(0.0, 0.0, 0.0, 0.0, 0.0)


def mark_below(
    tracks: TrackTable,
    kinds: IntArray,
    is_hit: BoolArray,
    pose_map: Pose2,
    area: NearArea,
    params: TrackerParams,
) -> None:
    """Sets `is_below` after a scan, and lets those who are walk on beside the body or come to rest, in place.

    kinds, is_hit (n,) of the tracks. Only the top was seen of them last, in the area or on their way into it.
    """
    tracks.is_below[:] = ~is_hit & may_be_below(tracks, kinds, pose_map, area, params)
    rows = np.flatnonzero(tracks.is_below)
    places = transform_points(inverse(pose_map), tracks.means[rows, 0, PX:VX])
    velocities = tracks.means[rows, :, VX:TURN]
    seen_from_base = transform_points(Pose2(0.0, 0.0, -pose_map.yaw_rad), velocities.reshape(-1, 2))
    after = area.walking_on(places, seen_from_base.reshape(velocities.shape), params.below_drift)
    turned_back = transform_points(Pose2(0.0, 0.0, pose_map.yaw_rad), after.reshape(-1, 2))
    tracks.means[rows, :, VX:TURN] = turned_back.reshape(velocities.shape)
    tracks.means[rows, :, TURN] = 0.0
    tracks.covariances[rows] = _SOMEWHERE_THERE


def may_be_below(
    tracks: TrackTable, kinds: IntArray, pose_map: Pose2, area: NearArea, params: TrackerParams
) -> BoolArray:
    """(n,) who is below the beams, or may be in the next scan: so far the top of them is seen."""
    places = transform_points(inverse(pose_map), tracks.means[:, 0, PX:VX])
    may_be: BoolArray = (
        tracks.is_confirmed
        & (kinds == PEDESTRIAN)
        & area.contains(places)
        & (tracks.visible_m <= params.top_only_m)
    )
    return may_be


def at_rest(tracks: TrackTable) -> TrackTable:
    """The same people where they were last, after a time in which nobody looked."""
    tracks = tracks.copied()
    tracks.means[:, :, VX:] = 0.0
    tracks.covariances[:] = _SOMEWHERE_THERE
    return tracks


def remembered(people_map: Array, first_id: int, params: TrackerParams) -> TrackTable:
    """Tracks of people (n, 3) x, y and diameter, of whom an earlier tracker knew that they may be below."""
    tracks = no_tracks(len(people_map))
    tracks.ids[:] = first_id + np.arange(len(people_map))
    tracks.means[:, :, PX:VX] = people_map[:, None, :2]
    tracks.covariances[:] = _SOMEWHERE_THERE
    tracks.weights[:] = 0.5
    tracks.evidence[:] = -EVIDENCE_MAX
    tracks.evidence[:, PEDESTRIAN] = 0.0
    tracks.sizes_m[:, :2], tracks.sizes_m[:, 2] = people_map[:, 2:], params.top_only_m
    tracks.ages[:] = tracks.hits[:] = params.confirm_hits
    tracks.is_confirmed[:] = True
    tracks.begins_map[:] = people_map[:, :2]
    tracks.visible_m[:] = 0.0
    return tracks


def found_again(
    tracks: TrackTable,
    measured: Array,
    seen: SeenObjects,
    new: IntArray,
    area: NearArea,
    dt_s: float,
    params: TrackerParams,
) -> tuple[IntArray, IntArray]:
    """((k,) rows, (k,) objects) of who was below the beams and appears as one of the objects `new`.

    measured (m, 6) as `motion` has it, of the objects `seen`; dt_s between scans. The nearest pairs first.
    """
    rows = np.flatnonzero(tracks.is_below)
    people = new[(seen.kinds[new] == PEDESTRIAN) & area.is_left_at(seen.poses_base[new, :2])]
    apart: Array = np.linalg.norm(tracks.means[rows, None, 0, PX:VX] - measured[None, people, ZX:ZVX], axis=2)
    apart -= params.below_mps * dt_s * tracks.misses[rows, None]
    pairs: list[tuple[int, int]] = []
    while apart.size and apart.min() <= params.below_reach_m:
        row, column = np.unravel_index(int(np.argmin(apart)), apart.shape)
        pairs.append((int(rows[row]), int(people[column])))
        apart[row, :] = apart[:, column] = np.inf
    pairs.sort()
    return np.array([t for t, _ in pairs], np.int64), np.array([d for _, d in pairs], np.int64)


def restart(tracks: TrackTable, rows: IntArray, measured: Array) -> None:
    """Puts tracks to where they were found again, (k, 6) as `motion` has it, in place."""
    velocities = np.where(np.isfinite(measured[:, ZVX : ZVX + 2]), measured[:, ZVX : ZVX + 2], 0.0)
    tracks.means[rows, :, PX:VX] = measured[:, None, ZX:ZVX]
    tracks.means[rows, :, VX:TURN] = velocities[:, None, :]
    for row, variance in zip(rows.tolist(), measured[:, Z_VAR].tolist(), strict=True):
        tracks.covariances[row] = np.diag([variance] * 2 + [1.0] * 2 + [0.0])
    tracks.is_below[rows] = False
    tracks.misses[rows] = tracks.hidden[rows] = 0
    tracks.hits[rows] += 1

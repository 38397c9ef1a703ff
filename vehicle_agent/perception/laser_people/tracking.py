"""Tracks of small things by their place and velocity (NUS paper, section III-A)."""

import math

import msgspec
import numpy as np
from scipy.optimize import linear_sum_assignment

from contract.geometry import Array, BoolArray, Pose2
from vehicle_agent.perception.laser_people.segments import Clusters

_NO_FIT = 1e6
_MISFIT_GAIN = 0.1


class LaserTracks(msgspec.Struct, frozen=True):
    """Things that a laser follows, map frame. Rows belong together.

    ids (n,) int64             constant as long as a thing is followed
    places_map (n, 2), velocities_map_mps (n, 2)  by a constant velocity
    spreads (n, 3)             variances of place and velocity and their covariance, alike along both axes
    widths_m (n,)              smoothed
    seen_ns (n,) int64         last scan that showed it; hits (n,) int64 scans that did
    free_hits (n,) int64       scans that showed it free (`Clusters.is_free`)
    born_map (n, 2), born_ns (n,) int64  where and when it was first seen free
    misfit (n,)                smoothed squared deviation from the predicted place, in variances; 2 is honest
    evidence (n,)              sum of what pictures said of it, log likelihood ratio of a person
    looks (n,) int64           pictures that showed it
    is_person (n,) bool        it has once been verified
    has_moved (n,) bool        it has once been seen to go somewhere
    """

    stamp_ns: int
    ids: np.ndarray
    places_map: Array
    velocities_map_mps: Array
    spreads: Array
    widths_m: Array
    seen_ns: np.ndarray
    hits: np.ndarray
    free_hits: np.ndarray
    born_map: Array
    born_ns: np.ndarray
    misfit: Array
    evidence: Array
    looks: np.ndarray
    is_person: BoolArray
    has_moved: BoolArray
    next_id: int = 1

    def __len__(self) -> int:
        return len(self.ids)

    def selected(self, chosen: np.ndarray) -> "LaserTracks":
        """The rows that `chosen` names."""
        return LaserTracks(
            self.stamp_ns, self.ids[chosen], self.places_map[chosen], self.velocities_map_mps[chosen],
            self.spreads[chosen], self.widths_m[chosen], self.seen_ns[chosen], self.hits[chosen],
            self.free_hits[chosen], self.born_map[chosen], self.born_ns[chosen], self.misfit[chosen],
            self.evidence[chosen], self.looks[chosen], self.is_person[chosen], self.has_moved[chosen],
            self.next_id,
        )  # fmt: skip


def no_laser_tracks() -> LaserTracks:
    """Nothing is followed yet."""
    none, pairs, whole = np.empty(0), np.empty((0, 2)), np.empty(0, np.int64)
    return LaserTracks(
        0,
        whole,
        pairs,
        pairs,
        np.empty((0, 3)),
        none,
        whole,
        whole,
        whole,
        pairs,
        whole,
        none,
        none,
        whole,
        np.empty(0, np.bool_),
        np.empty(0, np.bool_),
    )


class LaserTracker(msgspec.Struct, frozen=True):
    """Which clusters are followed, and how.

    width_m_max     wider ones are no people, nor a few who walk close together
    place_std_m     of a cluster's middle; range_std_ratio: added for each metre of range, for beams lie apart
    accel_mps2      white noise of a person's acceleration
    start_mps       standard deviation of a new thing's velocity
    gate            a cluster fits within so many standard deviations of place
    gate_m          and within this distance
    coast_ns        a thing is kept for so long without a cluster; a new one for new_coast_ns
    hits_min        scans until it counts as followed
    tracks_max      a scan of a thicket has more; the nearest are followed
    """

    width_m_max: float = 1.4
    place_std_m: float = 0.08
    range_std_ratio: float = 0.004
    accel_mps2: float = 2.0
    start_mps: float = 1.5
    gate: float = 3.5
    gate_m: float = 1.0
    coast_ns: int = 1_000_000_000
    new_coast_ns: int = 250_000_000
    hits_min: int = 3
    tracks_max: int = 150

    def step(
        self, tracks: LaserTracks, clusters: Clusters, T_base_laser: Array, pose_map: Pose2, stamp_ns: int
    ) -> LaserTracks:
        """The tracks after a scan; pose_map: of the vehicle at stamp_ns, the scan's end.

        A scan that is not newer than the tracks changes nothing.
        """
        if tracks.stamp_ns and stamp_ns <= tracks.stamp_ns:
            return tracks
        places, widths, ranges, free = self._candidates(clusters, T_base_laser, pose_map)
        moved = predicted(tracks, stamp_ns, self.accel_mps2)
        variances = (self.place_std_m + self.range_std_ratio * ranges) ** 2
        rows, columns = self._matches(moved, places, variances)
        moved = _corrected(moved, rows, places[columns], widths[columns], variances[columns], free[columns])
        age_ns = stamp_ns - moved.seen_ns
        is_kept = age_ns <= np.where(moved.hits >= self.hits_min, self.coast_ns, self.new_coast_ns)
        is_new: BoolArray = np.ones(len(places), np.bool_)
        is_new[columns] = False
        return self._with_new(
            moved.selected(is_kept), places[is_new], widths[is_new], variances[is_new], free[is_new]
        )

    def is_followed(self, tracks: LaserTracks) -> BoolArray:
        """(n,) which of them several scans have shown."""
        followed: BoolArray = tracks.hits >= self.hits_min
        return followed

    def _candidates(
        self, clusters: Clusters, T_base_laser: Array, pose_map: Pose2
    ) -> tuple[Array, Array, Array, BoolArray]:
        """Places (k, 2) on the map, widths, ranges, and which stand free (k,), of what may be people."""
        ranges = np.hypot(clusters.centres_laser[:, 0], clusters.centres_laser[:, 1])
        small = np.flatnonzero(clusters.widths_m <= self.width_m_max)
        small = small[np.argsort(ranges[small], kind="stable")[: self.tracks_max]]
        places_base = clusters.centres_laser[small] @ T_base_laser[:2, :2].T + T_base_laser[:2, 3]
        places_map = placed_on_map(places_base, pose_map)
        return places_map, clusters.widths_m[small], ranges[small], clusters.is_free[small]

    def _matches(self, tracks: LaserTracks, places: Array, variances: Array) -> tuple[np.ndarray, np.ndarray]:
        """Rows of tracks and of clusters that belong together: the least sum of squared distances."""
        if not len(tracks) or not len(places):
            return np.empty(0, np.int64), np.empty(0, np.int64)
        apart = places[None, :, :] - tracks.places_map[:, None, :]
        squared = (apart**2).sum(axis=2)
        spread = tracks.spreads[:, 0, None] + variances[None, :]
        fits = (squared <= self.gate**2 * spread) & (squared <= self.gate_m**2)
        # A thing that many scans have shown keeps its cluster when a new one claims it.
        cost = np.where(fits, squared / spread + 2.0 * np.log(spread) + 2.0 / tracks.hits[:, None], _NO_FIT)
        rows, columns = linear_sum_assignment(cost)
        good = fits[rows, columns]
        return rows[good], columns[good]

    def _with_new(
        self, tracks: LaserTracks, places: Array, widths: Array, variances: Array, free: BoolArray
    ) -> LaserTracks:
        room = max(0, self.tracks_max - len(tracks))
        places, widths, variances, free = places[:room], widths[:room], variances[:room], free[:room]
        n = len(places)
        spreads = np.column_stack((variances, np.full(n, self.start_mps**2), np.zeros(n)))
        ids = tracks.next_id + np.arange(n, dtype=np.int64)
        stamps = np.full(n, tracks.stamp_ns, np.int64)
        return LaserTracks(
            tracks.stamp_ns,
            np.concatenate((tracks.ids, ids)),
            np.vstack((tracks.places_map, places)),
            np.vstack((tracks.velocities_map_mps, np.zeros((n, 2)))),
            np.vstack((tracks.spreads, spreads)),
            np.concatenate((tracks.widths_m, widths)),
            np.concatenate((tracks.seen_ns, stamps)),
            np.concatenate((tracks.hits, np.ones(n, np.int64))),
            np.concatenate((tracks.free_hits, free.astype(np.int64))),
            np.vstack((tracks.born_map, places)),
            np.concatenate((tracks.born_ns, stamps)),
            np.concatenate((tracks.misfit, np.full(n, 2.0))),
            np.concatenate((tracks.evidence, np.zeros(n))),
            np.concatenate((tracks.looks, np.zeros(n, np.int64))),
            np.concatenate((tracks.is_person, np.zeros(n, np.bool_))),
            np.concatenate((tracks.has_moved, np.zeros(n, np.bool_))),
            tracks.next_id + n,
        )


def placed_on_map(places_base: Array, pose_map: Pose2) -> Array:
    """(k, 2) on the map of places (k, 2) in the base frame."""
    cos, sin = math.cos(pose_map.yaw_rad), math.sin(pose_map.yaw_rad)
    placed: Array = places_base @ np.array([[cos, sin], [-sin, cos]]) + (pose_map.x_m, pose_map.y_m)
    return placed


def placed_at_base(places_map: Array, pose_map: Pose2) -> Array:
    """(k, 2) in the base frame of places (k, 2) on the map."""
    cos, sin = math.cos(pose_map.yaw_rad), math.sin(pose_map.yaw_rad)
    placed: Array = (places_map - (pose_map.x_m, pose_map.y_m)) @ np.array([[cos, -sin], [sin, cos]])
    return placed


def predicted(tracks: LaserTracks, stamp_ns: int, accel_mps2: float) -> LaserTracks:
    """The tracks at a stamp: constant velocity, white noise of acceleration."""
    dt = (stamp_ns - tracks.stamp_ns) * 1e-9 if tracks.stamp_ns else 0.0
    place, speed, both = tracks.spreads.T
    noise = accel_mps2**2
    spreads = np.column_stack(
        (
            place + 2.0 * dt * both + dt * dt * speed + 0.25 * noise * dt**4,
            speed + noise * dt * dt,
            both + dt * speed + 0.5 * noise * dt**3,
        )
    )
    places = tracks.places_map + dt * tracks.velocities_map_mps
    return msgspec.structs.replace(tracks, stamp_ns=stamp_ns, places_map=places, spreads=spreads)


def _corrected(
    tracks: LaserTracks, rows: np.ndarray, places: Array, widths: Array, variances: Array, free: BoolArray
) -> LaserTracks:
    """Kalman filter: rows (k,) of the tracks get measured places (k, 2), at the tracks' stamp."""
    place, speed, both = tracks.spreads[rows].T
    total = place + variances
    gain, speed_gain = place / total, both / total
    miss = places - tracks.places_map[rows]
    new_places, velocities = tracks.places_map.copy(), tracks.velocities_map_mps.copy()
    new_places[rows] += gain[:, None] * miss
    velocities[rows] += speed_gain[:, None] * miss
    spreads, widths_m = tracks.spreads.copy(), tracks.widths_m.copy()
    spreads[rows] = np.column_stack(((1.0 - gain) * place, speed - speed_gain * both, (1.0 - gain) * both))
    widths_m[rows] += 0.3 * (widths - widths_m[rows])
    seen_ns, hits, misfit = tracks.seen_ns.copy(), tracks.hits.copy(), tracks.misfit.copy()
    seen_ns[rows] = tracks.stamp_ns
    hits[rows] += 1
    misfit[rows] += _MISFIT_GAIN * ((miss**2).sum(axis=1) / total - misfit[rows])
    free_hits, born_map, born_ns = tracks.free_hits.copy(), tracks.born_map.copy(), tracks.born_ns.copy()
    first = rows[free & (free_hits[rows] == 0)]
    born_map[first], born_ns[first] = new_places[first], tracks.stamp_ns
    free_hits[rows] += free
    return msgspec.structs.replace(
        tracks, places_map=new_places, velocities_map_mps=velocities, spreads=spreads, widths_m=widths_m,
        seen_ns=seen_ns, hits=hits, free_hits=free_hits, born_map=born_map, born_ns=born_ns, misfit=misfit,
    )  # fmt: skip

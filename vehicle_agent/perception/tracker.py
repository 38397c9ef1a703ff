"""Tracks from scan to scan: moved to the map frame, smoothed, and carried on when a scan misses them."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, Pose2, wrap_angle
from vehicle_agent.signals import NO_TRACKS, PEDESTRIAN, TRACK_KINDS, TrackPercept, Tracks


class TrackerState(msgspec.Struct, frozen=True):
    """The tracks as they were told last, and when each was really seen; seen_ns (n,) int64."""

    tracks: Tracks = NO_TRACKS
    seen_ns: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0, np.int64))


class AlphaBetaTracker(msgspec.Struct, frozen=True):
    """An alpha-beta filter over each track, and a memory for those that a scan has missed.

    place_gain, velocity_gain  share of what a new sight differs by that is believed. A tracker's velocities
                  are smooth already, their errors last for some scans: to smooth them again takes little
                  of the noise, and tells later of somebody who begins to walk or turns round
    coast_ns      a track that is not seen again goes on as before for so long
    speed_mps_max, size_m_max  nothing on a campus is faster or longer: such a track is not believed
    """

    place_gain: float = 0.6
    velocity_gain: float = 0.8
    coast_ns: int = 800_000_000
    speed_mps_max: float = 25.0
    size_m_max: float = 25.0

    def step(self, before: TrackerState, percept: TrackPercept, pose_map: Pose2) -> TrackerState:
        """pose_map: of the vehicle at the percept's stamp."""
        fresh = self._believed(percept, pose_map)
        dt_s = (percept.stamp_ns - before.tracks.stamp_ns) * 1e-9 if before.tracks.stamp_ns else 0.0
        places = {int(number): i for i, number in enumerate(before.tracks.ids)}
        poses, velocities = fresh.poses_map.copy(), fresh.velocities_map_mps.copy()
        for i, number in enumerate(fresh.ids.tolist()):
            old = places.pop(number, None)
            if old is None or dt_s <= 0.0:
                continue
            expected = before.tracks.poses_map[old, :2] + dt_s * before.tracks.velocities_map_mps[old]
            poses[i, :2] = expected + self.place_gain * (poses[i, :2] - expected)
            was = before.tracks.velocities_map_mps[old]
            velocities[i] = was + self.velocity_gain * (velocities[i] - was)
        _face_where_they_walk(fresh.kinds, poses, velocities)
        recent = [i for i in places.values() if percept.stamp_ns - before.seen_ns[i] <= self.coast_ns]
        missed = np.array(recent, dtype=np.int64)
        tracks = _joined(
            Tracks(percept.stamp_ns, fresh.ids, fresh.kinds, poses, velocities, fresh.sizes_m),
            before.tracks,
            missed,
            dt_s,
        )
        ids = np.concatenate((fresh.ids, before.tracks.ids[missed]))
        seen_ns = np.concatenate(
            (np.full(len(fresh.ids), percept.stamp_ns, np.int64), before.seen_ns[missed])
        )
        return TrackerState(tracks, seen_ns[np.argsort(ids, kind="stable")])

    def _believed(self, percept: TrackPercept, pose_map: Pose2) -> Tracks:
        """In the map frame, without what cannot be: not finite, too fast, too large, told twice."""
        n = len(percept.ids)
        table = np.column_stack((percept.poses_base, percept.velocities_base_mps, percept.sizes_m))
        with np.errstate(invalid="ignore", over="ignore"):
            sound = np.isfinite(table).all(axis=1)
            sound &= np.hypot(table[:, 3], table[:, 4]) <= self.speed_mps_max
            sound &= (table[:, 5:] > 0.0).all(axis=1) & (table[:, 5:] <= self.size_m_max).all(axis=1)
            sound &= np.abs(table[:, :2]).max(axis=1, initial=0.0) < 1e4
        sound &= (percept.kinds >= 0) & (percept.kinds < len(TRACK_KINDS))
        first = np.zeros(n, np.bool_)
        first[np.unique(percept.ids, return_index=True)[1]] = True
        sound &= first
        base, cos, sin = table[sound], math.cos(pose_map.yaw_rad), math.sin(pose_map.yaw_rad)
        poses = np.column_stack(
            (
                pose_map.x_m + cos * base[:, 0] - sin * base[:, 1],
                pose_map.y_m + sin * base[:, 0] + cos * base[:, 1],
                [wrap_angle(yaw) for yaw in base[:, 2] + pose_map.yaw_rad],
            )
        ).reshape(-1, 3)
        velocities = np.column_stack(
            (cos * base[:, 3] - sin * base[:, 4], sin * base[:, 3] + cos * base[:, 4])
        )
        return Tracks(
            percept.stamp_ns,
            percept.ids[sound].astype(np.int64),
            percept.kinds[sound].astype(np.int64),
            poses,
            velocities,
            base[:, 5:].copy(),
        )


def _face_where_they_walk(kinds: np.ndarray, poses: Array, velocities: Array) -> None:
    """A person's heading is the way they walk; who stands keeps the heading that was told."""
    walking = (kinds == PEDESTRIAN) & (np.hypot(velocities[:, 0], velocities[:, 1]) > 0.3)
    poses[walking, 2] = np.arctan2(velocities[walking, 1], velocities[walking, 0])


def _joined(fresh: Tracks, before: Tracks, missed: np.ndarray, dt_s: float) -> Tracks:
    """The fresh tracks, and the missed ones of before carried on by dt_s; in order of their ids."""
    carried = before.poses_map[missed].copy()
    carried[:, :2] += dt_s * before.velocities_map_mps[missed]
    ids = np.concatenate((fresh.ids, before.ids[missed]))
    order = np.argsort(ids, kind="stable")
    return Tracks(
        fresh.stamp_ns,
        ids[order],
        np.concatenate((fresh.kinds, before.kinds[missed]))[order],
        np.vstack((fresh.poses_map, carried))[order],
        np.vstack((fresh.velocities_map_mps, before.velocities_map_mps[missed]))[order],
        np.vstack((fresh.sizes_m, before.sizes_m[missed]))[order],
    )

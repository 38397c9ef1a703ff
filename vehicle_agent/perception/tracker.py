"""Tracks from scan to scan: moved to the map frame, smoothed, and extrapolated when a scan misses them."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, BoolArray, Pose2, wrap_angle
from vehicle_agent.signals import NO_TRACKS, PEDESTRIAN, TRACK_KINDS, TrackPercept, Tracks


class TrackerState(msgspec.Struct, frozen=True):
    """The latest tracks, and the stamp of each one's last detection: seen_ns (n,) int64."""

    tracks: Tracks = NO_TRACKS
    seen_ns: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0, np.int64))


class AlphaBetaTracker(msgspec.Struct, frozen=True):
    """An alpha-beta filter over each track, which coasts when a scan misses it.

    position_gain, velocity_gain  share of a measurement's deviation by which the track is corrected. A
                  tracker's velocities are smooth already: more smoothing removes little noise and delays the
                  detection of a person who starts to walk or turns round
    coast_ns      a missed track continues at its velocity for this long
    speed_mps_max, size_m_max  nothing on a campus is faster or longer: such a track is dropped
    """

    position_gain: float = 0.6
    velocity_gain: float = 0.8
    coast_ns: int = 800_000_000
    speed_mps_max: float = 25.0
    size_m_max: float = 25.0

    def step(self, state: TrackerState, percept: TrackPercept, pose_map: Pose2) -> TrackerState:
        """The tracks after a percept; pose_map: the vehicle's pose at the percept's stamp."""
        measured = self._valid(percept, pose_map)
        dt_s = (percept.stamp_ns - state.tracks.stamp_ns) * 1e-9 if state.tracks.stamp_ns else 0.0
        known = {int(track_id): i for i, track_id in enumerate(state.tracks.ids)}
        poses, velocities = measured.poses_map.copy(), measured.velocities_map_mps.copy()
        for i, track_id in enumerate(measured.ids.tolist()):
            row = known.pop(track_id, None)
            if row is None or dt_s <= 0.0:
                continue
            expected = state.tracks.poses_map[row, :2] + dt_s * state.tracks.velocities_map_mps[row]
            poses[i, :2] = expected + self.position_gain * (poses[i, :2] - expected)
            known_mps = state.tracks.velocities_map_mps[row]
            velocities[i] = known_mps + self.velocity_gain * (velocities[i] - known_mps)
        _set_walking_headings(measured.kinds, poses, velocities)
        coasting = [i for i in known.values() if percept.stamp_ns - state.seen_ns[i] <= self.coast_ns]
        missed = np.array(coasting, dtype=np.int64)
        tracks = _with_missed(
            Tracks(percept.stamp_ns, measured.ids, measured.kinds, poses, velocities, measured.sizes_m),
            state.tracks,
            missed,
            dt_s,
        )
        ids = np.concatenate((measured.ids, state.tracks.ids[missed]))
        seen_ns = np.concatenate(
            (np.full(len(measured.ids), percept.stamp_ns, np.int64), state.seen_ns[missed])
        )
        return TrackerState(tracks, seen_ns[np.argsort(ids, kind="stable")])

    def _valid(self, percept: TrackPercept, pose_map: Pose2) -> Tracks:
        """The plausible tracks in the map frame: finite, not too fast or large, each id once."""
        table = np.column_stack((percept.poses_base, percept.velocities_base_mps, percept.sizes_m))
        valid = self._plausible(percept, table)
        rows, cos, sin = table[valid], math.cos(pose_map.yaw_rad), math.sin(pose_map.yaw_rad)
        poses = np.column_stack(
            (
                pose_map.x_m + cos * rows[:, 0] - sin * rows[:, 1],
                pose_map.y_m + sin * rows[:, 0] + cos * rows[:, 1],
                [wrap_angle(yaw) for yaw in rows[:, 2] + pose_map.yaw_rad],
            )
        ).reshape(-1, 3)
        velocities = np.column_stack(
            (cos * rows[:, 3] - sin * rows[:, 4], sin * rows[:, 3] + cos * rows[:, 4])
        )
        return Tracks(
            percept.stamp_ns,
            percept.ids[valid].astype(np.int64),
            percept.kinds[valid].astype(np.int64),
            poses,
            velocities,
            rows[:, 5:].copy(),
        )

    def _plausible(self, percept: TrackPercept, table: Array) -> BoolArray:
        """(n,) which rows (n, 7) of pose, velocity and size can be a track's."""
        with np.errstate(invalid="ignore", over="ignore"):
            valid = np.isfinite(table).all(axis=1)
            valid &= np.hypot(table[:, 3], table[:, 4]) <= self.speed_mps_max
            valid &= (table[:, 5:] > 0.0).all(axis=1) & (table[:, 5:] <= self.size_m_max).all(axis=1)
            valid &= np.abs(table[:, :2]).max(axis=1, initial=0.0) < 1e4
        valid &= (percept.kinds >= 0) & (percept.kinds < len(TRACK_KINDS))
        is_first = np.zeros(len(percept.ids), np.bool_)
        is_first[np.unique(percept.ids, return_index=True)[1]] = True
        plausible: BoolArray = valid & is_first
        return plausible


def _set_walking_headings(kinds: np.ndarray, poses: Array, velocities: Array) -> None:
    """Sets a walking person's heading to the velocity's direction; a standing one keeps the tracker's."""
    walking = (kinds == PEDESTRIAN) & (np.hypot(velocities[:, 0], velocities[:, 1]) > 0.3)
    poses[walking, 2] = np.arctan2(velocities[walking, 1], velocities[walking, 0])


def _with_missed(measured: Tracks, previous: Tracks, missed: np.ndarray, dt_s: float) -> Tracks:
    """The measured tracks, and the missed ones extrapolated by dt_s; in order of their ids."""
    extrapolated = previous.poses_map[missed].copy()
    extrapolated[:, :2] += dt_s * previous.velocities_map_mps[missed]
    ids = np.concatenate((measured.ids, previous.ids[missed]))
    order = np.argsort(ids, kind="stable")
    return Tracks(
        measured.stamp_ns,
        ids[order],
        np.concatenate((measured.kinds, previous.kinds[missed]))[order],
        np.vstack((measured.poses_map, extrapolated))[order],
        np.vstack((measured.velocities_map_mps, previous.velocities_map_mps[missed]))[order],
        np.vstack((measured.sizes_m, previous.sizes_m[missed]))[order],
    )

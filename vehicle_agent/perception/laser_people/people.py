"""The people around a vehicle by one laser and its cameras, scan by scan and picture by picture."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, BoolArray, Pose2
from vehicle_agent.perception.camera.conditions import CameraCondition, CameraRules
from vehicle_agent.perception.laser_people.segments import SegmentParams, clusters_of
from vehicle_agent.perception.laser_people.tracking import (
    LaserTracker,
    LaserTracks,
    no_laser_tracks,
    placed_at_base,
    predicted,
)
from vehicle_agent.perception.laser_people.verification import PersonVerification, RegionScorer
from vehicle_agent.signals import OTHER, PEDESTRIAN, TrackPercept
from vehicle_agent.signals.objects import SeenObjects
from vehicle_agent.signals.pictures import Picture, PinholeCamera

_PERSON_M = 1.7
_WIDTH_M_MIN = 0.4
# How sure the laser is that something is a road user which no camera has verified. What stands may be a
# bollard or a person who has stopped: it says next to nothing of the kind, and an even guess would be 0.25.
# The end or a part of something larger begins no track of its own.
_MOVED_SCORE, _STANDING_SCORE, _PART_SCORE = 0.5, 0.26, 0.2


class LaserPeopleState(msgspec.Struct, frozen=True):
    """What is followed, and what is known of each camera."""

    tracks: LaserTracks = msgspec.field(default_factory=no_laser_tracks)
    cameras: tuple[CameraCondition, ...] = ()


class LaserPeople(msgspec.Struct, frozen=True):
    """The room: clusters, tracks and labels.

    moving_mps      slower things are not called moving
    moving_spreads  nor those whose speed is within so many of its standard deviations
    moved_m         nor those that are still nearer to their first place
    moving_hits     nor what fewer scans have shown free: the end of what hides a wall moves with the vehicle
    misfit_max      nor what jumps, as leaves and parts of a hedge do (`LaserTracks.misfit`)
    steady_ratio    nor what has gone less than this share of the way that its speed makes
    person_m_max    a wider thing that no camera sees is not taken for a person
    """

    segments: SegmentParams = SegmentParams()
    tracker: LaserTracker = LaserTracker()
    verification: PersonVerification = PersonVerification()
    rules: CameraRules = CameraRules()
    moving_mps: float = 0.4
    moving_spreads: float = 3.0
    moved_m: float = 0.9
    moving_hits: int = 14
    misfit_max: float = 0.5
    steady_ratio: float = 0.6
    person_m_max: float = 1.0

    def after_scan(
        self,
        state: LaserPeopleState,
        ranges_m: Array,
        angles_rad: Array,
        T_base_laser: Array,
        pose_map: Pose2,
        stamp_ns: int,
    ) -> LaserPeopleState:
        """The state after a scan of ranges (n,) at angles (n,), laser frame.

        pose_map  of the vehicle at stamp_ns, the scan's end
        """
        clusters = clusters_of(ranges_m, angles_rad, self.segments)
        tracks = self.tracker.step(state.tracks, clusters, T_base_laser, pose_map, stamp_ns)
        if tracks is not state.tracks:
            tracks = msgspec.structs.replace(tracks, has_moved=tracks.has_moved | self.is_moving(tracks))
        cameras = tuple(self.rules.at(camera, stamp_ns) for camera in state.cameras)
        return LaserPeopleState(tracks, cameras)

    def after_picture(
        self,
        state: LaserPeopleState,
        picture: Picture,
        camera: PinholeCamera,
        pose_map: Pose2,
        scorer: RegionScorer,
    ) -> LaserPeopleState:
        """The state after a picture of `camera`; pose_map: of the vehicle when it was taken."""
        known = {condition.camera: condition for condition in state.cameras}
        condition = known.get(picture.camera) or CameraCondition(picture.camera)
        if picture.stamp_ns <= condition.stamp_ns:
            return state
        condition = self.rules.after_picture(condition, picture)
        tracks, condition = self.verification.look(
            state.tracks, self.tracker.is_followed(state.tracks), picture, camera, pose_map, scorer,
            condition, self.rules,
        )  # fmt: skip
        known[picture.camera] = condition
        return LaserPeopleState(tracks, tuple(known[name] for name in sorted(known)))

    def is_moving(self, tracks: LaserTracks) -> BoolArray:
        """(n,) which of the things go somewhere; what sways comes back to its place."""
        speeds = np.hypot(tracks.velocities_map_mps[:, 0], tracks.velocities_map_mps[:, 1])
        gone = tracks.places_map - tracks.born_map
        ahead = (gone * tracks.velocities_map_mps).sum(axis=1) / np.maximum(speeds, 1e-9)
        followed_s = (tracks.stamp_ns - tracks.born_ns) * 1e-9
        moving: BoolArray = (
            (speeds >= self.moving_mps)
            & (speeds >= self.moving_spreads * np.sqrt(tracks.spreads[:, 1]))
            & (ahead >= self.moved_m)
            & (ahead >= self.steady_ratio * speeds * followed_s)
            & (tracks.free_hits >= self.moving_hits)
            & (tracks.misfit <= self.misfit_max)
        )
        return moving

    def reported(self, state: LaserPeopleState) -> BoolArray:
        """(n,) the things that others should know of: people, and what moves or has moved.

        Without a camera that can be believed, also whatever could be a person and stands.
        """
        tracks = state.tracks
        told = tracks.is_person | tracks.has_moved
        if not any(camera.state == "good" for camera in state.cameras):
            told = told | (tracks.widths_m <= self.person_m_max)
        reported: BoolArray = told & self.tracker.is_followed(tracks)
        return reported

    def seen_objects(
        self, state: LaserPeopleState, pose_map: Pose2, stamp_ns: int | None = None
    ) -> SeenObjects:
        """The reported things without identities, for a tracker that joins several finders.

        stamp_ns  they are moved to it by their velocities, and pose_map is that of it; None: the scan's
        """
        tracks = state.tracks.selected(self.reported(state))
        if stamp_ns is not None:
            tracks = predicted(tracks, stamp_ns, self.tracker.accel_mps2)
        poses, velocities, kinds, widths = _rows_of(tracks, pose_map)
        is_thing = (tracks.free_hits >= self.moving_hits) & (tracks.misfit <= self.misfit_max)
        scores = np.where(tracks.has_moved, _MOVED_SCORE, np.where(is_thing, _STANDING_SCORE, _PART_SCORE))
        verified = 1.0 / (1.0 + np.exp(-np.maximum(tracks.evidence, 0.0)))
        scores = np.where(tracks.is_person, verified, scores)
        sizes = np.column_stack((widths, widths, np.full(len(widths), _PERSON_M)))
        return SeenObjects(tracks.stamp_ns, kinds, scores, poses, sizes, velocities)

    def track_percept(self, state: LaserPeopleState, pose_map: Pose2) -> TrackPercept:
        """The reported things with their identities, as the tick takes them."""
        tracks = state.tracks.selected(self.reported(state))
        poses, velocities, kinds, widths = _rows_of(tracks, pose_map)
        return TrackPercept(
            tracks.stamp_ns, tracks.ids, kinds, poses, velocities, np.column_stack((widths, widths))
        )


def _rows_of(tracks: LaserTracks, pose_map: Pose2) -> tuple[Array, Array, np.ndarray, Array]:
    """Poses (n, 3) and velocities (n, 2) in the base frame, kinds (n,), widths (n,)."""
    places = placed_at_base(tracks.places_map, pose_map)
    velocities = placed_at_base(tracks.velocities_map_mps, Pose2(0.0, 0.0, pose_map.yaw_rad))
    speeds = np.hypot(velocities[:, 0], velocities[:, 1])
    headings = np.where(speeds > 0.3, np.arctan2(velocities[:, 1], velocities[:, 0]), 0.0)
    kinds = np.where(tracks.is_person, PEDESTRIAN, OTHER).astype(np.int64)
    widths = np.maximum(tracks.widths_m, _WIDTH_M_MIN)
    return np.column_stack((places, headings)).reshape(-1, 3), velocities, kinds, widths


def beams_of(
    points_base: Array, T_base_laser: Array, field_rad: float, step_rad: float
) -> tuple[Array, Array]:
    """Ranges (n,), inf without a return, and angles (n,) of a scan that comes as points (k, 3), base frame.

    field_rad, step_rad  of the scanner; a beam that two points claim has the nearer one
    """
    level = (points_base - T_base_laser[:3, 3]) @ T_base_laser[:3, :3]
    beams = 1 + math.floor(field_rad / step_rad + 1e-9)
    angles = step_rad * (np.arange(beams, dtype=np.float64) - 0.5 * (beams - 1))
    rows = np.rint((np.arctan2(level[:, 1], level[:, 0]) - angles[0]) / step_rad).astype(np.int64)
    inside = (rows >= 0) & (rows < beams)
    ranges: Array = np.full(beams, np.inf)
    np.minimum.at(ranges, rows[inside], np.hypot(level[inside, 0], level[inside, 1]))
    return ranges, angles

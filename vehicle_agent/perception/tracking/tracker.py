"""Multi-object tracking: prediction, assignment, correction, births and deaths."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, BoolArray, IntArray, Pose2, inverse, transform_points
from vehicle_agent.perception.tracking.association import associate
from vehicle_agent.perception.tracking.below_beams import (
    NO_AREA,
    NearArea,
    at_rest,
    found_again,
    mark_below,
    may_be_below,
    remembered,
    restart,
)
from vehicle_agent.perception.tracking.motion import (
    PX,
    TURN,
    VX,
    Z_COLUMNS,
    Z_VAR,
    ZV_VAR,
    ZVX,
    ZX,
    combined,
    doubt_velocities,
    predict,
    update,
)
from vehicle_agent.perception.tracking.occlusion import hidden_places
from vehicle_agent.perception.tracking.output import percept_of_tracks
from vehicle_agent.perception.tracking.params import DEFAULT_PARAMS, EVIDENCE_MAX, TrackerParams
from vehicle_agent.perception.tracking.tracks import ObjectTrackerState, TrackTable, no_tracks
from vehicle_agent.perception.tracking.visible_sides import (
    aligned_sizes,
    reaches_into,
    towards_expected,
    towards_far_side,
)
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, TRACK_KINDS, VEHICLE, TrackPercept
from vehicle_agent.signals.objects import SeenObjects

# A finder is never surer of a kind than this, nor less than an even guess.
_SURE, _EVEN = 0.9, 1.0 / len(TRACK_KINDS)
# A track's size follows what looks larger fast, and what looks smaller slowly: that may be a hidden side.
_GROW, _SHRINK, _PERSON_SHRINK = 0.4, 0.03, 0.1
# Evidence against a pedestrian who is faster than people run, in each scan.
_TOO_FAST = 3.0
# A fitted box that is shorter than its track by so much is a part.
_HIDDEN_M = 0.4
# How fast the direction of a standing box follows.
_YAW_GAIN = 0.3
# Above this speed a vehicle's or cyclist's direction is that of its motion, m/s.
_HEADING_MPS = 1.0


class ObjectTracker(msgspec.Struct, frozen=True):
    """Gives the objects of scans identities, velocities and kinds.

    viewpoint_x_m  of the lidars, ahead of the rear axle: the sides that are seen face it
    blind_m        area round the vehicle, base frame: x from, x to, and to either side. Of what comes into it
                   the near parts may be below the lidars' lowest beams
    below_beams    area in which all of a person may be below them
    """

    params: TrackerParams = DEFAULT_PARAMS
    viewpoint_x_m: float = 1.3
    blind_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    below_beams: NearArea = NO_AREA

    def initial(self) -> ObjectTrackerState:
        return ObjectTrackerState(0, 1, no_tracks())

    def step(
        self, state: ObjectTrackerState, seen: SeenObjects, pose_map: Pose2
    ) -> tuple[TrackPercept, ObjectTrackerState]:
        """The tracks after a scan; pose_map: the vehicle's pose at the scan's stamp.

        A scan that is not newer than the last one changes nothing. Objects with values that are not finite
        are left out.
        """
        params = self.params
        if state.stamp_ns and seen.stamp_ns <= state.stamp_ns:
            return percept_of_tracks(state.tracks, state.stamp_ns, pose_map, params), state
        dt_s = (seen.stamp_ns - state.stamp_ns) * 1e-9 if state.stamp_ns else 0.0
        is_gap = dt_s > params.gap_s_max
        tracks = at_rest(self._below(state, pose_map)) if is_gap else state.tracks.copied()
        seen = _finite(seen)
        measured = self._measured(seen, pose_map)
        viewpoint = transform_points(pose_map, np.array([[self.viewpoint_x_m, 0.0]]))[0]
        kinds = kinds_of(tracks)
        # Who was below the beams through a gap has taken a step at most, however long it was.
        if len(tracks) and not is_gap:
            noise = np.array([(m.accel_mps2, m.turn_radps2) for m in params.motions]).transpose(0, 2, 1)
            predict(tracks.means, tracks.covariances, tracks.weights, noise[kinds], params.stay, dt_s)
        yaws = seen.poses_base[:, 2] + pose_map.yaw_rad
        is_part = self._face(tracks, seen, measured, yaws, viewpoint)
        measured[seen.fitted() & ~is_part, Z_VAR] = params.fitted_std_m**2
        rows, columns = associate(tracks, kinds, measured, seen.kinds, seen.sizes_m, params)
        self._correct(tracks, kinds, rows, columns, seen, measured, yaws, viewpoint)
        self._count(tracks, kinds, rows, seen, pose_map)
        new = np.setdiff1d(np.arange(len(seen.kinds)), columns)
        new = new[seen.scores[new] >= params.score_min]
        again = found_again(tracks, measured, seen, new, self.below_beams, dt_s, params)
        restart(tracks, again[0], measured[again[1]])
        tracks.visible_m[again[0]] = _known(seen.visible()[again[1]])
        new = np.setdiff1d(new, again[1])
        tracks = tracks.selected(self._living(tracks))
        born = self._born(seen, measured, yaws, new, state.next_id)
        tracks = tracks.with_rows(born)
        after = ObjectTrackerState(seen.stamp_ns, state.next_id + len(born), tracks)
        return percept_of_tracks(tracks, seen.stamp_ns, pose_map, params), after

    def without_below(self, state: ObjectTrackerState) -> ObjectTrackerState:
        """Without those who were below the beams in the last scan: an operator has looked."""
        return msgspec.structs.replace(state, tracks=state.tracks.selected(~state.tracks.is_below))

    def people_below(self, state: ObjectTrackerState, pose_map: Pose2) -> Array:
        """(n, 3) x, y (base frame) and diameter of who is below the beams or may soon be.

        What another tracker has to know that goes on in this one's place: `with_below`.
        """
        tracks = self._below(state, pose_map)
        places = transform_points(inverse(pose_map), tracks.means[:, 0, PX:VX])
        return np.column_stack((places, tracks.sizes_m[:, :2].mean(axis=1))).reshape(-1, 3)

    def with_below(
        self, state: ObjectTrackerState, people_base: Array, pose_map: Pose2
    ) -> ObjectTrackerState:
        """With these people (n, 3), of whom `people_below` of an earlier tracker told, at rest."""
        people = np.column_stack((transform_points(pose_map, people_base[:, :2]), people_base[:, 2]))
        tracks = state.tracks.with_rows(remembered(people, state.next_id, self.params))
        return ObjectTrackerState(state.stamp_ns, state.next_id + len(people), tracks)

    def _below(self, state: ObjectTrackerState, pose_map: Pose2) -> TrackTable:
        tracks = state.tracks
        may_be = may_be_below(tracks, kinds_of(tracks), pose_map, self.below_beams, self.params)
        return tracks.selected(may_be)

    def _measured(self, seen: SeenObjects, pose_map: Pose2) -> Array:
        """(m, 6) the objects as measurements in the map frame."""
        measured = np.empty((len(seen.kinds), Z_COLUMNS))
        measured[:, ZX : ZX + 2] = transform_points(pose_map, seen.poses_base[:, :2])
        turned = Pose2(0.0, 0.0, pose_map.yaw_rad)
        measured[:, ZVX : ZVX + 2] = transform_points(turned, seen.velocities_base_mps)
        motions = [self.params.motions[int(kind)] for kind in seen.kinds]
        ranges = np.hypot(seen.poses_base[:, 0], seen.poses_base[:, 1])
        near = np.array([motion.position_std_m for motion in motions])
        far = np.array([motion.position_std_per_m for motion in motions])
        measured[:, Z_VAR] = (near + far * ranges) ** 2
        measured[:, ZV_VAR] = np.array([motion.velocity_std_mps for motion in motions]) ** 2
        return measured

    def _face(
        self, tracks: TrackTable, seen: SeenObjects, measured: Array, yaws: Array, viewpoint: Array
    ) -> BoolArray:
        """Moves the middles of vehicles to where they are by the nearest track's size: before assignment.

        (m,) of which objects something hides a part, perhaps of a near side.
        """
        is_part: BoolArray = np.zeros(len(seen.kinds), np.bool_)
        if not len(tracks):
            return is_part
        mean, _ = combined(tracks.means, tracks.covariances, tracks.weights)
        for d in np.flatnonzero(seen.kinds == VEHICLE):
            apart = np.hypot(mean[:, 0] - measured[d, ZX], mean[:, 1] - measured[d, ZX + 1])
            t = int(np.argmin(apart))
            if apart[t] > 0.5 * tracks.sizes_m[t, 0] + 0.5 * seen.sizes_m[d, 0]:
                continue
            size = aligned_sizes(tracks.yaws[t], yaws[d], seen.sizes_m[d])
            missing = np.maximum(tracks.sizes_m[t, :2] - size, 0.0)
            is_part[d] = missing.max() > _HIDDEN_M
            middle = measured[d, ZX : ZX + 2]
            if reaches_into(seen.poses_base[d], seen.sizes_m[d], self.blind_m):
                moved = towards_expected(middle, mean[t, :2], tracks.yaws[t], missing)
            else:
                moved = towards_far_side(middle, viewpoint, tracks.yaws[t], missing)
            measured[d, ZX : ZX + 2] = middle + moved
        return is_part

    def _correct(
        self,
        tracks: TrackTable,
        kinds: IntArray,
        rows: IntArray,
        columns: IntArray,
        seen: SeenObjects,
        measured: Array,
        yaws: Array,
        viewpoint: Array,
    ) -> None:
        """Corrects the tracks `rows` by the objects `columns`, in place."""
        params = self.params
        for t, d in zip(rows.tolist(), columns.tolist(), strict=True):
            score = min(_SURE, max(_EVEN, float(seen.scores[d])))
            likelihood = np.full(len(TRACK_KINDS), (1.0 - score) / (len(TRACK_KINDS) - 1))
            likelihood[seen.kinds[d]] = score
            tracks.evidence[t] = params.forget * tracks.evidence[t] + np.log(likelihood)
            tracks.evidence[t] = np.maximum(tracks.evidence[t] - tracks.evidence[t].max(), -EVIDENCE_MAX)
            size = aligned_sizes(tracks.yaws[t], yaws[d], seen.sizes_m[d])
            if kinds[t] == VEHICLE:
                # What has come into view since lies beyond the sides seen before.
                grown = _GROW * np.maximum(size - tracks.sizes_m[t, :2], 0.0)
                before = tracks.means[t, 0, PX:VX]
                tracks.means[t, :, PX:VX] += towards_far_side(before, viewpoint, tracks.yaws[t], grown)
            off = np.array([size[0], size[1], seen.sizes_m[d, 2]]) - tracks.sizes_m[t]
            shrink = _PERSON_SHRINK if kinds[t] == PEDESTRIAN else _SHRINK
            if kinds[t] == VEHICLE and reaches_into(seen.poses_base[d], seen.sizes_m[d], self.blind_m):
                shrink = 0.0
            tracks.sizes_m[t] += np.where(off > 0.0, _GROW, shrink) * off
        tracks.visible_m[rows] = _known(seen.visible()[columns])
        own = measured[columns]
        motions = [params.motions[int(kind)] for kind in seen.kinds[columns]]
        agree_mps = np.array([motion.agree_mps for motion in motions])
        doubted_mps = np.array([motion.doubted_mps for motion in motions])
        doubt_velocities(tracks.means, tracks.weights, rows, own, agree_mps, doubted_mps)
        update(tracks.means, tracks.covariances, tracks.weights, rows, own)
        straight = (kinds != VEHICLE) & (kinds != CYCLIST)
        tracks.means[straight, :, TURN] = 0.0
        speed = np.hypot(tracks.means[:, 0, VX], tracks.means[:, 0, VX + 1])
        tracks.evidence[rows[speed[rows] > params.person_mps_max], PEDESTRIAN] -= _TOO_FAST
        for t, d in zip(rows.tolist(), columns.tolist(), strict=True):
            if speed[t] > _HEADING_MPS:
                mean = tracks.weights[t] @ tracks.means[t]
                heading = math.atan2(mean[VX + 1], mean[VX])
                if abs(math.remainder(heading - tracks.yaws[t], math.pi)) > 0.25 * math.pi:
                    # It was taken to stand across its motion: what was its width is its length.
                    tracks.sizes_m[t, :2] = tracks.sizes_m[t, 1::-1]
                tracks.yaws[t] = heading
            elif kinds[t] == VEHICLE:
                # A quarter turn is a box that lies across.
                off = math.remainder(yaws[d] - tracks.yaws[t], 0.5 * math.pi)
                tracks.yaws[t] = math.remainder(tracks.yaws[t] + _YAW_GAIN * off, 2.0 * math.pi)

    def _count(
        self, tracks: TrackTable, kinds: IntArray, rows: IntArray, seen: SeenObjects, pose_map: Pose2
    ) -> None:
        """Ages, hits and misses after the scan, in place."""
        is_hit = np.zeros(len(tracks), np.bool_)
        is_hit[rows] = True
        tracks.ages[:] += 1
        tracks.hits[is_hit] += 1
        tracks.misses[:] = np.where(is_hit, 0, tracks.misses + 1)
        places = transform_points(inverse(pose_map), tracks.means[:, 0, PX:VX])
        hidden = hidden_places(places, seen.poses_base, seen.sizes_m, self.viewpoint_x_m)
        params = self.params
        mark_below(tracks, kinds, is_hit, pose_map, self.below_beams, params)
        tracks.hidden[:] = np.where(is_hit, 0, tracks.hidden + (hidden | tracks.is_below))
        tracks.is_confirmed[:] |= is_hit & (tracks.hits >= params.confirm_hits)

    def _living(self, tracks: TrackTable) -> BoolArray:
        params = self.params
        in_view = tracks.misses - tracks.hidden
        # People below the beams stay until they leave or an operator resumes: a vehicle at rest can wait.
        confirmed = (in_view <= params.coast_scans) & (
            tracks.is_below | (tracks.misses <= params.hidden_scans)
        )
        tentative = (tracks.misses < params.tentative_misses) & (tracks.ages < params.confirm_scans)
        living: BoolArray = np.where(tracks.is_confirmed, confirmed, tentative)
        return living

    def _born(
        self, seen: SeenObjects, measured: Array, yaws: Array, new: IntArray, next_id: int
    ) -> TrackTable:
        """Tracks of the objects `new`, which no track has."""
        born = no_tracks(len(new))
        born.ids[:] = next_id + np.arange(len(new))
        born.weights[:] = 0.5
        for row, d in enumerate(new.tolist()):
            motion = self.params.motions[int(seen.kinds[d])]
            z = measured[d]
            born.means[row, :, PX:VX] = z[ZX:ZVX]
            speed_var = motion.speed_std_mps**2
            if not math.isnan(z[ZVX]):
                born.means[row, :, VX:TURN] = z[ZVX:Z_VAR]
                speed_var = self.params.born_std_mps**2
            turn_var = 0.05 if motion.turn_radps2[1] > 0.0 else 0.0
            born.covariances[row] = np.diag([z[Z_VAR], z[Z_VAR], speed_var, speed_var, turn_var])
            score = min(_SURE, max(_EVEN, float(seen.scores[d])))
            born.evidence[row] = math.log((1.0 - score) / (len(TRACK_KINDS) - 1))
            born.evidence[row, seen.kinds[d]] = math.log(score)
        born.sizes_m[:], born.yaws[:] = seen.sizes_m[new], yaws[new]
        born.visible_m[:] = _known(seen.visible()[new])
        born.ages[:] = born.hits[:] = 1
        born.begins_map[:] = measured[new, ZX:ZVX]
        return born


def kinds_of(tracks: TrackTable) -> IntArray:
    """(n,) the likeliest kind of each track."""
    kinds: IntArray = np.argmax(tracks.evidence, axis=1).astype(np.int64)
    return kinds


def _finite(seen: SeenObjects) -> SeenObjects:
    """The objects with finite scores, poses and sizes, and kinds that there are."""
    good = np.isfinite(np.column_stack((seen.scores, seen.poses_base, seen.sizes_m))).all(axis=1)
    good &= (seen.kinds >= 0) & (seen.kinds < len(TRACK_KINDS)) & (seen.sizes_m[:, :2] > 0.0).all(axis=1)
    velocities = np.where(
        np.isfinite(seen.velocities_base_mps).all(axis=1)[:, None], seen.velocities_base_mps, math.nan
    )
    return SeenObjects(
        seen.stamp_ns, seen.kinds[good], seen.scores[good], seen.poses_base[good], seen.sizes_m[good],
        velocities[good], seen.fitted()[good], seen.visible()[good],
    )  # fmt: skip


def _known(visible_m: Array) -> Array:
    """Visible heights, with inf in the place of NaN: what was not looked at was no mere top."""
    return np.where(np.isnan(visible_m), math.inf, visible_m)

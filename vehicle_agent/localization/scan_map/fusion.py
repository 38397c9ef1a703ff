"""The room: GNSS, odometry and scans that lie on the map, one pose, and whether it may be wrong.

Everything but the scans is `gnss_ins.py`'s. A scan's pose is a late measurement of its filter. The map's own
error is the same for all scans of a place, so scans that follow each other count as one.
"""

import math

import msgspec
import numpy as np

from contract.geometry import Array, Pose2, compose, inverse, wrap_angle
from contract.wire.reasons import FaultSeverity
from vehicle_agent.localization.gnss_ins import GnssInsLocalization, LocalizationState
from vehicle_agent.localization.odometry_ekf import GYRO_BIAS, SCALE, SLIP, YAW, X, Y, correct_pose
from vehicle_agent.localization.phases import PhaseRules, PhaseState, Seen, next_phase
from vehicle_agent.localization.proof import ProofState, Sighted, next_proof
from vehicle_agent.localization.scan_map.localizer import ScanPrior
from vehicle_agent.localization.worker_watch import WorkerWatch
from vehicle_agent.signals import (
    Ego,
    Fault,
    GnssFix,
    ImuSample,
    LocalizationJob,
    Navigation,
    PoseHint,
    ScanPose,
    ScanUnplaced,
    VehicleMotion,
    takes_hints,
)
from vehicle_agent.signals.pose_history import pose_at


class ScanMapState(msgspec.Struct, frozen=True):
    """What the room remembers.

    filter          of everything but the scans, corrected by them
    doubt           sum of what scans agreed less than needed (CUSUM); from 1.0 on the pose is called lost
    expected        agreement of the last believed scans, on average: the world may have changed
    scan_ns, scan_pose  of the last scan that was believed
    others          scans in a row that say the same other place; other: T_odom of it, odometry's frame
    restarted_ns    when the pose was last set to the scans' place, 0 never
    phase, watch    see `phases` and `worker_watch`; has_map: the worker's last answer did not miss the map
    agreement       of the last scan; hint_id: of the last hint that was taken
    proof           see `proof`
    """

    filter: LocalizationState
    doubt: float = 0.0
    expected: float = 0.9
    scan_ns: int = 0
    scan_odometer_m: float = 0.0
    odometer_m: float = 0.0
    others: int = 0
    other_map_odom: Pose2 | None = None
    restarted_ns: int = 0
    phase: PhaseState = PhaseState()
    watch: WorkerWatch = WorkerWatch()
    has_map: bool = True
    agreement: float | None = None
    hint_id: str = ""
    proof: ProofState = ProofState()

    @property
    def covariance(self) -> Array:
        return self.filter.covariance

    @property
    def fix_stamp_ns(self) -> int:
        return self.filter.fix_stamp_ns


class ScanMapLocalization(msgspec.Struct, frozen=True):
    """Scan-to-map localization on top of GNSS/INS.

    map_std_m, map_std_rad  of the map at a place; map_m: way after which its error is another one
    gate                  squared Mahalanobis distance beyond which a scan is not believed (chi2, 3)
    scan_m                way on which the errors of scans are the same: what misleads one misleads the next
    agreement_good, lacking_power  of an unchanged world; variances grow with this power of how many times
                          less a scan agrees
    agreement_ratio, agreement_min, agreement_max  a scan has to agree by this share of what is expected,
                          within these bounds. One that agrees less is not believed
    clear_min, clear_max  share of the beams that end on walls, and not behind them. From the first to the
                          second what a scan needs falls by half: things that are new stand before walls, and
                          a wrong pose has walls in the way of its beams
    expected_scans        believed scans over which agreement is averaged
    confirmed_scans       scans that agree less, over which it is averaged while GNSS confirms the pose
    doubt_weight          of the CUSUM: doubt grows by so much of what a scan agrees less than needed
    doubt_max             doubt that is remembered
    lost_std_m            deviation that is stated while the pose may be wrong: the vehicle drives slowly
    confirmed_ns, confirmed_std_m  a believed fix that is younger and a filter that is surer: not lost
    together, together_m, together_rad  scans in a row that must say the same other place, and how nearly
    phases                when doubt becomes being lost
    hint_std_m, hint_std_rad  of the place that an operator names
    proof_scans           scans in a row that prove the place of a vehicle that was lost, with GNSS or a hint
    starts_alone          the worker searches the whole map for a vehicle that has had no fix and no hint
    """

    gnss: GnssInsLocalization
    map_std_m: float = 0.018
    map_std_rad: float = 0.001
    map_m: float = 5.0
    gate: float = 30.0
    scan_m: float = 0.5
    agreement_good: float = 0.9
    lacking_power: float = 4.0
    agreement_ratio: float = 0.6
    agreement_min: float = 0.2
    agreement_max: float = 0.5
    clear_min: float = 0.75
    clear_max: float = 0.85
    expected_scans: float = 60.0
    confirmed_scans: float = 20.0
    doubt_weight: float = 0.7
    doubt_max: float = 2.0
    lost_std_m: float = 0.5
    confirmed_ns: int = 2_000_000_000
    confirmed_std_m: float = 0.3
    together: int = 8
    together_m: float = 0.3
    together_rad: float = 0.03
    phases: PhaseRules = PhaseRules()
    hint_std_m: float = 3.0
    hint_std_rad: float = 0.3
    proof_scans: int = 30
    starts_alone: bool = False

    def initial(self) -> ScanMapState:
        return ScanMapState(self.gnss.initial())

    def step(
        self, state: ScanMapState, motion: VehicleMotion, navigation: tuple[Navigation, ...], now_ns: int
    ) -> tuple[Ego, ScanMapState]:
        """The vehicle at `now_ns`; scans are compared with where it was at their stamps."""
        others = tuple(item for item in navigation if isinstance(item, GnssFix | ImuSample))
        before, restarted_ns, scan_ns, hint_id = (
            state.filter,
            state.restarted_ns,
            state.scan_ns,
            state.hint_id,
        )
        ego, inner = self.gnss.step(before, motion, others, now_ns)
        moved_m = _moved_m(before, inner)
        state = msgspec.structs.replace(state, filter=inner, odometer_m=state.odometer_m + moved_m)
        answers = [item for item in navigation if isinstance(item, ScanPose | ScanUnplaced)]
        scans = [item for item in answers if isinstance(item, ScanPose) and _is_finite(item)]
        for scan in scans:
            state = self._with_scan(state, scan)
        hints = [item for item in navigation if isinstance(item, PoseHint)]
        for hint in hints:
            state = self._with_hint(state, hint)
        asks = self.starts_alone or state.filter.fix_stamp_ns > 0
        watch = state.watch.after(now_ns, asks=asks, answered=bool(answers))
        has_map = (
            isinstance(answers[-1], ScanPose) or answers[-1].reason != "no_map" if answers else state.has_map
        )
        seen = Seen(
            has_pose=state.filter.fix_stamp_ns > 0,
            in_doubt=self.is_lost(state),
            placed_anew=state.restarted_ns != restarted_ns,
            agrees=state.scan_ns != scan_ns,
            has_map=has_map and not watch.is_silent(now_ns),
            way_m=state.odometer_m,
        )
        state = msgspec.structs.replace(
            state,
            watch=watch,
            has_map=has_map,
            agreement=scans[-1].agreement if scans else state.agreement if seen.has_map else None,
            phase=next_phase(state.phase, seen, self.phases, now_ns),
        )
        sighted = Sighted(
            state.phase.phase, seen.agrees, bool(scans) and not seen.agrees, self._is_confirmed(state),
            state.hint_id != hint_id,
        )  # fmt: skip
        state = msgspec.structs.replace(
            state, proof=next_proof(state.proof, sighted, self.proof_scans, now_ns)
        )
        return self._ego(state, motion, ego, is_corrected=bool(scans or hints)), state

    def jobs(self, state: ScanMapState) -> tuple[LocalizationJob, ...]:
        """One in each tick that knows a pose, or whose worker finds one; the worker takes what it needs."""
        inner = state.filter
        is_unknown = inner.fix_stamp_ns == 0
        if is_unknown and not self.starts_alone:
            return ()
        entries = np.ix_([X, Y, YAW], [X, Y, YAW])
        speed_mps = inner.speed_mps if math.isfinite(inner.speed_mps) else 0.0
        job = LocalizationJob(
            inner.stamp_ns, inner.pose_map, inner.odometry, inner.covariance[entries].copy(), speed_mps,
            inner.yaw_rate_radps, self.is_lost(state), is_unknown,
        )  # fmt: skip
        return (job,)

    def prior(self, state: ScanMapState, stamp_ns: int) -> ScanPrior | None:
        """What the worker begins with at a scan's stamp; None: no pose yet, or a stamp of long ago."""
        inner = state.filter
        if inner.fix_stamp_ns == 0 or not inner.poses_odom or stamp_ns < inner.poses_odom[0][0]:
            return None
        then_now = compose(inverse(pose_at(inner.poses_odom, stamp_ns)), inner.odometry)
        pose = compose(inner.pose_map, inverse(then_now))
        entries = np.ix_([X, Y, YAW], [X, Y, YAW])
        speed_mps = inner.speed_mps if math.isfinite(inner.speed_mps) else 0.0
        return ScanPrior(
            pose, inner.covariance[entries].copy(), speed_mps, inner.yaw_rate_radps, self.is_lost(state)
        )

    def is_lost(self, state: ScanMapState) -> bool:
        """Whether scans say that the pose is wrong, and nothing else confirms it."""
        return state.doubt >= 1.0 and not self._is_confirmed(state)

    def _is_confirmed(self, state: ScanMapState) -> bool:
        inner = state.filter
        young = inner.stamp_ns - inner.fix_stamp_ns < self.confirmed_ns and not inner.disagrees_since_ns
        # 0.0: the place is a hint, and no fix has been believed yet.
        return young and 0.0 < inner.offset_std_m < self.confirmed_std_m

    def _with_scan(self, state: ScanMapState, scan: ScanPose) -> ScanMapState:
        inner = state.filter
        if not inner.poses_odom or scan.stamp_ns < inner.poses_odom[0][0]:
            return state
        if inner.fix_stamp_ns == 0:
            return self._started(state, scan) if self.starts_alone else state
        needed = self._needed(state, scan)
        state = self._doubted(state, scan, needed)
        if scan.agreement < needed:
            return msgspec.structs.replace(state, others=0)
        then_now = compose(inverse(pose_at(inner.poses_odom, scan.stamp_ns)), inner.odometry)
        seen_now = compose(scan.pose_map, then_now)
        pose = inner.pose_map
        innovation = np.array(
            (seen_now.x_m - pose.x_m, seen_now.y_m - pose.y_m, wrap_angle(seen_now.yaw_rad - pose.yaw_rad))
        )
        mean, covariance = inner.mean.copy(), inner.covariance.copy()
        distance = correct_pose(mean, covariance, innovation, self._covariance(state, scan), self.gate)
        if distance > self.gate or self.is_lost(state):
            return self._elsewhere(state, scan, seen_now)
        inner = msgspec.structs.replace(inner, mean=mean, covariance=covariance, since_fix_m=0.0)
        expected = state.expected + (scan.agreement - state.expected) / self.expected_scans
        return msgspec.structs.replace(
            state, filter=inner, scan_ns=scan.stamp_ns, scan_odometer_m=state.odometer_m, others=0,
            expected=expected,
        )  # fmt: skip

    def _doubted(self, state: ScanMapState, scan: ScanPose, needed: float) -> ScanMapState:
        """The state with what a scan that agrees or does not says of the pose.

        While GNSS confirms the pose, what scans lack is the world's fault: it is learned and raises no doubt.
        """
        if scan.is_searched:
            return state
        lacks = min(needed, self.agreement_ratio * state.expected) - scan.agreement
        if self._is_confirmed(state) and lacks > 0.0:
            expected = state.expected + (scan.agreement - state.expected) / self.confirmed_scans
            return msgspec.structs.replace(state, expected=expected)
        doubt = min(self.doubt_max, max(0.0, state.doubt + self.doubt_weight * lacks))
        return msgspec.structs.replace(state, doubt=doubt)

    def _needed(self, state: ScanMapState, scan: ScanPose) -> float:
        """What the scan has to agree with the map if the pose is right."""
        needed = min(self.agreement_max, max(self.agreement_min, self.agreement_ratio * state.expected))
        clear = scan.agreement / max(1e-9, scan.agreement + scan.through)
        certain = (clear - self.clear_min) / (self.clear_max - self.clear_min)
        return needed * (1.0 - 0.5 * min(1.0, max(0.0, certain)))

    def _covariance(self, state: ScanMapState, scan: ScanPose) -> Array:
        """(3, 3) of a scan, and of the map, whose error the last scans had as well."""
        since_m = max(0.02, state.odometer_m - state.scan_odometer_m)
        same = max(1.0, 2.0 * self.map_m / since_m) if state.scan_ns else 1.0
        alike = max(1.0, 2.0 * self.scan_m / since_m) if state.scan_ns else 1.0
        # What has changed draws scans to it by decimetres, for metres of the way; they agree less there.
        lacking = max(1.0, self.agreement_good / max(self.agreement_min, scan.agreement))
        found: Array = lacking**self.lacking_power * (
            alike * scan.covariance
            + same * np.diag([self.map_std_m**2, self.map_std_m**2, self.map_std_rad**2])
        )
        return found

    def _elsewhere(self, state: ScanMapState, scan: ScanPose, seen_now: Pose2) -> ScanMapState:
        """A scan that lies well elsewhere. Several that say the same place are believed, unless GNSS is."""
        inner, map_odom = state.filter, compose(seen_now, inverse(state.filter.odometry))
        others = self._others_with(state, seen_now)
        if others < self.together or self._is_confirmed(state):
            return msgspec.structs.replace(state, others=others, other_map_odom=map_odom)
        mean, covariance = inner.mean.copy(), inner.covariance.copy()
        mean[X], mean[Y], mean[YAW] = seen_now.x_m, seen_now.y_m, seen_now.yaw_rad
        # What was learned of the sensors is kept; nothing ties it to the new place.
        covariance[:3, :], covariance[:, :3] = 0.0, 0.0
        covariance[:3, :3] = scan.covariance + np.diag(
            [4.0 * self.map_std_m**2, 4.0 * self.map_std_m**2, 4.0 * self.map_std_rad**2]
        )
        now_ns = inner.stamp_ns
        inner = msgspec.structs.replace(
            inner,
            mean=mean,
            covariance=covariance,
            since_fix_m=0.0,
            jump_since_ns=now_ns,
            disagrees_since_ns=0,
        )
        return msgspec.structs.replace(
            state, filter=inner, doubt=0.0, scan_ns=scan.stamp_ns, scan_odometer_m=state.odometer_m, others=0,
            other_map_odom=None, restarted_ns=now_ns,
        )  # fmt: skip

    def _others_with(self, state: ScanMapState, seen_now: Pose2) -> int:
        """How many scans in a row say the same other place, after one that says seen_now."""
        if state.other_map_odom is None or not state.others:
            return state.others + 1
        there = compose(state.other_map_odom, state.filter.odometry)
        apart_m = math.hypot(there.x_m - seen_now.x_m, there.y_m - seen_now.y_m)
        turn_rad = abs(wrap_angle(there.yaw_rad - seen_now.yaw_rad))
        return 1 if apart_m > self.together_m or turn_rad > self.together_rad else state.others + 1

    def _started(self, state: ScanMapState, scan: ScanPose) -> ScanMapState:
        """A scan's place where nothing else has told one yet; several that say the same are believed."""
        inner = state.filter
        if scan.agreement < self.agreement_max:
            return msgspec.structs.replace(state, others=0)
        then_now = compose(inverse(pose_at(inner.poses_odom, scan.stamp_ns)), inner.odometry)
        seen_now = compose(scan.pose_map, then_now)
        others = self._others_with(state, seen_now)
        if others < self.together:
            map_odom = compose(seen_now, inverse(inner.odometry))
            return msgspec.structs.replace(state, others=others, other_map_odom=map_odom)
        found = self.hinted(state, seen_now, 2.0 * self.map_std_m, 2.0 * self.map_std_rad)
        covariance = found.filter.covariance.copy()
        covariance[:3, :3] += scan.covariance
        return msgspec.structs.replace(
            found, filter=msgspec.structs.replace(found.filter, covariance=covariance), doubt=0.0,
            scan_ns=scan.stamp_ns, scan_odometer_m=state.odometer_m, restarted_ns=inner.stamp_ns,
        )  # fmt: skip

    def _with_hint(self, state: ScanMapState, hint: PoseHint) -> ScanMapState:
        """The place that an operator names, of a vehicle that stands; a repeat changes nothing."""
        if hint.hint_id == state.hint_id or not takes_hints(state.filter.speed_mps):
            return state
        found = self.hinted(state, hint.pose_map, self.hint_std_m, self.hint_std_rad)
        return msgspec.structs.replace(found, hint_id=hint.hint_id)

    def hinted(self, state: ScanMapState, pose_map: Pose2, std_m: float, std_rad: float) -> ScanMapState:
        """The state after somebody said where the vehicle is; scans then search around it."""
        inner, noise = state.filter, self.gnss.noise
        mean, covariance = inner.mean.copy(), inner.covariance.copy()
        mean[X], mean[Y], mean[YAW] = pose_map.x_m, pose_map.y_m, pose_map.yaw_rad
        covariance[:3, :], covariance[:, :3] = 0.0, 0.0
        covariance[X, X], covariance[Y, Y], covariance[YAW, YAW] = std_m**2, std_m**2, std_rad**2
        if inner.fix_stamp_ns == 0:
            # A vehicle that has had no fix has learned nothing of its sensors either.
            covariance[GYRO_BIAS, GYRO_BIAS] = noise.gyro_bias_radps_first**2
            covariance[SCALE, SCALE], covariance[SLIP, SLIP] = noise.scale_first**2, noise.slip_s2pm_first**2
        inner = msgspec.structs.replace(
            inner,
            mean=mean,
            covariance=covariance,
            fix_stamp_ns=inner.fix_stamp_ns or inner.stamp_ns,
            since_fix_m=0.0,
        )
        # The search goes on until a scan agrees.
        return msgspec.structs.replace(state, filter=inner, doubt=1.0, others=0, other_map_odom=None)

    def _ego(self, state: ScanMapState, motion: VehicleMotion, ego: Ego, *, is_corrected: bool) -> Ego:
        now_ns, phase = state.filter.stamp_ns, state.phase.phase
        if is_corrected:
            # A step without inputs and without time says what the corrected filter says.
            ego, _ = self.gnss.step(state.filter, motion, (), now_ns)
        faults = ego.faults
        if state.watch.is_silent(now_ns):
            faults = (*faults, Fault("localization_silent", "warning", state.watch.since_ns))
        std_m, stands = ego.position_std_m, phase == "lost"
        if phase in ("doubtful", "lost"):
            std_m = max(std_m, self.lost_std_m)
            if not any(fault.code == "pose_poor" and fault.severity == "stop" for fault in faults):
                severity: FaultSeverity = "stop" if stands else "warning"
                faults = (*faults, Fault("pose_poor", severity, state.phase.since_ns))
        return msgspec.structs.replace(
            ego,
            position_std_m=std_m,
            pose_stamp_ns=state.phase.since_ns if stands and ego.valid else ego.pose_stamp_ns,
            valid=ego.valid and not stands,
            faults=faults,
            phase=phase,
            agreement=state.agreement,
            proven_ns=state.proof.proven_ns,
        )


def _moved_m(before: LocalizationState, after: LocalizationState) -> float:
    return math.hypot(after.odometry.x_m - before.odometry.x_m, after.odometry.y_m - before.odometry.y_m)


def _is_finite(scan: ScanPose) -> bool:
    values = (scan.pose_map.x_m, scan.pose_map.y_m, scan.pose_map.yaw_rad, scan.agreement)
    return all(map(math.isfinite, values)) and bool(np.isfinite(scan.covariance).all())

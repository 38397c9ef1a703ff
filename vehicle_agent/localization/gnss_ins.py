"""The vehicle's pose from GNSS/INS fixes, wheel speed and gyroscope, through outages and jumps.

GEM paper, section II (GNSS/INS); NUS paper, section II (GPS and gyroscope in an extended Kalman filter). A
late fix is applied where the vehicle was at its stamp (Snow Lion paper, section III).
"""

import math

import msgspec
import numpy as np

from contract.geometry import Array, Pose2, compose, inverse, wrap_angle
from contract.roads.model import Origin
from contract.roads.projection import project
from vehicle_agent.localization.odometry_ekf import (
    GYRO_BIAS,
    OFFSET_X,
    OFFSET_Y,
    OFFSET_YAW,
    SCALE,
    SIZE,
    SLIP,
    YAW,
    OdometryNoise,
    X,
    Y,
    correct_entry,
    correct_heading,
    correct_position,
    position_std_m,
    propagate_pose,
    restart_offset,
)
from vehicle_agent.signals import Ego, Fault, GnssFix, ImuSample, LocalizationJob, Navigation, VehicleMotion
from vehicle_agent.signals.pose_history import PoseHistory, pose_at

_NO_POSE = Pose2(0.0, 0.0, 0.0)


class LocalizationState(msgspec.Struct, frozen=True):
    """What localization remembers at `stamp_ns`.

    mean, covariance    (9,) and (9, 9), see `odometry_ekf`
    odometry, poses_odom  the vehicle in a frame that no fix corrects, now and in the last half second
    fix_stamp_ns        of the last fix that was believed, 0 before the first; since_fix_m: driven since then
    report_ns           of the wheels' speed
    offset_std_m, offset_std_rad  of place and heading, as the receiver last stated them
    disagrees_since_ns  since when fixes have not been believed, 0: the last one was
    together_since_ns   since when they have been in one place beside the pose
    outage_m            driven without a fix before that
    disagreement        where the last one of them was beside the pose, m, in the map frame
    standing_ns         since when the wheels stand, 0: they turn
    invalid_ns          when a value was last not finite, 0 never
    invalid_since_ns    since when values have been so, again and again
    no_solution_ns      when the receiver last said that it has no solution, 0 never
    """

    mean: Array
    covariance: Array
    stamp_ns: int = 0
    odometry: Pose2 = _NO_POSE
    poses_odom: PoseHistory = ()
    speed_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    accel_mps2: float = 0.0
    fix_stamp_ns: int = 0
    since_fix_m: float = 0.0
    imu_stamp_ns: int = 0
    report_ns: int = 0
    offset_std_m: float = 0.0
    offset_std_rad: float = 0.0
    disagrees_since_ns: int = 0
    together_since_ns: int = 0
    outage_m: float = 0.0
    disagreement: tuple[float, float] = (0.0, 0.0)
    standing_ns: int = 0
    jump_since_ns: int = 0
    invalid_ns: int = 0
    invalid_since_ns: int = 0
    no_solution_ns: int = 0

    @property
    def pose_map(self) -> Pose2:
        return Pose2(float(self.mean[X]), float(self.mean[Y]), wrap_angle(float(self.mean[YAW])))


class GnssInsLocalization(msgspec.Struct, frozen=True):
    """Extended Kalman filter over odometry; a fix is believed while it is where it can be.

    slip_s2pm         of the rear axle on nominal tyres: where the filter begins
    stated_factor     so many times what the receiver states is believed: it knows nothing of reflections
    heading_std_rad   of a receiver that does not state it
    gate              squared Mahalanobis distance beyond which a fix is not believed (5 sigma)
    doubt_ns          fixes that disagree for longer than this make the pose doubtful: half of the distance
                      counts as deviation
    restart_ns        after so long the pose starts again at the fixes, if they stay together (`pose_jump`)
    restart_soon_ns, blind_m  the same after an outage of blind_m and more: odometry is good for less then
    together_m        how far they may wander meanwhile
    outage_m_max      farther without a believed fix, no deviation is small enough (`pose_stale`)
    nonsense_ns_max   values that are not finite, again and again for so long without a believed fix, stop
                      the vehicle
    history_ns        latest fix that can be placed
    still_ns          the wheels stand for so long: the gyroscope shows its bias
    still_gyro_radps  what else it shows then, as a deviation of one sample
    """

    origin: Origin
    noise: OdometryNoise = OdometryNoise()
    slip_s2pm: float = 0.0
    stated_factor: float = 1.25
    heading_std_rad: float = 0.0087
    gate: float = 25.0
    doubt_ns: int = 1_000_000_000
    restart_ns: int = 60_000_000_000
    restart_soon_ns: int = 3_000_000_000
    blind_m: float = 20.0
    together_m: float = 1.0
    outage_m_max: float = 200.0
    nonsense_ns_max: int = 300_000_000
    history_ns: int = 500_000_000
    still_ns: int = 1_000_000_000
    still_gyro_radps: float = 0.02
    jump_shown_ns: int = 2_000_000_000
    position_std_m_max: float = 1.0
    accel_filter_s: float = 0.2

    def initial(self) -> LocalizationState:
        mean = np.zeros(SIZE)
        mean[SLIP] = self.slip_s2pm
        return LocalizationState(mean, np.zeros((SIZE, SIZE)))

    def step(
        self,
        state: LocalizationState,
        motion: VehicleMotion,
        navigation: tuple[Navigation, ...],
        now_ns: int,
    ) -> tuple[Ego, LocalizationState]:
        """The vehicle at `now_ns`. A late fix is compared with where the vehicle was at its stamp."""
        fixes = [item for item in navigation if isinstance(item, GnssFix) and _is_finite(item)]
        samples = [item for item in navigation if isinstance(item, ImuSample) and _is_finite(item)]
        measured = sum(isinstance(item, GnssFix | ImuSample) for item in navigation)
        if len(fixes) + len(samples) < measured:
            # A value that is not finite would stay in the pose for ever.
            again = state.invalid_ns and now_ns - state.invalid_ns <= self.nonsense_ns_max
            since_ns = state.invalid_since_ns if again else now_ns
            state = msgspec.structs.replace(state, invalid_ns=now_ns, invalid_since_ns=since_ns)
        state = self._with_inertial(state, samples, fixes)
        speed_mps = state.speed_mps
        if motion.stamp_ns > 0:
            speed_mps = motion.speed_mps
        elif fixes:
            speed_mps = fixes[-1].speed_mps
        state = self._propagated(state, speed_mps, motion.stamp_ns, now_ns, has_gyro=bool(samples))
        for fix in fixes:
            state = self._with_fix(state, fix)
        return self._ego(state, motion), state

    def jobs(self, state: LocalizationState) -> tuple[LocalizationJob, ...]:
        """None: it asks no worker."""
        return ()

    def _with_inertial(
        self, state: LocalizationState, samples: list[ImuSample], fixes: list[GnssFix]
    ) -> LocalizationState:
        yaw_rate_radps = fixes[-1].yaw_rate_radps if fixes else state.yaw_rate_radps
        accel_mps2, stamp_ns = state.accel_mps2, state.imu_stamp_ns
        for sample in samples:
            dt_s = (sample.stamp_ns - stamp_ns) * 1e-9 if stamp_ns else self.accel_filter_s
            share = 1.0 - math.exp(-max(0.0, dt_s) / self.accel_filter_s)
            accel_mps2 += share * (sample.accel_mps2 - accel_mps2)
            yaw_rate_radps, stamp_ns = sample.yaw_rate_radps, sample.stamp_ns
        return msgspec.structs.replace(
            state, yaw_rate_radps=yaw_rate_radps, accel_mps2=accel_mps2, imu_stamp_ns=stamp_ns
        )

    def _propagated(
        self, state: LocalizationState, speed_mps: float, report_ns: int, now_ns: int, *, has_gyro: bool
    ) -> LocalizationState:
        """The state at now_ns, by odometry; a vehicle that stands shows the gyroscope's bias."""
        wheel_mps = speed_mps if math.isfinite(speed_mps) else 0.0
        dt_s = max(0, now_ns - state.stamp_ns) * 1e-9 if state.stamp_ns else 0.0
        # When it changed between two reports is not known.
        between_s = max(0, report_ns - state.report_ns) * 1e-9 if state.report_ns else 0.0
        before_mps = state.speed_mps if math.isfinite(state.speed_mps) else 0.0
        jolt_m = 0.5 * abs(wheel_mps - before_mps) * min(between_s, 0.2)
        standing_ns = (state.standing_ns or now_ns) if wheel_mps == 0.0 else 0
        mean, covariance = state.mean.copy(), state.covariance.copy()
        turn_radps = state.yaw_rate_radps - float(mean[GYRO_BIAS])
        if state.fix_stamp_ns:
            propagate_pose(
                mean, covariance, wheel_mps, state.yaw_rate_radps, dt_s, jolt_m,
                state.offset_std_m, state.offset_std_rad, self.noise.row(),
            )  # fmt: skip
            if has_gyro and standing_ns and now_ns - standing_ns >= self.still_ns:
                correct_entry(mean, covariance, GYRO_BIAS, turn_radps, self.still_gyro_radps**2, self.gate)
        turned_rad = turn_radps * dt_s if wheel_mps else 0.0
        moved_m = (1.0 + float(mean[SCALE])) * wheel_mps * dt_s
        half_rad = 0.5 * turned_rad
        moved = Pose2(moved_m * math.cos(half_rad), moved_m * math.sin(half_rad), turned_rad)
        odometry = compose(state.odometry, moved)
        kept = tuple(entry for entry in state.poses_odom if now_ns - entry[0] <= self.history_ns)
        return msgspec.structs.replace(
            state,
            mean=mean,
            covariance=covariance,
            stamp_ns=now_ns,
            odometry=odometry,
            poses_odom=(*kept, (now_ns, odometry)),
            speed_mps=speed_mps,
            report_ns=report_ns,
            since_fix_m=state.since_fix_m + abs(moved_m),
            standing_ns=standing_ns,
        )

    def _with_fix(self, state: LocalizationState, fix: GnssFix) -> LocalizationState:
        if not math.isfinite(fix.position_std_m):
            return msgspec.structs.replace(state, no_solution_ns=state.stamp_ns)
        if fix.stamp_ns < state.poses_odom[0][0]:
            # Where the vehicle was then is not known any more, or not yet.
            return state
        then_now = compose(inverse(pose_at(state.poses_odom, fix.stamp_ns)), state.odometry)
        if state.fix_stamp_ns == 0:
            return self._started_at(state, fix, then_now)
        pose_then = compose(state.pose_map, inverse(then_now))
        x_m, y_m = project(self.origin, fix.latitude_deg, fix.longitude_deg)
        dx_m, dy_m = x_m - pose_then.x_m, y_m - pose_then.y_m
        std_m, std_rad = self._stated(fix)
        mean, covariance = state.mean.copy(), state.covariance.copy()
        if not state.offset_std_m / 1.5 <= std_m <= state.offset_std_m * 1.5:
            restart_offset(mean, covariance, std_m, std_rad, self.noise.row())
        white = 1.0 - self.noise.offset_share
        is_believed = correct_position(mean, covariance, dx_m, dy_m, white * std_m**2, self.gate) <= self.gate
        turn_rad = wrap_angle(fix.heading_rad - pose_then.yaw_rad)
        is_believed &= correct_heading(mean, covariance, turn_rad, white * std_rad**2, self.gate) <= self.gate
        if not is_believed:
            return self._disagreeing(state, fix, then_now, (dx_m, dy_m))
        return msgspec.structs.replace(
            state,
            mean=mean,
            covariance=covariance,
            fix_stamp_ns=max(fix.stamp_ns, state.fix_stamp_ns),
            since_fix_m=0.0,
            offset_std_m=std_m,
            offset_std_rad=std_rad,
            disagrees_since_ns=0,
        )

    def _stated(self, fix: GnssFix) -> tuple[float, float]:
        """Deviations of place and heading that are believed of the receiver."""
        heading_rad = fix.heading_std_rad if fix.heading_std_rad > 0.0 else self.heading_std_rad
        return max(self.stated_factor * fix.position_std_m, 1e-3), heading_rad

    def _disagreeing(
        self, state: LocalizationState, fix: GnssFix, then_now: Pose2, disagreement: tuple[float, float]
    ) -> LocalizationState:
        """A fix that is not believed; fixes that stay together for long enough are."""
        now_ns, before = state.stamp_ns, state.disagreement
        since_ns, together_ns = state.disagrees_since_ns or now_ns, state.together_since_ns
        strayed_m = math.hypot(disagreement[0] - before[0], disagreement[1] - before[1])
        if state.disagrees_since_ns == 0 or strayed_m > self.together_m + 3.0 * fix.position_std_m:
            together_ns = now_ns
        outage_m = state.outage_m if state.disagrees_since_ns else state.since_fix_m
        restart_ns = self.restart_ns if outage_m < self.blind_m else self.restart_soon_ns
        if now_ns - together_ns >= restart_ns:
            restarted = self._started_at(state, fix, then_now)
            return msgspec.structs.replace(restarted, jump_since_ns=now_ns)
        return msgspec.structs.replace(
            state,
            disagrees_since_ns=since_ns,
            together_since_ns=together_ns,
            outage_m=outage_m,
            disagreement=disagreement,
        )

    def _started_at(self, state: LocalizationState, fix: GnssFix, then_now: Pose2) -> LocalizationState:
        """The pose as the fix says; what was learned of the sensors is kept."""
        x_m, y_m = project(self.origin, fix.latitude_deg, fix.longitude_deg)
        pose = compose(Pose2(x_m, y_m, wrap_angle(fix.heading_rad)), then_now)
        is_first = state.fix_stamp_ns == 0
        (std_m, std_rad), noise = self._stated(fix), self.noise
        mean, covariance = state.mean.copy(), np.zeros((SIZE, SIZE))
        mean[X], mean[Y], mean[YAW] = pose.x_m, pose.y_m, pose.yaw_rad
        mean[OFFSET_X] = mean[OFFSET_Y] = mean[OFFSET_YAW] = 0.0
        offset_m2, offset_rad2 = noise.offset_share * std_m**2, noise.offset_share * std_rad**2
        for i, variance in (
            (X, std_m * std_m),
            (Y, std_m * std_m),
            (YAW, std_rad * std_rad),
            (
                GYRO_BIAS,
                noise.gyro_bias_radps_first**2 if is_first else state.covariance[GYRO_BIAS, GYRO_BIAS],
            ),
            (SCALE, noise.scale_first**2 if is_first else state.covariance[SCALE, SCALE]),
            (SLIP, noise.slip_s2pm_first**2 if is_first else state.covariance[SLIP, SLIP]),
            (OFFSET_X, offset_m2),
            (OFFSET_Y, offset_m2),
            (OFFSET_YAW, offset_rad2),
        ):
            covariance[i, i] = variance
        # The pose is the receiver's, so its error is the receiver's as well.
        for entry, offset in ((X, OFFSET_X), (Y, OFFSET_Y), (YAW, OFFSET_YAW)):
            covariance[entry, offset] = covariance[offset, entry] = -covariance[offset, offset]
        return msgspec.structs.replace(
            state,
            mean=mean,
            covariance=covariance,
            fix_stamp_ns=fix.stamp_ns,
            since_fix_m=0.0,
            offset_std_m=std_m,
            offset_std_rad=std_rad,
            disagrees_since_ns=0,
        )

    def _position_std_m(self, state: LocalizationState) -> float:
        if state.fix_stamp_ns == 0:
            return math.inf
        std_m = position_std_m(state.covariance)
        if state.disagrees_since_ns and state.stamp_ns - state.disagrees_since_ns >= self.doubt_ns:
            std_m = max(std_m, 0.5 * math.hypot(*state.disagreement))
        return std_m

    def _ego(self, state: LocalizationState, motion: VehicleMotion) -> Ego:
        std_m = self._position_std_m(state)
        faults = self._faults(state, std_m)
        valid = not any(fault.severity == "stop" for fault in faults)
        return Ego(
            stamp_ns=state.stamp_ns,
            pose_map=state.pose_map,
            speed_mps=state.speed_mps,
            accel_mps2=state.accel_mps2,
            yaw_rate_radps=state.yaw_rate_radps - float(state.mean[GYRO_BIAS]),
            steer_rad=motion.steer_rad,
            position_std_m=std_m,
            pose_stamp_ns=state.stamp_ns if valid else state.fix_stamp_ns,
            valid=valid,
            faults=faults,
        )

    def _faults(self, state: LocalizationState, std_m: float) -> tuple[Fault, ...]:
        now_ns = state.stamp_ns
        faults: list[Fault] = []
        if state.fix_stamp_ns == 0:
            code = "pose_poor" if state.no_solution_ns else "pose_missing"
            return (Fault(code, "stop", state.no_solution_ns),)  # type: ignore[arg-type]
        if state.since_fix_m > self.outage_m_max:
            faults.append(Fault("pose_stale", "stop", state.fix_stamp_ns))
        if not std_m <= self.position_std_m_max:
            faults.append(Fault("pose_poor", "stop", state.fix_stamp_ns))
        if state.jump_since_ns and now_ns - state.jump_since_ns < self.jump_shown_ns:
            faults.append(Fault("pose_jump", "stop", state.jump_since_ns))
        if state.invalid_ns and now_ns - state.invalid_ns < self.jump_shown_ns:
            # A receiver that says nothing may be between buildings; one that goes on with nonsense is broken.
            good_ns = max(state.fix_stamp_ns, state.invalid_since_ns)
            lasts = now_ns - good_ns > self.nonsense_ns_max >= now_ns - state.invalid_ns
            faults.append(Fault("pose_not_finite", "stop" if lasts else "warning", state.invalid_ns))
        return tuple(faults)


def _is_finite(item: GnssFix | ImuSample) -> bool:
    """Except position_std_m: one that is no number means that there is no solution."""
    if isinstance(item, ImuSample):
        return math.isfinite(item.accel_mps2) and math.isfinite(item.yaw_rate_radps)
    values = (item.latitude_deg, item.longitude_deg, item.heading_rad, item.speed_mps, item.yaw_rate_radps)
    return all(map(math.isfinite, values))

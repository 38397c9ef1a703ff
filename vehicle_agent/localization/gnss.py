"""The vehicle's pose: GNSS/INS fixes in the map frame, with dead reckoning between them (GEM, section II)."""

import math

import msgspec

from contract.geometry import Pose2, wrap_angle
from contract.roads.model import Origin
from contract.roads.projection import project
from vehicle_agent.signals import Ego, Fault, GnssFix, ImuSample, VehicleMotion
from vehicle_agent.signals.rates import POSE_AGE_NS_MAX

_NO_POSE = Pose2(0.0, 0.0, 0.0)


class LocalizationState(msgspec.Struct, frozen=True):
    """What localization remembers; `pose_map` is the pose at `stamp_ns`.

    outliers    fixes in a row that were far from the pose
    invalid_ns  when a value was last not finite, 0 never
    """

    stamp_ns: int = 0
    pose_map: Pose2 = _NO_POSE
    speed_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    accel_mps2: float = 0.0
    position_std_m: float = math.inf
    fix_stamp_ns: int = 0
    imu_stamp_ns: int = 0
    outliers: int = 0
    jump_since_ns: int = 0
    invalid_ns: int = 0


class GnssLocalization(msgspec.Struct, frozen=True):
    """Fixed-gain observer: wheel speed and yaw rate move the pose, each fix corrects it by a fixed share.

    gain_position, gain_heading  share of a fix's deviation by which the pose is corrected (0..1); at 50 fixes
                                 a second 0.15 averages noise over about 0.13 s
    jump_m        a fix farther than this from the pose is an outlier
    outliers_max  after this many outliers in a row the pose starts again there, with the fault `pose_jump`
    """

    origin: Origin
    gain_position: float = 0.15
    gain_heading: float = 0.1
    jump_m: float = 1.0
    outliers_max: int = 10
    jump_shown_ns: int = 2_000_000_000
    age_ns_max: int = POSE_AGE_NS_MAX
    position_std_m_max: float = 1.0
    accel_filter_s: float = 0.2

    def initial(self) -> LocalizationState:
        return LocalizationState()

    def step(
        self,
        state: LocalizationState,
        motion: VehicleMotion,
        navigation: tuple[GnssFix | ImuSample, ...],
        now_ns: int,
    ) -> tuple[Ego, LocalizationState]:
        """The vehicle at `now_ns`. A fix may be late: it is extrapolated from its own stamp."""
        fixes = [item for item in navigation if isinstance(item, GnssFix) and _is_finite(item)]
        samples = [item for item in navigation if isinstance(item, ImuSample) and _is_finite(item)]
        if len(fixes) + len(samples) < len(navigation):
            # A value that is not finite would stay in the pose for ever.
            state = msgspec.structs.replace(state, invalid_ns=now_ns)
        state = self._with_inertial(state, samples, fixes)
        speed_mps = state.speed_mps
        if motion.stamp_ns > 0:
            speed_mps = motion.speed_mps
        elif fixes:
            speed_mps = fixes[-1].speed_mps
        state = msgspec.structs.replace(
            state,
            stamp_ns=now_ns,
            pose_map=_dead_reckoned(state.pose_map, speed_mps, state.yaw_rate_radps, now_ns - state.stamp_ns),
            speed_mps=speed_mps,
        )
        for fix in fixes:
            state = self._with_fix(state, fix)
        return self._ego(state, motion), state

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

    def _with_fix(self, state: LocalizationState, fix: GnssFix) -> LocalizationState:
        x_m, y_m = project(self.origin, fix.latitude_deg, fix.longitude_deg)
        fix_pose = Pose2(x_m, y_m, wrap_angle(fix.heading_rad))
        measured = _dead_reckoned(
            fix_pose, state.speed_mps, state.yaw_rate_radps, state.stamp_ns - fix.stamp_ns
        )
        changes = {
            "fix_stamp_ns": max(fix.stamp_ns, state.fix_stamp_ns),
            "position_std_m": fix.position_std_m,
        }
        if state.fix_stamp_ns == 0:
            return msgspec.structs.replace(state, pose_map=measured, outliers=0, **changes)
        pose = state.pose_map
        dx_m, dy_m = measured.x_m - pose.x_m, measured.y_m - pose.y_m
        if math.hypot(dx_m, dy_m) > self.jump_m + 3.0 * fix.position_std_m:
            if state.outliers + 1 < self.outliers_max:
                return msgspec.structs.replace(state, outliers=state.outliers + 1)
            return msgspec.structs.replace(
                state, pose_map=measured, outliers=0, jump_since_ns=state.stamp_ns, **changes
            )
        corrected = Pose2(
            pose.x_m + self.gain_position * dx_m,
            pose.y_m + self.gain_position * dy_m,
            wrap_angle(pose.yaw_rad + self.gain_heading * wrap_angle(measured.yaw_rad - pose.yaw_rad)),
        )
        return msgspec.structs.replace(state, pose_map=corrected, outliers=0, **changes)

    def _ego(self, state: LocalizationState, motion: VehicleMotion) -> Ego:
        faults = self._faults(state)
        return Ego(
            stamp_ns=state.stamp_ns,
            pose_map=state.pose_map,
            speed_mps=state.speed_mps,
            accel_mps2=state.accel_mps2,
            yaw_rate_radps=state.yaw_rate_radps,
            steer_rad=motion.steer_rad,
            position_std_m=state.position_std_m if state.fix_stamp_ns else math.inf,
            fix_stamp_ns=state.fix_stamp_ns,
            valid=not any(fault.severity == "stop" for fault in faults),
            faults=faults,
        )

    def _faults(self, state: LocalizationState) -> tuple[Fault, ...]:
        now_ns = state.stamp_ns
        if state.fix_stamp_ns == 0:
            return (Fault("pose_missing", "stop", 0),)
        faults: list[Fault] = []
        if now_ns - state.fix_stamp_ns > self.age_ns_max:
            faults.append(Fault("pose_stale", "stop", state.fix_stamp_ns))
        if not state.position_std_m <= self.position_std_m_max:
            faults.append(Fault("pose_poor", "stop", state.fix_stamp_ns))
        if state.jump_since_ns and now_ns - state.jump_since_ns < self.jump_shown_ns:
            faults.append(Fault("pose_jump", "stop", state.jump_since_ns))
        if state.invalid_ns and now_ns - state.invalid_ns < self.jump_shown_ns:
            faults.append(Fault("pose_not_finite", "warning", state.invalid_ns))
        return tuple(faults)


def _is_finite(item: GnssFix | ImuSample) -> bool:
    """Except position_std_m: an infinite one means that there is no solution, which `_faults` reports."""
    if isinstance(item, ImuSample):
        return math.isfinite(item.accel_mps2) and math.isfinite(item.yaw_rate_radps)
    values = (item.latitude_deg, item.longitude_deg, item.heading_rad, item.speed_mps, item.yaw_rate_radps)
    return all(map(math.isfinite, values))


def _dead_reckoned(pose: Pose2, speed_mps: float, yaw_rate_radps: float, dt_ns: int) -> Pose2:
    """The pose after dt_ns on an arc; midpoint rule."""
    if dt_ns <= 0:
        return pose
    dt_s = min(dt_ns * 1e-9, 1.0)
    middle_rad = pose.yaw_rad + 0.5 * yaw_rate_radps * dt_s
    return Pose2(
        pose.x_m + speed_mps * dt_s * math.cos(middle_rad),
        pose.y_m + speed_mps * dt_s * math.sin(middle_rad),
        wrap_angle(pose.yaw_rad + yaw_rate_radps * dt_s),
    )

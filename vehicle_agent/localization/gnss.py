"""Where the vehicle is: GNSS/INS fixes in the map frame, dead-reckoned between them (GEM, section II)."""

import math

import msgspec

from contract.geometry import Pose2, wrap_angle
from contract.roads.model import Origin
from contract.roads.projection import project
from vehicle_agent.signals import Ego, Fault, GnssFix, ImuSample, VehicleMotion
from vehicle_agent.signals.rates import POSE_AGE_NS_MAX

_NOWHERE = Pose2(0.0, 0.0, 0.0)


class LocalizationState(msgspec.Struct, frozen=True):
    """What localization remembers; `pose_map` is where the vehicle was at `stamp_ns`.

    strays        fixes in a row that fell far from the estimate
    senseless_ns  when a value last was no number, 0 never
    """

    stamp_ns: int = 0
    pose_map: Pose2 = _NOWHERE
    speed_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    accel_mps2: float = 0.0
    position_std_m: float = math.inf
    fix_stamp_ns: int = 0
    imu_stamp_ns: int = 0
    strays: int = 0
    jump_since_ns: int = 0
    senseless_ns: int = 0


class GnssLocalization(msgspec.Struct, frozen=True):
    """Fixed-gain observer: wheel speed and yaw rate carry the pose, each fix pulls it a little.

    gain_position, gain_heading  share of a fix's deviation that is taken over (0..1); at 50 fixes a second
                                 0.15 averages noise over about 0.13 s
    jump_m       a fix farther than this from the estimate is not believed at first
    strays_max   but when this many in a row say so, the estimate starts anew there, as a `pose_jump` fault
    """

    origin: Origin
    gain_position: float = 0.15
    gain_heading: float = 0.1
    jump_m: float = 1.0
    strays_max: int = 10
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
        poses: tuple[GnssFix | ImuSample, ...],
        now_ns: int,
    ) -> tuple[Ego, LocalizationState]:
        """The vehicle at `now_ns`. Fixes may be late: each is carried forward from its own stamp."""
        fixes = [item for item in poses if isinstance(item, GnssFix) and _is_finite(item)]
        samples = [item for item in poses if isinstance(item, ImuSample) and _is_finite(item)]
        if len(fixes) + len(samples) < len(poses):
            # Taken in once, a value that is no number would never leave the estimate again.
            state = msgspec.structs.replace(state, senseless_ns=now_ns)
        state = self._inertial(state, samples, fixes)
        speed_mps = state.speed_mps
        if motion.stamp_ns > 0:
            speed_mps = motion.speed_mps
        elif fixes:
            speed_mps = fixes[-1].speed_mps
        state = msgspec.structs.replace(
            state,
            stamp_ns=now_ns,
            pose_map=_carried(state.pose_map, speed_mps, state.yaw_rate_radps, now_ns - state.stamp_ns),
            speed_mps=speed_mps,
        )
        for fix in fixes:
            state = self._corrected(state, fix)
        return self._ego(state, motion), state

    def _inertial(
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

    def _corrected(self, state: LocalizationState, fix: GnssFix) -> LocalizationState:
        x_m, y_m = project(self.origin, fix.latitude_deg, fix.longitude_deg)
        seen = Pose2(x_m, y_m, wrap_angle(fix.heading_rad))
        measured = _carried(seen, state.speed_mps, state.yaw_rate_radps, state.stamp_ns - fix.stamp_ns)
        fresh = {"fix_stamp_ns": max(fix.stamp_ns, state.fix_stamp_ns), "position_std_m": fix.position_std_m}
        if state.fix_stamp_ns == 0:
            return msgspec.structs.replace(state, pose_map=measured, strays=0, **fresh)
        pose = state.pose_map
        dx_m, dy_m = measured.x_m - pose.x_m, measured.y_m - pose.y_m
        if math.hypot(dx_m, dy_m) > self.jump_m + 3.0 * fix.position_std_m:
            if state.strays + 1 < self.strays_max:
                return msgspec.structs.replace(state, strays=state.strays + 1)
            return msgspec.structs.replace(
                state, pose_map=measured, strays=0, jump_since_ns=state.stamp_ns, **fresh
            )
        pulled = Pose2(
            pose.x_m + self.gain_position * dx_m,
            pose.y_m + self.gain_position * dy_m,
            wrap_angle(pose.yaw_rad + self.gain_heading * wrap_angle(measured.yaw_rad - pose.yaw_rad)),
        )
        return msgspec.structs.replace(state, pose_map=pulled, strays=0, **fresh)

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
        found: list[Fault] = []
        if now_ns - state.fix_stamp_ns > self.age_ns_max:
            found.append(Fault("pose_stale", "stop", state.fix_stamp_ns))
        if not state.position_std_m <= self.position_std_m_max:
            found.append(Fault("pose_poor", "stop", state.fix_stamp_ns))
        if state.jump_since_ns and now_ns - state.jump_since_ns < self.jump_shown_ns:
            found.append(Fault("pose_jump", "stop", state.jump_since_ns))
        if state.senseless_ns and now_ns - state.senseless_ns < self.jump_shown_ns:
            found.append(Fault("pose_not_finite", "warning", state.senseless_ns))
        return tuple(found)


def _is_finite(item: GnssFix | ImuSample) -> bool:
    """position_std_m apart: infinite says that there is no solution, and is looked at elsewhere."""
    if isinstance(item, ImuSample):
        values = (item.accel_mps2, item.yaw_rate_radps)
        return all(map(math.isfinite, values))
    place = (item.latitude_deg, item.longitude_deg, item.heading_rad, item.speed_mps, item.yaw_rate_radps)
    return all(map(math.isfinite, place))


def _carried(pose: Pose2, speed_mps: float, yaw_rate_radps: float, dt_ns: int) -> Pose2:
    """The pose after dt on an arc; midpoint rule."""
    if dt_ns <= 0:
        return pose
    dt_s = min(dt_ns * 1e-9, 1.0)
    middle_rad = pose.yaw_rad + 0.5 * yaw_rate_radps * dt_s
    return Pose2(
        pose.x_m + speed_mps * dt_s * math.cos(middle_rad),
        pose.y_m + speed_mps * dt_s * math.sin(middle_rad),
        wrap_angle(pose.yaw_rad + yaw_rate_radps * dt_s),
    )

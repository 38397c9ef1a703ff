"""What control believes of the vehicle: pose, speed, actuators, and the loads and biases behind them."""

import math

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.control.actuators import (
    MBRAKE,
    MOVING_SIZE,
    MSPEED,
    MTHROTTLE,
    MWHEELS,
    MYAW,
    Drivetrain,
    carried,
    pedal_accel_mps2,
)
from vehicle_agent.control.mpc.lateral_model import Chassis, dynamic_share
from vehicle_agent.control.trajectory.pose_filter import (
    COMPLIANCE,
    STEER_BIAS,
    PoseFilter,
    PoseFilterState,
    fixed,
    placed,
    predicted,
    turned,
    unknown,
)
from vehicle_agent.signals import Ego, VehicleMotion


class ObserverState(msgspec.Struct, frozen=True):
    """moving (8,) see `actuators`: pose, actuators and speed now; rest_mps2: what acts beside the pedals.

    foreign_ns  when somebody else's brake was last reported
    """

    belief: PoseFilterState
    moving: Array
    rest_mps2: float = 0.0
    report_ns: int = 0
    foreign_ns: int = 0

    @property
    def speed_mps(self) -> float:
        return float(self.moving[MSPEED])

    @property
    def steer_bias_rad(self) -> float:
        return float(self.belief.mean[STEER_BIAS])

    @property
    def compliance(self) -> float:
        return float(self.belief.mean[COMPLIANCE])


class Observer(msgspec.Struct, frozen=True):
    """speed_gain, rest_gain_1ps  how much of a speed report's surprise goes to the speed, and to what acts
    beside the pedals; wheels_gain: how fast the reported wheel angle corrects the believed one, a tick
    rest_mps2_max  more is a fault of the vehicle's, not a load
    turn_mps_min   slower, a turn says nothing of the steering
    foreign_brake_ratio  a reported brake this far above ours is the guard's or the gate's; until
                   foreign_s after it, what the vehicle does says nothing of its load
    """

    drivetrain: Drivetrain = Drivetrain()
    chassis: Chassis = Chassis()
    filter: PoseFilter = PoseFilter()
    speed_gain: float = 0.15
    rest_gain_1ps: float = 0.2
    wheels_gain: float = 0.05
    rest_mps2_max: float = 1.5
    turn_mps_min: float = 0.1
    foreign_brake_ratio: float = 0.1
    foreign_s: float = 0.5
    dt_s: float = 0.02

    def initial(self) -> ObserverState:
        return ObserverState(unknown(), np.zeros(MOVING_SIZE))

    def step(
        self, state: ObserverState, ego: Ego, motion: VehicleMotion, commands: Array, standing: bool
    ) -> ObserverState:
        """One tick. commands (m, 3) of the ticks before this one; standing: the brake holds the vehicle.

        Values that are not finite are not taken; the belief then goes on by itself, and `blind_s` grows.
        """
        foreign_ns = ego.stamp_ns if self.is_braked_by_others(motion, commands) else state.foreign_ns
        loaded = foreign_ns == 0 or ego.stamp_ns - foreign_ns > self.foreign_s * 1e9
        moving, rest_mps2 = self._driven(state, motion, commands, standing, loaded)
        report_ns = max(state.report_ns, motion.stamp_ns)
        belief = self._placed(state.belief, ego, moving)
        moving[: MYAW + 1] = belief.mean[:3]
        return ObserverState(belief, moving, rest_mps2, report_ns, foreign_ns)

    def is_braked_by_others(self, motion: VehicleMotion, commands: Array) -> bool:
        """The reported brake is more than what was commanded lately, (m, 3), explains."""
        ours = max(float(commands[:, 2].max()), 0.0)
        return motion.enabled and motion.brake_ratio > ours + self.foreign_brake_ratio

    def turning(self, state: ObserverState) -> Array:
        """(4,) what `actuators.carried` must know of a turn."""
        share = state.compliance * dynamic_share(state.speed_mps)
        chassis = self.chassis
        return np.array(
            (
                state.steer_bias_rad,
                chassis.wheelbase_m,
                share * chassis.understeer_s2pm,
                share * chassis.rear_slip_per_mps2,
            )
        )

    def accel_mps2(self, moving: Array, rest_mps2: float) -> float:
        """What a moving vehicle (8,) accelerates by."""
        row = self.drivetrain.row()
        return rest_mps2 + float(pedal_accel_mps2(moving[MTHROTTLE], moving[MBRAKE], moving[MSPEED], row))

    def _driven(
        self, state: ObserverState, motion: VehicleMotion, commands: Array, standing: bool, loaded: bool
    ) -> tuple[Array, float]:
        """(moving, rest_mps2); loaded: the load may be learned from it."""
        moving, rest_mps2 = state.moving.copy(), state.rest_mps2
        steer_rad = motion.steer_rad if math.isfinite(motion.steer_rad) else float(moving[MWHEELS])
        if not motion.enabled:
            moving[MWHEELS], moving[MTHROTTLE], moving[MBRAKE] = (
                steer_rad,
                motion.throttle_ratio,
                motion.brake_ratio,
            )
            moving[MSPEED] = abs(motion.speed_mps) if math.isfinite(motion.speed_mps) else moving[MSPEED]
            return moving, 0.0
        carried(
            moving,
            commands,
            -self.dt_s,
            0.0,
            rest_mps2,
            self.turning(state),
            self.dt_s,
            self.drivetrain.row(),
        )
        moving[MWHEELS] += self.wheels_gain * (steer_rad - moving[MWHEELS])
        if not loaded and math.isfinite(motion.speed_mps):
            moving[MSPEED] = abs(motion.speed_mps)
        elif motion.stamp_ns > state.report_ns and math.isfinite(motion.speed_mps):
            surprise = motion.speed_mps - float(moving[MSPEED])
            moving[MSPEED] = max(0.0, moving[MSPEED] + self.speed_gain * surprise)
            if not standing:
                rest_mps2 += self.rest_gain_1ps * surprise
        if standing:
            moving[MSPEED] = abs(motion.speed_mps) if math.isfinite(motion.speed_mps) else 0.0
        return moving, min(max(rest_mps2, -self.rest_mps2_max), self.rest_mps2_max)

    def _placed(self, belief: PoseFilterState, ego: Ego, moving: Array) -> PoseFilterState:
        pose, n = ego.pose_map, self.filter.row()
        std_m = max(ego.position_std_m, self.filter.position_m_min)
        heading_std_rad = max(self.filter.heading_rad_per_m * ego.position_std_m, self.filter.heading_rad_min)
        usable = ego.valid and all(map(math.isfinite, (pose.x_m, pose.y_m, pose.yaw_rad, std_m)))
        dt_s = min(max((ego.stamp_ns - belief.stamp_ns) * 1e-9, 0.0), 0.1)
        if belief.fix_ns == 0:
            if not usable:
                return msgspec.structs.replace(belief, stamp_ns=ego.stamp_ns)
            return placed(belief, pose, std_m, heading_std_rad, ego.stamp_ns)
        mean, covariance = belief.mean.copy(), belief.covariance.copy()
        yaw_rate_radps = ego.yaw_rate_radps if math.isfinite(ego.yaw_rate_radps) else 0.0
        speed_mps, chassis = float(moving[MSPEED]), self.chassis
        share = dynamic_share(speed_mps)
        predicted(mean, covariance, speed_mps, yaw_rate_radps, dt_s, share * chassis.rear_slip_per_mps2, n)
        if speed_mps > self.turn_mps_min and math.isfinite(ego.yaw_rate_radps):
            turned(
                mean, covariance, speed_mps, yaw_rate_radps, float(moving[MWHEELS]),
                chassis.wheelbase_m, share * chassis.understeer_s2pm, n,
            )  # fmt: skip
        blind = PoseFilterState(
            mean, covariance, ego.stamp_ns, belief.fix_ns, belief.strays, belief.blind_s + dt_s
        )
        if not usable or ego.fix_stamp_ns <= belief.fix_ns:
            return blind
        if fixed(mean, covariance, pose.x_m, pose.y_m, pose.yaw_rad, std_m, heading_std_rad, n):
            return PoseFilterState(mean, covariance, ego.stamp_ns, ego.fix_stamp_ns)
        if belief.strays + 1 < self.filter.strays_max:
            return msgspec.structs.replace(blind, strays=belief.strays + 1, fix_ns=ego.fix_stamp_ns)
        return placed(blind, pose, std_m, heading_std_rad, ego.stamp_ns)

"""Control's estimate of the vehicle: pose, speed, actuators, disturbance and biases."""

import math

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.control.actuators import (
    MBRAKE,
    MSPEED,
    MTHROTTLE,
    MWHEELS,
    MYAW,
    VEHICLE_SIZE,
    Drivetrain,
    pedal_accel_mps2,
    propagate,
)
from vehicle_agent.control.learned_bounds import AT_BOUND_SHARE
from vehicle_agent.control.mpc.lateral_model import Chassis, dynamic_share
from vehicle_agent.control.trajectory.pose_filter import (
    COMPLIANCE,
    STEER_BIAS,
    PoseFilter,
    PoseFilterState,
    initial_filter_state,
    predict,
    reset_at,
    update_pose,
    update_yaw_rate,
)
from vehicle_agent.signals import Ego, VehicleMotion


class ObserverState(msgspec.Struct, frozen=True):
    """What the observer remembers.

    vehicle            (8,) see `actuators`: pose, actuators and speed now
    disturbance_mps2   acceleration that the pedals do not explain
    external_brake_ns  when a brake of the guard or the gate was last reported
    """

    pose_estimate: PoseFilterState
    vehicle: Array
    disturbance_mps2: float = 0.0
    report_ns: int = 0
    external_brake_ns: int = 0

    @property
    def speed_mps(self) -> float:
        return float(self.vehicle[MSPEED])

    @property
    def steer_bias_rad(self) -> float:
        return float(self.pose_estimate.mean[STEER_BIAS])

    @property
    def compliance(self) -> float:
        return float(self.pose_estimate.mean[COMPLIANCE])


class Observer(msgspec.Struct, frozen=True):
    """speed_gain, disturbance_gain_1ps  share of a speed report's innovation for the speed and for the
                         disturbance
    wheels_gain           share of the reported wheel angle's deviation that corrects the estimate, a tick
    disturbance_mps2_max  a larger one is a fault of the vehicle, not a load
    turn_mps_min          slower, the yaw rate is not used for the steering bias
    external_brake_ratio  a reported brake this far above the command is the guard's or the gate's; until
                          external_brake_s after it the disturbance is not learned
    steer_bias_rad        of the profile; the filter begins with it
    """

    drivetrain: Drivetrain = Drivetrain()
    chassis: Chassis = Chassis()
    filter: PoseFilter = PoseFilter()
    speed_gain: float = 0.15
    disturbance_gain_1ps: float = 0.2
    wheels_gain: float = 0.05
    disturbance_mps2_max: float = 1.5
    turn_mps_min: float = 0.1
    external_brake_ratio: float = 0.1
    external_brake_s: float = 0.5
    steer_bias_rad: float = 0.0
    dt_s: float = 0.02

    def initial(self) -> ObserverState:
        return ObserverState(initial_filter_state(self.steer_bias_rad), np.zeros(VEHICLE_SIZE))

    def step(
        self, state: ObserverState, ego: Ego, motion: VehicleMotion, commands: Array, standing: bool
    ) -> ObserverState:
        """The estimate of this tick. commands (m, 3) of earlier ticks; standing: the brake holds the vehicle.

        Values that are not finite are ignored. The estimate is then propagated, and `no_pose_s` grows.
        """
        external_brake_ns = (
            ego.stamp_ns if self.is_braked_externally(motion, commands) else state.external_brake_ns
        )
        may_learn = external_brake_ns == 0 or ego.stamp_ns - external_brake_ns > self.external_brake_s * 1e9
        vehicle, disturbance_mps2 = self._propagated(state, motion, commands, standing, may_learn)
        report_ns = max(state.report_ns, motion.stamp_ns)
        pose_estimate = self._located(state.pose_estimate, ego, vehicle)
        vehicle[: MYAW + 1] = pose_estimate.mean[:3]
        return ObserverState(pose_estimate, vehicle, disturbance_mps2, report_ns, external_brake_ns)

    def is_braked_externally(self, motion: VehicleMotion, commands: Array) -> bool:
        """The reported brake is more than the recent commands (m, 3) explain."""
        commanded = max(float(commands[:, 2].max()), 0.0)
        return motion.enabled and motion.brake_ratio > commanded + self.external_brake_ratio

    def begun_again(self, state: ObserverState) -> ObserverState:
        """Without what was learned: pose, biases and disturbance are estimated afresh."""
        return msgspec.structs.replace(
            state, pose_estimate=initial_filter_state(self.steer_bias_rad), disturbance_mps2=0.0
        )

    def is_steering_at_bound(self, state: ObserverState) -> bool:
        return abs(state.steer_bias_rad) >= AT_BOUND_SHARE * self.filter.steer_bias_rad_max

    def is_disturbance_at_bound(self, state: ObserverState) -> bool:
        return abs(state.disturbance_mps2) >= AT_BOUND_SHARE * self.disturbance_mps2_max

    def turn_params(self, state: ObserverState) -> Array:
        """(4,) the turn parameters of `actuators.propagate`."""
        dynamic = state.compliance * dynamic_share(state.speed_mps)
        chassis = self.chassis
        return np.array(
            (
                state.steer_bias_rad,
                chassis.wheelbase_m,
                dynamic * chassis.understeer_s2pm,
                dynamic * chassis.rear_slip_per_mps2,
            )
        )

    def accel_mps2(self, vehicle: Array, disturbance_mps2: float) -> float:
        """The acceleration of a vehicle (8,)."""
        row = self.drivetrain.row()
        return disturbance_mps2 + float(
            pedal_accel_mps2(vehicle[MTHROTTLE], vehicle[MBRAKE], vehicle[MSPEED], row)
        )

    def _propagated(
        self, state: ObserverState, motion: VehicleMotion, commands: Array, standing: bool, may_learn: bool
    ) -> tuple[Array, float]:
        """(vehicle, disturbance_mps2); may_learn: the disturbance is corrected by the speed report."""
        vehicle, disturbance_mps2 = state.vehicle.copy(), state.disturbance_mps2
        steer_rad = motion.steer_rad if math.isfinite(motion.steer_rad) else float(vehicle[MWHEELS])
        if not motion.enabled:
            vehicle[MWHEELS], vehicle[MTHROTTLE], vehicle[MBRAKE] = (
                steer_rad,
                motion.throttle_ratio,
                motion.brake_ratio,
            )
            vehicle[MSPEED] = abs(motion.speed_mps) if math.isfinite(motion.speed_mps) else vehicle[MSPEED]
            return vehicle, 0.0
        propagate(
            vehicle,
            commands,
            -self.dt_s,
            0.0,
            disturbance_mps2,
            self.turn_params(state),
            self.dt_s,
            self.drivetrain.row(),
        )
        vehicle[MWHEELS] += self.wheels_gain * (steer_rad - vehicle[MWHEELS])
        if not may_learn and math.isfinite(motion.speed_mps):
            vehicle[MSPEED] = abs(motion.speed_mps)
        elif motion.stamp_ns > state.report_ns and math.isfinite(motion.speed_mps):
            innovation = motion.speed_mps - float(vehicle[MSPEED])
            vehicle[MSPEED] = max(0.0, vehicle[MSPEED] + self.speed_gain * innovation)
            if not standing:
                disturbance_mps2 += self.disturbance_gain_1ps * innovation
        if standing:
            vehicle[MSPEED] = abs(motion.speed_mps) if math.isfinite(motion.speed_mps) else 0.0
        return vehicle, min(max(disturbance_mps2, -self.disturbance_mps2_max), self.disturbance_mps2_max)

    def _located(self, pose_estimate: PoseFilterState, ego: Ego, vehicle: Array) -> PoseFilterState:
        pose, n = ego.pose_map, self.filter.row()
        std_m = max(ego.position_std_m, self.filter.position_m_min)
        heading_std_rad = max(self.filter.heading_rad_per_m * ego.position_std_m, self.filter.heading_rad_min)
        usable = ego.valid and all(map(math.isfinite, (pose.x_m, pose.y_m, pose.yaw_rad, std_m)))
        dt_s = min(max((ego.stamp_ns - pose_estimate.stamp_ns) * 1e-9, 0.0), 0.1)
        if pose_estimate.fix_ns == 0:
            if not usable:
                return msgspec.structs.replace(pose_estimate, stamp_ns=ego.stamp_ns)
            return reset_at(pose_estimate, pose, std_m, heading_std_rad, ego.stamp_ns)
        mean, covariance = pose_estimate.mean.copy(), pose_estimate.covariance.copy()
        yaw_rate_radps = ego.yaw_rate_radps if math.isfinite(ego.yaw_rate_radps) else 0.0
        speed_mps, chassis = float(vehicle[MSPEED]), self.chassis
        dynamic = dynamic_share(speed_mps)
        predict(mean, covariance, speed_mps, yaw_rate_radps, dt_s, dynamic * chassis.rear_slip_per_mps2, n)
        if speed_mps > self.turn_mps_min and math.isfinite(ego.yaw_rate_radps):
            update_yaw_rate(
                mean, covariance, speed_mps, yaw_rate_radps, float(vehicle[MWHEELS]),
                chassis.wheelbase_m, dynamic * chassis.understeer_s2pm, n,
            )  # fmt: skip
        unfixed = PoseFilterState(
            mean,
            covariance,
            ego.stamp_ns,
            pose_estimate.fix_ns,
            pose_estimate.outliers,
            pose_estimate.no_pose_s + dt_s,
        )
        if not usable or ego.pose_stamp_ns <= pose_estimate.fix_ns:
            return unfixed
        if update_pose(mean, covariance, pose.x_m, pose.y_m, pose.yaw_rad, std_m, heading_std_rad, n):
            return PoseFilterState(mean, covariance, ego.stamp_ns, ego.pose_stamp_ns)
        if pose_estimate.outliers + 1 < self.filter.outliers_max:
            return msgspec.structs.replace(
                unfixed, outliers=pose_estimate.outliers + 1, fix_ns=ego.pose_stamp_ns
            )
        return reset_at(unfixed, pose, std_m, heading_std_rad, ego.stamp_ns)

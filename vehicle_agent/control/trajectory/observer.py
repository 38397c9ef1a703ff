"""Control's estimate of the vehicle: pose, speed, actuators, pedals and biases."""

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
from vehicle_agent.control.trajectory.pedal_filter import (
    PedalFilter,
    PedalFilterState,
    initial_pedal_state,
    predict_speed,
    update_speed,
    with_known_speed,
    without_disturbance,
)
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
    pedals             strength of the pedals, and the acceleration that they do not explain
    external_brake_ns  when a brake of the guard or the gate was last reported
    """

    pose_estimate: PoseFilterState
    vehicle: Array
    pedals: PedalFilterState
    report_ns: int = 0
    external_brake_ns: int = 0

    @property
    def speed_mps(self) -> float:
        return float(self.vehicle[MSPEED])

    @property
    def disturbance_mps2(self) -> float:
        return self.pedals.disturbance_mps2

    @property
    def steer_bias_rad(self) -> float:
        return float(self.pose_estimate.mean[STEER_BIAS])

    @property
    def compliance(self) -> float:
        return float(self.pose_estimate.mean[COMPLIANCE])


class Observer(msgspec.Struct, frozen=True):
    """wheels_gain           share of the reported wheel angle's deviation that corrects the estimate, a tick
    turn_mps_min          slower, the yaw rate is not used for the steering bias
    roll_mps_min          slower, what the vehicle does says more of its friction than of its pedals
    external_brake_ratio  a reported brake this far above the command is the guard's or the gate's; until
                          external_brake_s after it nothing is learned of the pedals
    steer_bias_rad        of the profile; the filter begins with it
    """

    drivetrain: Drivetrain = Drivetrain()
    chassis: Chassis = Chassis()
    filter: PoseFilter = PoseFilter()
    pedal_filter: PedalFilter = PedalFilter()
    wheels_gain: float = 0.05
    turn_mps_min: float = 0.1
    roll_mps_min: float = 0.1
    external_brake_ratio: float = 0.1
    external_brake_s: float = 0.5
    steer_bias_rad: float = 0.0
    dt_s: float = 0.02

    def initial(self) -> ObserverState:
        return ObserverState(
            initial_filter_state(self.steer_bias_rad),
            np.zeros(VEHICLE_SIZE),
            initial_pedal_state(self.pedal_filter),
        )

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
        vehicle, pedals = self._propagated(state, motion, commands, standing, may_learn)
        report_ns = max(state.report_ns, motion.stamp_ns)
        pose_estimate = self._located(state.pose_estimate, ego, vehicle)
        vehicle[: MYAW + 1] = pose_estimate.mean[:3]
        return ObserverState(pose_estimate, vehicle, pedals, report_ns, external_brake_ns)

    def is_braked_externally(self, motion: VehicleMotion, commands: Array) -> bool:
        """The reported brake is more than the recent commands (m, 3) explain."""
        commanded = max(float(commands[:, 2].max()), 0.0)
        return motion.enabled and motion.brake_ratio > commanded + self.external_brake_ratio

    def begun_again(self, state: ObserverState) -> ObserverState:
        """Without what was learned: pose, biases and pedals are estimated afresh."""
        return msgspec.structs.replace(
            state,
            pose_estimate=initial_filter_state(self.steer_bias_rad),
            pedals=initial_pedal_state(self.pedal_filter),
        )

    def is_steering_at_bound(self, state: ObserverState) -> bool:
        return abs(state.steer_bias_rad) >= AT_BOUND_SHARE * self.filter.steer_bias_rad_max

    def are_pedals_at_bound(self, state: ObserverState) -> bool:
        limits, pedals = self.pedal_filter, state.pedals
        gains = pedals.drive_gain, pedals.brake_gain
        return (
            abs(pedals.disturbance_mps2) >= AT_BOUND_SHARE * limits.disturbance_mps2_max
            or min(gains) * AT_BOUND_SHARE <= limits.gain_min
            or max(gains) >= AT_BOUND_SHARE * limits.gain_max
        )

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

    def learned_drivetrain(self, state: ObserverState) -> Drivetrain:
        """The identified response with the strength that was learned of its pedals."""
        return self.drivetrain.with_gains(state.pedals.drive_gain, state.pedals.brake_gain)

    def _propagated(
        self, state: ObserverState, motion: VehicleMotion, commands: Array, standing: bool, may_learn: bool
    ) -> tuple[Array, PedalFilterState]:
        """(vehicle, pedals); may_learn: the pedals are corrected by the speed report."""
        vehicle = state.vehicle.copy()
        steer_rad = motion.steer_rad if math.isfinite(motion.steer_rad) else float(vehicle[MWHEELS])
        if not motion.enabled:
            vehicle[MWHEELS], vehicle[MTHROTTLE], vehicle[MBRAKE] = (
                steer_rad,
                motion.throttle_ratio,
                motion.brake_ratio,
            )
            vehicle[MSPEED] = abs(motion.speed_mps) if math.isfinite(motion.speed_mps) else vehicle[MSPEED]
            return vehicle, without_disturbance(state.pedals, self.pedal_filter)
        propagate(
            vehicle,
            commands,
            -self.dt_s,
            0.0,
            state.disturbance_mps2,
            self.turn_params(state),
            self.dt_s,
            self.learned_drivetrain(state).row(),
        )
        vehicle[MWHEELS] += self.wheels_gain * (steer_rad - vehicle[MWHEELS])
        has_speed = math.isfinite(motion.speed_mps)
        if standing or (has_speed and not may_learn):
            vehicle[MSPEED] = abs(motion.speed_mps) if has_speed else 0.0
            return vehicle, with_known_speed(state.pedals)
        is_new = has_speed and motion.stamp_ns > state.report_ns
        return vehicle, self._learned_pedals(state.pedals, vehicle, motion.speed_mps if is_new else math.nan)

    def _learned_pedals(self, pedals: PedalFilterState, vehicle: Array, speed_mps: float) -> PedalFilterState:
        """The pedals after this tick; the speed of the vehicle (8,) is corrected in place.

        speed_mps  as reported, nan without a new report
        """
        mean, covariance, n = pedals.mean.copy(), pedals.covariance.copy(), self.pedal_filter.row()
        row = self.drivetrain.row()
        speed, throttle, brake = float(vehicle[MSPEED]), float(vehicle[MTHROTTLE]), float(vehicle[MBRAKE])
        coasting_mps2 = pedal_accel_mps2(0.0, 0.0, speed, row)
        drive_mps2 = pedal_accel_mps2(throttle, 0.0, speed, row) - coasting_mps2
        brake_mps2 = coasting_mps2 - pedal_accel_mps2(0.0, brake, speed, row)
        rolls = speed > self.roll_mps_min
        predict_speed(covariance, drive_mps2 * rolls, brake_mps2 * rolls, self.dt_s, n)
        if math.isfinite(speed_mps):
            corrected_mps = speed + update_speed(mean, covariance, speed_mps - speed, n)
            vehicle[MSPEED] = max(0.0, corrected_mps)
        return PedalFilterState(mean, covariance)

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

"""The GEM stack's control: waypoint follower and twist controller."""

import math

import msgspec
import numpy as np

from contract.geometry import Pose2
from vehicle_agent.control.learned_bounds import LearnedBounds, LearnedBoundsState
from vehicle_agent.control.waypoint.brake_gain import BrakeGain, BrakeGainState
from vehicle_agent.control.waypoint.follower import FollowerState, WaypointFollower, predicted_pose
from vehicle_agent.control.waypoint.pure_pursuit import PurePursuit
from vehicle_agent.control.waypoint.rear_slip import RearSlip, RearSlipState
from vehicle_agent.control.waypoint.steering import BicycleSteering
from vehicle_agent.control.waypoint.steering_trim import SteeringTrim
from vehicle_agent.control.waypoint.twist import TwistController, TwistState
from vehicle_agent.signals import ControlCommand, Ego, Path, VehicleMotion


class WaypointControlState(msgspec.Struct, frozen=True):
    """What control remembers.

    steers_rad (k,)  the last commands, oldest first, not yet executed
    trim_rad         the wheels stand this far to the left of the command
    slip             None without `WaypointControl.slip`
    """

    steers_rad: np.ndarray
    follower: FollowerState = FollowerState()
    pedals: TwistState = TwistState()
    trim_rad: float = 0.0
    slip: RearSlipState | None = None
    brake_gain: BrakeGainState = BrakeGainState()
    bounds: LearnedBoundsState = LearnedBoundsState()


class WaypointControl(msgspec.Struct, frozen=True):
    """Follower, steering and twist controller.

    trim                  None: no correction of the wheel angle
    brake_gain            None: the brake map is never corrected
    slip                  None: the vehicle is taken to move where it points
    steer_delay_s         from a steering command to the wheels; the follower uses the pose at that time
    released_brake_ratio  above this reported brake a standing vehicle is held
    """

    follower: WaypointFollower | PurePursuit = WaypointFollower()
    steering: BicycleSteering = BicycleSteering()
    twist: TwistController = TwistController()
    trim: SteeringTrim | None = SteeringTrim()
    slip: RearSlip | None = None
    brake_gain: BrakeGain | None = None
    steer_delay_s: float = 0.25
    released_brake_ratio: float = 0.2
    bounds: LearnedBounds = LearnedBounds()
    dt_s: float = 0.02

    def initial(self) -> WaypointControlState:
        trim_rad = 0.0 if self.trim is None else self.trim.initial_rad
        return WaypointControlState(
            np.zeros(max(1, round(self.steer_delay_s / self.dt_s))),
            trim_rad=trim_rad,
            slip=None if self.slip is None else self.slip.initial(),
        )

    def step(
        self, state: WaypointControlState, ego: Ego, path: Path, motion: VehicleMotion
    ) -> tuple[ControlCommand, WaypointControlState]:
        """The command that follows the path at its speed. Without by-wire the state follows the reports."""
        brake_gain = state.brake_gain
        if self.brake_gain is not None and motion.enabled:
            before = state.pedals
            brake_gain = self.brake_gain.step(
                brake_gain, before.accel_command_mps2, before.brake_ratio, ego, motion
            )
        if not motion.enabled:
            steers_rad = np.full_like(state.steers_rad, motion.steer_rad)
            state = msgspec.structs.replace(
                state, steers_rad=steers_rad, follower=FollowerState(), pedals=TwistState()
            )
        elif path.speed_mps > 0.0 and self._is_held(ego, motion):
            state = msgspec.structs.replace(state, pedals=TwistState())
        trim_rad = 0.0 if self.trim is None else self.trim.step(state.trim_rad, ego, motion)
        bounds, begins_again = self.bounds.step(
            state.bounds,
            self.trim is not None and self.trim.is_at_bound(trim_rad),
            self.brake_gain is not None and self.brake_gain.is_at_bound(brake_gain),
            ego,
            motion,
        )
        if begins_again:
            trim_rad, brake_gain = self.initial().trim_rad, BrakeGainState()
        if path.emergency:
            pedals = self.twist.full_stop()
        else:
            pedals = self.twist.step(
                state.pedals,
                path.speed_mps,
                path.accel_mps2,
                ego.speed_mps,
                ego.accel_mps2,
                brake_gain.share,
            )
        before_rad = float(state.steers_rad[-1])
        pending_steers_rad = state.steers_rad if self.steer_delay_s > 0.0 else state.steers_rad[:0]
        slip = state.slip if self.slip is None or state.slip is None else self.slip.step(state.slip, ego)
        pose_map = predicted_pose(
            self._course_pose(slip, ego),
            ego.speed_mps,
            pending_steers_rad + trim_rad,
            self.steering.wheelbase_m,
            self.dt_s,
        )
        speed_mps = max(ego.speed_mps, self.steering.speed_mps_min)
        turn_radps, error_rad, follower = self.follower.step(
            state.follower, pose_map, speed_mps, path.points_map
        )
        steer_rad = self.steering.steer_rad(turn_radps, speed_mps, before_rad, trim_rad)
        if len(path.points_map) == 0:
            steer_rad = before_rad
        command = ControlCommand(
            steer_rad=steer_rad,
            throttle_ratio=pedals.throttle_ratio,
            brake_ratio=pedals.brake_ratio,
            accel_mps2=pedals.accel_command_mps2,
            diagnostics=(
                ("heading_error_rad", error_rad),
                ("steer_trim_rad", trim_rad),
                (
                    "rear_slip_per_mps2",
                    0.0 if self.slip is None or slip is None else self.slip.per_mps2(slip),
                ),
                ("brake_share", brake_gain.share),
                ("turn_command_radps", turn_radps),
                ("accel_filtered_mps2", pedals.accel_filtered_mps2),
                ("throttle_integral", pedals.integral_ratio),
            ),
            faults=bounds.faults,
        )
        return command, WaypointControlState(
            np.append(state.steers_rad[1:], steer_rad), follower, pedals, trim_rad, slip, brake_gain, bounds
        )

    def _course_pose(self, slip: RearSlipState | None, ego: Ego) -> Pose2:
        """The pose with the direction of motion in place of the heading."""
        pose = ego.pose_map
        if self.slip is None or slip is None or not math.isfinite(ego.yaw_rate_radps):
            return pose
        course_rad = self.slip.course_rad(slip, pose.yaw_rad, ego.speed_mps, ego.yaw_rate_radps)
        return Pose2(pose.x_m, pose.y_m, course_rad)

    def _is_held(self, ego: Ego, motion: VehicleMotion) -> bool:
        """The brake holds the vehicle, the guard's perhaps, for minutes.

        Throttle that winds up meanwhile would make the vehicle leap when the brake is released.
        """
        return ego.speed_mps < self.twist.hold_below_mps and motion.brake_ratio > self.released_brake_ratio

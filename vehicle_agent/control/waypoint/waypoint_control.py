"""The GEM stack's control: waypoint follower and twist controller behind one door."""

import msgspec
import numpy as np

from vehicle_agent.control.waypoint.follower import FollowerState, WaypointFollower, led_pose
from vehicle_agent.control.waypoint.pure_pursuit import PurePursuit
from vehicle_agent.control.waypoint.steering import BicycleSteering
from vehicle_agent.control.waypoint.steering_trim import SteeringTrim
from vehicle_agent.control.waypoint.twist import TwistController, TwistState
from vehicle_agent.signals import ControlCommand, Ego, Path, VehicleMotion


class WaypointControlState(msgspec.Struct, frozen=True):
    """What control remembers; steers_rad (k,) are the last commands, oldest first, not yet carried out.

    trim_rad: the wheels stand so far to the left of what was commanded
    """

    steers_rad: np.ndarray
    aim: FollowerState = FollowerState()
    pedals: TwistState = TwistState()
    trim_rad: float = 0.0


class WaypointControl(msgspec.Struct, frozen=True):
    """steer_delay_s: from a steering command to the wheels; the follower aims from where it will be then.

    trim: None: the wheels are taken to stand as they are told
    released_brake_ratio: a reported brake below this lets the standing vehicle start
    """

    follower: WaypointFollower | PurePursuit = WaypointFollower()
    steering: BicycleSteering = BicycleSteering()
    twist: TwistController = TwistController()
    trim: SteeringTrim | None = SteeringTrim()
    steer_delay_s: float = 0.25
    released_brake_ratio: float = 0.2
    dt_s: float = 0.02

    def initial(self) -> WaypointControlState:
        return WaypointControlState(np.zeros(max(1, round(self.steer_delay_s / self.dt_s))))

    def step(
        self, state: WaypointControlState, ego: Ego, path: Path, motion: VehicleMotion
    ) -> tuple[ControlCommand, WaypointControlState]:
        """Follow the path's waypoints at its speed. Without by-wire the memory starts from what is."""
        if not motion.enabled:
            state = WaypointControlState(
                np.full_like(state.steers_rad, motion.steer_rad), trim_rad=state.trim_rad
            )
        elif path.speed_mps > 0.0 and self._is_held(ego, motion):
            state = WaypointControlState(state.steers_rad, state.aim, trim_rad=state.trim_rad)
        trim_rad = 0.0 if self.trim is None else self.trim.step(state.trim_rad, ego, motion)
        if path.emergency:
            pedals = self.twist.full_stop()
        else:
            pedals = self.twist.step(
                state.pedals, path.speed_mps, path.accel_mps2, ego.speed_mps, ego.accel_mps2
            )
        before_rad = float(state.steers_rad[-1])
        pending = state.steers_rad if self.steer_delay_s > 0.0 else state.steers_rad[:0]
        pose_map = led_pose(
            ego.pose_map, ego.speed_mps, pending + trim_rad, self.steering.wheelbase_m, self.dt_s
        )
        speed_mps = max(ego.speed_mps, self.steering.speed_mps_min)
        turn_radps, error_rad, aim = self.follower.step(state.aim, pose_map, speed_mps, path.points_map)
        steer_rad = self.steering.steer_rad(turn_radps, speed_mps, before_rad, trim_rad)
        if len(path.points_map) == 0:
            steer_rad = before_rad
        wish = ControlCommand(
            steer_rad=steer_rad,
            throttle_ratio=pedals.throttle_ratio,
            brake_ratio=pedals.brake_ratio,
            accel_mps2=pedals.accel_command_mps2,
            diagnostics=(
                ("heading_error_rad", error_rad),
                ("steer_trim_rad", trim_rad),
                ("turn_command_radps", turn_radps),
                ("accel_filtered_mps2", pedals.accel_filtered_mps2),
                ("throttle_integral", pedals.integral_ratio),
            ),
        )
        return wish, WaypointControlState(np.append(state.steers_rad[1:], steer_rad), aim, pedals, trim_rad)

    def _is_held(self, ego: Ego, motion: VehicleMotion) -> bool:
        """The brake keeps the vehicle standing: the guard's perhaps, for minutes. Throttle that were wound
        up against it meanwhile would make the vehicle leap forward once it is let go."""
        return ego.speed_mps < self.twist.hold_below_mps and motion.brake_ratio > self.released_brake_ratio

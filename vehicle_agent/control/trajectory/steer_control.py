"""The lateral half: the wheel angle, from the pose at which a command takes effect."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, wrap_angle
from vehicle_agent.control.actuators import MS, MSPEED, MWHEELS, MX, MY, MYAW, propagate
from vehicle_agent.control.mpc.axis import WarmStart, cold_start
from vehicle_agent.control.mpc.lateral import LateralMpc, LateralStart
from vehicle_agent.control.trajectory.observer import Observer, ObserverState
from vehicle_agent.control.trajectory.timed_path import at_length, curvatures_ahead, nearest


class SteerControlState(msgspec.Struct, frozen=True):
    command_rad: float
    warm_start: WarmStart


class SteerControlResult(msgspec.Struct, frozen=True):
    """offset_m, heading_rad: errors of the rear axle when the command takes effect."""

    state: SteerControlState
    offset_m: float
    heading_rad: float
    bounded: bool
    feasible: bool
    iterations: int


class SteerControl(msgspec.Struct, frozen=True):
    """ease_radps  rate at which the wheels go straight without a path
    search_m       the vehicle is located within this distance along the trajectory
    still_mps      slower, the wheels are not turned, since that would wear the tyres
    """

    mpc: LateralMpc = LateralMpc()
    ease_radps: float = 0.1
    search_m: float = 6.0
    still_mps: float = 0.02
    dt_s: float = 0.02

    def initial(self) -> SteerControlState:
        return SteerControlState(0.0, cold_start(self.mpc.steps))

    def step(
        self, state: SteerControlState, estimate: ObserverState, observer: Observer,
        commands: Array, rows: Array, s: Array, own_s_m: float, speeds_mps: Array, speeds_lead_s: float,
    ) -> SteerControlResult:  # fmt: skip
        """The steering of this tick; speeds_mps (N + 1,) expected from speeds_lead_s after now on."""
        vehicle = estimate.vehicle.copy()
        vehicle[MS] = own_s_m
        delay_s, turn_params = observer.drivetrain.steer_delay_s, observer.turn_params(estimate)
        propagate(
            vehicle,
            commands,
            0.0,
            delay_s,
            estimate.disturbance_mps2,
            turn_params,
            self.dt_s,
            observer.learned_drivetrain(estimate).row(),
        )
        s_m, offset_m = nearest(rows, s, vehicle[MX], vehicle[MY], vehicle[MS], self.search_m)
        yaw_rad, curvature_1pm = at_length(rows, s, s_m)
        heading_rad = float(wrap_angle(vehicle[MYAW] - yaw_rad))
        speed_mps = float(vehicle[MSPEED])
        if speed_mps < self.still_mps and float(speeds_mps[: self.mpc.steps // 4].max()) < self.still_mps:
            return SteerControlResult(state, offset_m, heading_rad, False, True, 0)
        wheels_rad = float(vehicle[MWHEELS])
        bias_rad, wheelbase_m, understeer, slip = turn_params.tolist()
        turn_radps = speed_mps * math.tan(wheels_rad + bias_rad) / (wheelbase_m + understeer * speed_mps**2)
        course_rad = heading_rad - slip * speed_mps * turn_radps
        times_s = delay_s - speeds_lead_s + self.mpc.dt_s * np.arange(self.mpc.steps + 1)
        speed_times_s = self.mpc.dt_s * np.arange(len(speeds_mps))
        ahead_mps = np.interp(times_s, speed_times_s, speeds_mps)
        start = LateralStart(
            offset_m,
            speed_mps * math.sin(course_rad),
            heading_rad,
            turn_radps - speed_mps * curvature_1pm,
            wheels_rad,
            state.command_rad,
        )
        solution = self.mpc.solve(
            start,
            bias_rad,
            estimate.compliance,
            ahead_mps,
            curvatures_ahead(rows, s, s_m, ahead_mps, self.mpc.dt_s),
            state.warm_start,
        )
        return SteerControlResult(
            SteerControlState(
                self.mpc.next_command_rad(state.command_rad, bias_rad, float(solution.inputs[0]), self.dt_s),
                solution.warm_start,
            ),
            offset_m, heading_rad, solution.bounded, solution.feasible, solution.iterations,
        )  # fmt: skip

    def ease_straight(self, state: SteerControlState) -> SteerControlState:
        """The state without a path: wheels eased straight."""
        reach = self.ease_radps * self.dt_s
        steer_rad = state.command_rad - min(max(state.command_rad, -reach), reach)
        return SteerControlState(steer_rad, cold_start(self.mpc.steps))

"""The lateral half: from where the vehicle will be when a command takes effect to the wheels."""

import math

import msgspec
import numpy as np

from contract.geometry import Array, wrap_angle
from vehicle_agent.control.actuators import MS, MSPEED, MWHEELS, MX, MY, MYAW, carried
from vehicle_agent.control.mpc.axis import WarmStart, no_guess
from vehicle_agent.control.mpc.lateral import LateralMpc, LateralStart
from vehicle_agent.control.trajectory.observer import Observer, ObserverState
from vehicle_agent.control.trajectory.timed_path import at_length, bends, nearest


class SteerControlState(msgspec.Struct, frozen=True):
    command_rad: float
    guess: WarmStart


class SteerControlResult(msgspec.Struct, frozen=True):
    """offset_m, heading_rad: of the rear axle, when the command takes effect."""

    state: SteerControlState
    offset_m: float
    heading_rad: float
    bounded: bool
    feasible: bool
    iterations: int


class SteerControl(msgspec.Struct, frozen=True):
    """ease_radps  how fast the wheels go straight where there is nothing to follow
    search_m       how far along the trajectory the vehicle is looked for
    still_mps      slower, the wheels are left as they are: turning them would only wear the tyres
    """

    mpc: LateralMpc = LateralMpc()
    ease_radps: float = 0.1
    search_m: float = 6.0
    still_mps: float = 0.02
    dt_s: float = 0.02

    def initial(self) -> SteerControlState:
        return SteerControlState(0.0, no_guess(self.mpc.steps))

    def step(
        self, state: SteerControlState, seen: ObserverState, observer: Observer,
        commands: Array, rows: Array, s: Array, own_s_m: float, speeds_mps: Array, speeds_lead_s: float,
    ) -> SteerControlResult:  # fmt: skip
        """One tick; speeds_mps (N + 1,) expected from speeds_lead_s after now on."""
        moving = seen.moving.copy()
        moving[MS] = own_s_m
        delay_s, turning = observer.drivetrain.steer_delay_s, observer.turning(seen)
        carried(moving, commands, 0.0, delay_s, seen.rest_mps2, turning, self.dt_s, observer.drivetrain.row())
        s_m, offset_m = nearest(rows, s, moving[MX], moving[MY], moving[MS], self.search_m)
        yaw_rad, curvature_1pm = at_length(rows, s, s_m)
        heading_rad = float(wrap_angle(moving[MYAW] - yaw_rad))
        speed_mps = float(moving[MSPEED])
        if speed_mps < self.still_mps and float(speeds_mps[: self.mpc.steps // 4].max()) < self.still_mps:
            return SteerControlResult(state, offset_m, heading_rad, False, True, 0)
        wheels_rad = float(moving[MWHEELS])
        bias_rad, wheelbase_m, understeer, slip = turning.tolist()
        turn_radps = speed_mps * math.tan(wheels_rad + bias_rad) / (wheelbase_m + understeer * speed_mps**2)
        course_rad = heading_rad - slip * speed_mps * turn_radps
        times_s = delay_s - speeds_lead_s + self.mpc.dt_s * np.arange(self.mpc.steps + 1)
        known_s = self.mpc.dt_s * np.arange(len(speeds_mps))
        ahead_mps = np.interp(times_s, known_s, speeds_mps)
        start = LateralStart(
            offset_m,
            speed_mps * math.sin(course_rad),
            heading_rad,
            turn_radps - speed_mps * curvature_1pm,
            wheels_rad,
            state.command_rad,
        )
        answer = self.mpc.solve(
            start,
            bias_rad,
            seen.compliance,
            ahead_mps,
            bends(rows, s, s_m, ahead_mps, self.mpc.dt_s),
            state.guess,
        )
        return SteerControlResult(
            SteerControlState(
                self.mpc.turned_rad(state.command_rad, bias_rad, float(answer.inputs[0]), self.dt_s),
                answer.guess,
            ),
            offset_m, heading_rad, answer.bounded, answer.feasible, answer.iterations,
        )  # fmt: skip

    def eased(self, state: SteerControlState) -> SteerControlState:
        """Nothing to follow: gently straight."""
        reach = self.ease_radps * self.dt_s
        eased_rad = state.command_rad - min(max(state.command_rad, -reach), reach)
        return SteerControlState(eased_rad, no_guess(self.mpc.steps))

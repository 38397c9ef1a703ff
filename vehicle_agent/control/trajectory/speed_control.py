"""The longitudinal half: where the vehicle shall be when, down to the pedals."""

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.control.actuators import MS, MSPEED, carried
from vehicle_agent.control.mpc.axis import AxisSolution, WarmStart, no_guess
from vehicle_agent.control.mpc.longitudinal import LongitudinalMpc
from vehicle_agent.control.trajectory.observer import Observer, ObserverState
from vehicle_agent.control.trajectory.pedals import PedalController, PedalState
from vehicle_agent.control.trajectory.timed_path import asked, next_stop_m


class SpeedControlState(msgspec.Struct, frozen=True):
    """What is remembered: the pedals, the acceleration commanded, and what the next solve starts from."""

    foot: PedalState
    accel_mps2: float
    guess: WarmStart


class SpeedControlResult(msgspec.Struct, frozen=True):
    """speeds_mps (N + 1,) expected from lead_s after now on; behind_m as it was before it was limited."""

    state: SpeedControlState
    speeds_mps: Array
    lead_s: float
    behind_m: float
    missing_mps: float
    bounded: bool
    feasible: bool
    iterations: int


class SpeedControl(msgspec.Struct, frozen=True):
    """behind_m, behind_s  being late by more than this and this of the way ahead is not made up for at
                        once: the vehicle must not race after its plan
    ahead_m_max         nor crawl for it to come
    arrive_m, arrive_mps2  farther from a stop, or needing less braking for it, all is left to the MPC
    overrun_m        this far beyond a stop is not worth a jolt
    stand_mps        slower is standing, where nothing faster than start_mps is asked for within start_s
    """

    mpc: LongitudinalMpc = LongitudinalMpc()
    pedalling: PedalController = PedalController()
    behind_m: float = 0.06
    behind_s: float = 0.08
    ahead_m_max: float = 0.6
    arrive_m: float = 0.5
    arrive_mps2: float = 0.05
    overrun_m: float = 0.015
    stand_mps: float = 0.06
    start_mps: float = 0.03
    start_s: float = 0.3
    decel_mps2_comfort: float = 0.8
    dt_s: float = 0.02

    def initial(self) -> SpeedControlState:
        return SpeedControlState(PedalState(), 0.0, no_guess(self.mpc.steps))

    def step(
        self, state: SpeedControlState, seen: ObserverState, observer: Observer, commands: Array,
        rows: Array, s: Array, own_s_m: float, t_s: float, emergency: bool,
    ) -> SpeedControlResult:  # fmt: skip
        """One tick along rows (k, 8) with lengths s (k,), the vehicle at own_s_m, t_s after the rows'
        stamp."""
        drivetrain = observer.drivetrain
        lead_s = drivetrain.brake_delay_s if state.foot.braking else drivetrain.throttle_delay_s
        moving = seen.moving.copy()
        moving[MS] = own_s_m
        carried(
            moving, commands, 0.0, lead_s, seen.rest_mps2, observer.turning(seen), self.dt_s, drivetrain.row()
        )
        N, dt_s = self.mpc.steps, self.mpc.dt_s
        places_m, speeds_mps = asked(rows, s, t_s + lead_s, dt_s, N, self.decel_mps2_comfort)
        behind_m = float(places_m[0] - moving[MS])
        missing_mps = float(speeds_mps[0] - moving[MSPEED])
        if emergency:
            foot = PedalState(0.0, 1.0, True, False)
            after = SpeedControlState(foot, -self.mpc.decel_mps2_max, no_guess(N))
            return SpeedControlResult(
                after, np.full(N + 1, moving[MSPEED]), lead_s, behind_m, missing_mps, False, True, 0
            )
        if self._stands(state.foot, seen.speed_mps, speeds_mps):
            after = SpeedControlState(self.pedalling.held(state.foot), 0.0, no_guess(N))
            return SpeedControlResult(after, np.zeros(N + 1), lead_s, behind_m, missing_mps, False, True, 0)
        accel_mps2 = observer.accel_mps2(moving, seen.rest_mps2)
        answer = self._solved(state, speeds_mps, behind_m, missing_mps, moving, accel_mps2)
        command = state.accel_mps2 + float(answer.inputs[0]) * self.dt_s
        left_m = next_stop_m(rows, s, t_s + lead_s) - float(moving[MS])
        command = self._arriving(command, state.accel_mps2, float(moving[MSPEED]), left_m)
        command = min(max(command, -self.mpc.decel_mps2_max), self.mpc.accel_mps2_max)
        foot = self.pedalling.step(state.foot, command - seen.rest_mps2, float(moving[MSPEED]))
        expected = rolled(
            answer.inputs, float(moving[MSPEED]), accel_mps2, command, self.mpc.accel_lag_s, dt_s
        )
        return SpeedControlResult(
            SpeedControlState(foot, command, answer.guess), expected, lead_s, behind_m, missing_mps,
            answer.bounded, answer.feasible, answer.iterations,
        )  # fmt: skip

    def _solved(
        self, state: SpeedControlState, speeds_mps: Array, behind_m: float, missing_mps: float,
        moving: Array, accel_mps2: float,
    ) -> AxisSolution:  # fmt: skip
        """The MPC's jerks towards speeds_mps (N + 1,); a large lag is made up for over time."""
        late_m = self.behind_m + self.behind_s * max(float(speeds_mps[0]), float(moving[MSPEED]))
        limited_m = min(max(behind_m, -self.ahead_m_max), late_m)
        rising = np.diff(speeds_mps) / self.mpc.dt_s
        # Rows change their speed in steps of acceleration; the speed that they mean is smooth.
        wanted_mps2 = np.convolve(
            np.concatenate((rising[:1], rising, rising[-1:])), (0.25, 0.5, 0.25), "valid"
        )
        return self.mpc.solve(limited_m, missing_mps, accel_mps2, state.accel_mps2, wanted_mps2, state.guess)

    def _arriving(self, command: float, before: float, speed_mps: float, left_m: float) -> float:
        """The command, or the braking that still comes to rest in left_m if that is more.

        Errors either way cost the same in the MPC, but a vehicle does not come back from beyond its stop.
        """
        needed = 0.5 * speed_mps * speed_mps / max(left_m + self.overrun_m, 0.01)
        if left_m > self.arrive_m or not needed > self.arrive_mps2:
            return command
        reach = self.mpc.jerk_mps3_max * self.dt_s
        wanted = min(command, -min(needed, self.decel_mps2_comfort))
        return min(max(wanted, before - reach), before + reach)

    def _stands(self, foot: PedalState, speed_mps: float, speeds_mps: Array) -> bool:
        if float(speeds_mps[: max(2, round(self.start_s / self.mpc.dt_s))].max()) > self.start_mps:
            return False
        return foot.holding or speed_mps < self.stand_mps


@njit(cache=True)
def rolled(jerks: Array, speed: float, accel: float, command: float, lag: float, dt: float) -> Array:
    """(N + 1,) speeds, never backwards, under jerks (N,) from speed, acceleration and its command."""
    speeds = np.empty(jerks.shape[0] + 1)
    speeds[0] = speed
    share = 1.0 - np.exp(-dt / lag)
    for k in range(jerks.shape[0]):
        after = command + jerks[k] * dt
        next_accel = accel + share * (0.5 * (command + after) - accel)
        speeds[k + 1] = max(0.0, speeds[k] + 0.5 * (accel + next_accel) * dt)
        accel, command = next_accel, after
    return speeds

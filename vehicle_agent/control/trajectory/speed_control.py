"""The longitudinal half: from the trajectory's positions and speeds to the pedals."""

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.control.actuators import MBRAKE, MS, MSPEED, MTHROTTLE, pedal_accel_mps2, propagate
from vehicle_agent.control.mpc.axis import AxisSolution, WarmStart, cold_start
from vehicle_agent.control.mpc.longitudinal import LongitudinalMpc
from vehicle_agent.control.trajectory.observer import Observer, ObserverState
from vehicle_agent.control.trajectory.pedals import PedalController, PedalState
from vehicle_agent.control.trajectory.timed_path import next_stop_m, reference_at_times


class SpeedControlState(msgspec.Struct, frozen=True):
    """What is remembered: the pedals, the commanded acceleration, and the start of the next solve."""

    pedals: PedalState
    accel_mps2: float
    warm_start: WarmStart


class SpeedControlResult(msgspec.Struct, frozen=True):
    """speeds_mps (N + 1,) expected from lead_s after now on; behind_m before it is limited."""

    state: SpeedControlState
    speeds_mps: Array
    lead_s: float
    behind_m: float
    speed_error_mps: float
    bounded: bool
    feasible: bool
    iterations: int


class SpeedControl(msgspec.Struct, frozen=True):
    """behind_m, behind_s  a position error beyond behind_m + behind_s v is not recovered at once: the vehicle
                      must not speed after its plan
    behind_mps        neither is a lower speed than the plan's beyond this
    ahead_m_max       bound of the opposite error, so that the vehicle does not crawl
    arrive_m, arrive_mps2  farther from a stop, or if it needs less braking, the MPC alone decides
    overrun_m         an overrun of a stop that is not worth a jolt
    stand_mps         a slower vehicle stands, if no speed above start_mps is requested within start_s: one
                      that inches keeps people waiting who would walk on before it
    set_off_mps2      commanded where the guard or the gate holds the vehicle; small, so that it does not leap
    """

    mpc: LongitudinalMpc = LongitudinalMpc()
    pedal_controller: PedalController = PedalController()
    behind_m: float = 0.02
    behind_s: float = 0.08
    behind_mps: float = 0.05
    ahead_m_max: float = 0.6
    arrive_m: float = 0.5
    arrive_mps2: float = 0.05
    overrun_m: float = 0.015
    stand_mps: float = 0.06
    start_mps: float = 0.12
    start_s: float = 0.6
    set_off_mps2: float = 0.08
    decel_mps2_comfort: float = 0.8
    dt_s: float = 0.02

    def initial(self) -> SpeedControlState:
        return SpeedControlState(PedalState(), 0.0, cold_start(self.mpc.steps))

    def held(self) -> SpeedControlState:
        """The state of a vehicle that another brake holds, or held until a moment ago.

        The report of a brake that was let go is a dead time old. A vehicle that waited for it would wait for
        the throttle's dead time once more, with next to no throttle.
        """
        return SpeedControlState(PedalState(), self.set_off_mps2, cold_start(self.mpc.steps))

    def step(
        self, state: SpeedControlState, estimate: ObserverState, observer: Observer, commands: Array,
        rows: Array, s: Array, own_s_m: float, t_s: float, emergency: bool,
    ) -> SpeedControlResult:  # fmt: skip
        """The pedals of this tick along rows (k, 8) with lengths s (k,).

        The vehicle is at own_s_m, t_s after the rows' stamp.
        """
        drivetrain = observer.learned_drivetrain(estimate)
        row = drivetrain.row()
        lead_s = drivetrain.brake_delay_s if state.pedals.braking else drivetrain.throttle_delay_s
        vehicle = estimate.vehicle.copy()
        vehicle[MS] = own_s_m
        propagate(
            vehicle,
            commands,
            0.0,
            lead_s,
            estimate.disturbance_mps2,
            observer.turn_params(estimate),
            self.dt_s,
            row,
        )
        N, dt_s = self.mpc.steps, self.mpc.dt_s
        positions_m, speeds_mps = reference_at_times(rows, s, t_s + lead_s, dt_s, N, self.decel_mps2_comfort)
        behind_m = float(positions_m[0] - vehicle[MS])
        speed_error_mps = float(speeds_mps[0] - vehicle[MSPEED])
        if emergency:
            pedals = PedalState(0.0, 1.0, True, False)
            new = SpeedControlState(pedals, -self.mpc.decel_mps2_max, cold_start(N))
            return SpeedControlResult(
                new, np.full(N + 1, vehicle[MSPEED]), lead_s, behind_m, speed_error_mps, False, True, 0
            )
        if self._is_standing(state.pedals, estimate.speed_mps, speeds_mps):
            new = SpeedControlState(self.pedal_controller.hold(state.pedals), 0.0, cold_start(N))
            return SpeedControlResult(new, np.zeros(N + 1), lead_s, behind_m, speed_error_mps, False, True, 0)
        accel_mps2 = estimate.disturbance_mps2 + float(
            pedal_accel_mps2(vehicle[MTHROTTLE], vehicle[MBRAKE], vehicle[MSPEED], row)
        )
        solution = self._solved(state, speeds_mps, behind_m, speed_error_mps, vehicle, accel_mps2)
        command = state.accel_mps2 + float(solution.inputs[0]) * self.dt_s
        remaining_m = next_stop_m(rows, s, t_s + lead_s) - float(vehicle[MS])
        command = self._stop_command(command, state.accel_mps2, float(vehicle[MSPEED]), remaining_m)
        command = min(max(command, -self.mpc.decel_mps2_max), self.mpc.accel_mps2_max)
        pedals = self.pedal_controller.step(
            state.pedals,
            command - self._disturbance_mps2(estimate, command),
            float(vehicle[MSPEED]),
            drivetrain,
        )
        expected_mps = expected_speeds(
            solution.inputs, float(vehicle[MSPEED]), accel_mps2, command, self.mpc.accel_lag_s, dt_s
        )
        return SpeedControlResult(
            SpeedControlState(pedals, command, solution.warm_start), expected_mps, lead_s, behind_m,
            speed_error_mps, solution.bounded, solution.feasible, solution.iterations,
        )  # fmt: skip

    def _disturbance_mps2(self, estimate: ObserverState, command: float) -> float:
        """What the pedals make up for.

        A vehicle at rest sets off by its throttle, even if it was learned on the way that it rolls better
        than expected: without throttle the guard holds the brake, and the vehicle would stand for ever.
        """
        sets_off = command > 0.0 and estimate.speed_mps < self.stand_mps
        return min(estimate.disturbance_mps2, 0.0) if sets_off else estimate.disturbance_mps2

    def _solved(
        self, state: SpeedControlState, speeds_mps: Array, behind_m: float, speed_error_mps: float,
        vehicle: Array, accel_mps2: float,
    ) -> AxisSolution:  # fmt: skip
        """The MPC's solution for speeds_mps (N + 1,); what it is behind is recovered over time."""
        late_m = self.behind_m + self.behind_s * max(float(speeds_mps[0]), float(vehicle[MSPEED]))
        limited_m = min(max(behind_m, -self.ahead_m_max), late_m)
        rising = np.diff(speeds_mps) / self.mpc.dt_s
        # Rows have steps in their acceleration; the reference is smooth.
        reference_mps2 = np.convolve(
            np.concatenate((rising[:1], rising, rising[-1:])), (0.25, 0.5, 0.25), "valid"
        )
        slower_mps = min(speed_error_mps, self.behind_mps)
        return self.mpc.solve(
            limited_m, slower_mps, accel_mps2, state.accel_mps2, reference_mps2, state.warm_start
        )

    def _stop_command(self, command: float, previous: float, speed_mps: float, remaining_m: float) -> float:
        """The command, or the braking that comes to rest in remaining_m if that is more.

        The MPC's cost is symmetric, but a vehicle does not come back from beyond its stop.
        """
        needed_mps2 = 0.5 * speed_mps * speed_mps / max(remaining_m + self.overrun_m, 0.01)
        if remaining_m > self.arrive_m or not needed_mps2 > self.arrive_mps2:
            return command
        reach = self.mpc.jerk_mps3_max * self.dt_s
        limited_mps2 = min(command, -min(needed_mps2, self.decel_mps2_comfort))
        return min(max(limited_mps2, previous - reach), previous + reach)

    def _is_standing(self, pedals: PedalState, speed_mps: float, speeds_mps: Array) -> bool:
        if float(speeds_mps[: max(2, round(self.start_s / self.mpc.dt_s))].max()) > self.start_mps:
            return False
        return pedals.holding or speed_mps < self.stand_mps


@njit(cache=True)
def expected_speeds(jerks: Array, speed: float, accel: float, command: float, lag: float, dt: float) -> Array:
    """(N + 1,) speeds, never negative, under jerks (N,) from speed, acceleration and its command."""
    speeds = np.empty(jerks.shape[0] + 1)
    speeds[0] = speed
    share = 1.0 - np.exp(-dt / lag)
    for k in range(jerks.shape[0]):
        new = command + jerks[k] * dt
        next_accel = accel + share * (0.5 * (command + new) - accel)
        speeds[k + 1] = max(0.0, speeds[k] + 0.5 * (accel + next_accel) * dt)
        accel, command = next_accel, new
    return speeds

"""Steering: builds the lateral problem from the speeds and curvatures ahead, and solves it."""

import math
from functools import cache
from typing import NamedTuple

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array
from vehicle_agent.control.mpc.axis import AxisSolution, WarmStart, solve_axis
from vehicle_agent.control.mpc.bounded import InputBounds
from vehicle_agent.control.mpc.lateral_model import (
    INPUT,
    SIZE,
    STATES,
    TARGET,
    TARGET_RATE,
    Chassis,
    dynamic_share,
    exponential,
    rates_matrix,
)
from vehicle_agent.control.mpc.problem import AxisProblem, end_cost

# Speeds of the table of end costs, from the least speed at which steering changes the lateral error.
END_MPS = tuple(0.25 * i for i in range(2, 41))
END_ROUNDS = 1500


class LateralWeights(msgspec.Struct, frozen=True):
    """Costs a second: of the rear axle's offset (1/m2), its course error (1/rad2), the yaw rate error, and
    the steering rate beyond the curve's own.

    The course is used, not the heading: in a curve the rear axle slips, and the heading differs from the
    path's.
    """

    offset: float = 60.0
    course: float = 40.0
    yaw_rate: float = 2.0
    steer_rate: float = 10.0


class LateralStart(NamedTuple):
    """The rear axle's errors and the steering when the first input takes effect.

    offset_rate_mps  d/dt of the offset; yaw_rate_radps: d/dt of the heading error
    wheels_rad, command_rad  as the steering reports them
    """

    offset_m: float
    offset_rate_mps: float
    heading_rad: float
    yaw_rate_radps: float
    wheels_rad: float
    command_rad: float


class LateralMpc(msgspec.Struct, frozen=True):
    """steps of dt_s each; the steering's limits as on the wheels."""

    chassis: Chassis = Chassis()
    weights: LateralWeights = LateralWeights()
    steer_rad_max: float = 0.4795
    steer_rate_radps_max: float = 0.6
    steps: int = 40
    dt_s: float = 0.05

    def prepare(self) -> None:
        """Computes the table of end costs, so that no solve waits for it."""
        _end_costs(self)

    def solve(
        self,
        start: LateralStart,
        bias_rad: float,
        compliance: float,
        speeds_mps: Array,
        curvatures_1pm: Array,
        warm_start: WarmStart,
    ) -> AxisSolution:
        """Rates (N,) of the tangent of the wheel angle, from the errors when the first rate takes effect.

        The model's wheel angle is that tangent, so it is exact on every circle, and a bound on its rate
        bounds the angle's rate. `next_command_rad` converts it back to an angle.
        bias_rad    the wheels stand at the reported angle plus this; compliance: see `rates_matrix`
        speeds_mps, curvatures_1pm  (N + 1,) expected along the horizon
        """
        w = self.weights
        weights = np.array((w.offset, w.course, w.yaw_rate)) * self.dt_s
        A, B, d, Q = horizon(speeds_mps, curvatures_1pm, compliance, self.chassis.row(), weights, self.dt_s)
        bounds = InputBounds(
            self.steer_rate_radps_max,
            math.tan(bias_rad - self.steer_rad_max),
            math.tan(bias_rad + self.steer_rad_max),
        )
        speed_mps, curvature_1pm = float(speeds_mps[-1]), float(curvatures_1pm[-1])
        softness = compliance * float(dynamic_share(speed_mps)) * self.chassis.understeer_s2pm
        wheel_tangents = (self.chassis.wheelbase_m + softness * speeds_mps**2) * curvatures_1pm
        rates = np.clip(np.diff(wheel_tangents) / self.dt_s, -bounds.rate, bounds.rate)
        problem = AxisProblem(
            A,
            B,
            d,
            Q,
            w.steer_rate * self.dt_s,
            rates,
            _end_costs(self)[_end_index(speed_mps)],
            self._steady_turn(speed_mps, curvature_1pm, compliance),
            self._first_state(start, bias_rad),
        )
        return solve_axis(problem, bounds, self.dt_s, warm_start)

    def _first_state(self, start: LateralStart, bias_rad: float) -> Array:
        """(6,) the model's state at the start."""
        rear_m = self.chassis.cog_to_rear_m
        # Rounding may put the command beyond its bounds; the problem must not start there.
        command_rad = min(max(start.command_rad, -self.steer_rad_max), self.steer_rad_max)
        return np.array(
            (
                start.offset_m + rear_m * start.heading_rad,
                start.offset_rate_mps + rear_m * start.yaw_rate_radps,
                start.heading_rad,
                start.yaw_rate_radps,
                math.tan(start.wheels_rad + bias_rad),
                math.tan(command_rad + bias_rad),
            )
        )

    def next_command_rad(self, command_rad: float, bias_rad: float, rate: float, dt_s: float) -> float:
        """The command after dt_s of a rate that `solve` gave, within the steering's limit."""
        command_rad_next = math.atan(math.tan(command_rad + bias_rad) + rate * dt_s) - bias_rad
        return min(max(command_rad_next, -self.steer_rad_max), self.steer_rad_max)

    def _steady_turn(self, speed_mps: float, curvature_1pm: float, compliance: float) -> Array:
        """(6,) the state of following a circle without error, with its slip and wheel angle."""
        softness, chassis = compliance * float(dynamic_share(speed_mps)), self.chassis
        side_mps2 = speed_mps * speed_mps * curvature_1pm
        slip_rad = softness * chassis.rear_slip_per_mps2 * side_mps2
        wheel_tangents = chassis.wheelbase_m * curvature_1pm + softness * chassis.understeer_s2pm * side_mps2
        return np.array(
            (chassis.cog_to_rear_m * slip_rad, 0.0, slip_rad, 0.0, wheel_tangents, wheel_tangents)
        )


def _end_index(speed_mps: float) -> int:
    return min(max(round((speed_mps - END_MPS[0]) / 0.25), 0), len(END_MPS) - 1)


@cache
def _end_costs(mpc: LateralMpc) -> Array:
    """(speeds, 6, 6) cost of the errors at the end of the horizon, by speed; nominal tyres."""
    w = mpc.weights
    weights = np.array((w.offset, w.course, w.yaw_rate)) * mpc.dt_s
    costs = np.zeros((len(END_MPS), STATES, STATES))
    for i, speed_mps in enumerate(END_MPS):
        A, B, _, Q = horizon(np.full(2, speed_mps), np.zeros(2), 1.0, mpc.chassis.row(), weights, mpc.dt_s)
        costs[i] = end_cost(A[0], B[0], Q[0], w.steer_rate * mpc.dt_s, END_ROUNDS)
    return costs


@njit(cache=True)
def horizon(
    speeds: Array, curvatures: Array, compliance: float, chassis: Array, weights: Array, dt: float
) -> tuple[Array, Array, Array, Array]:
    """(A (N, 6, 6), B (N, 6), d (N, 6), Q (N, 6, 6)) of each step; speeds and curvatures (N + 1,).

    Within a step the speed is its mean, and psi_dot_tar is linear between its values at both ends.
    """
    N = speeds.shape[0] - 1
    A, B = np.zeros((N, STATES, STATES)), np.zeros((N, STATES))
    d, Q = np.zeros((N, STATES)), np.zeros((N, STATES, STATES))
    M, step = np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    rear = chassis[3]
    for k in range(N):
        speed = 0.5 * (speeds[k] + speeds[k + 1])
        rates_matrix(speed, compliance, chassis, M)
        exponential(M, dt, step)
        target = speeds[k] * curvatures[k]
        slope = (speeds[k + 1] * curvatures[k + 1] - target) / dt
        for i in range(STATES):
            for j in range(STATES):
                A[k, i, j] = step[i, j]
            B[k, i] = step[i, INPUT]
            d[k, i] = step[i, TARGET] * target + step[i, TARGET_RATE] * slope
        pace = 1.0 / max(speeds[k], 1.0)
        # Rows of the outputs: offset e - l_r psi, course (e' - l_r psi') / V, yaw rate error psi'.
        q = Q[k]
        q[0, 0], q[2, 2] = weights[0], weights[0] * rear * rear
        q[0, 2] = q[2, 0] = -weights[0] * rear
        course = weights[1] * pace * pace
        q[1, 1] = course
        q[3, 3] = course * rear * rear + weights[2]
        q[1, 3] = q[3, 1] = -course * rear
    return A, B, d, Q

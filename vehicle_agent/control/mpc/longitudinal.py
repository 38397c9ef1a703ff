"""Speed: the longitudinal rows of eqs. 3-5 with e_lon = s_ref - s, and a_ref as feed-forward."""

from functools import cache

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.control.mpc.axis import AxisSolution, WarmStart, solve_axis
from vehicle_agent.control.mpc.bounded import InputBounds
from vehicle_agent.control.mpc.lateral_model import exponential
from vehicle_agent.control.mpc.problem import AxisProblem, end_cost

STATES = 4
END_ROUNDS = 1500


class LongitudinalWeights(msgspec.Struct, frozen=True):
    """Costs a second: of the position error (1/m2), of the speed error (1/(m/s)2), of jerk beyond the
    reference's own (1/(m/s3)2)."""

    distance: float = 40.0
    speed: float = 20.0
    jerk: float = 0.2


class LongitudinalMpc(msgspec.Struct, frozen=True):
    """State (4,): e_lon (m), its rate, the acceleration, its command. Input: the command's rate, jerk."""

    weights: LongitudinalWeights = LongitudinalWeights()
    accel_mps2_max: float = 0.8
    decel_mps2_max: float = 2.5
    jerk_mps3_max: float = 1.7
    accel_lag_s: float = 0.12
    steps: int = 40
    dt_s: float = 0.05

    def solve(
        self,
        behind_m: float,
        speed_error_mps: float,
        accel_mps2: float,
        command_mps2: float,
        reference_mps2: Array,
        warm_start: WarmStart,
    ) -> AxisSolution:
        """Jerks (N,) from the errors when the first jerk takes effect.

        behind_m, speed_error_mps  e_lon and its rate
        reference_mps2             (N,) a_ref, mean of each step
        """
        command_mps2 = min(max(command_mps2, -self.decel_mps2_max), self.accel_mps2_max)
        A, B, D, Q, P = _steps(self)
        x0 = np.array((behind_m, speed_error_mps, accel_mps2, command_mps2))
        d = reference_mps2[:, None] * D
        bounds = InputBounds(self.jerk_mps3_max, -self.decel_mps2_max, self.accel_mps2_max)
        reference_jerk = np.diff(np.append(reference_mps2, reference_mps2[-1])) / self.dt_s
        w = np.clip(reference_jerk, -self.jerk_mps3_max, self.jerk_mps3_max)
        R = self.weights.jerk * self.dt_s
        problem = AxisProblem(A, B, d, Q, R, w, P, np.zeros(STATES), x0)
        return solve_axis(problem, bounds, self.dt_s, warm_start)


@cache
def _steps(mpc: LongitudinalMpc) -> tuple[Array, Array, Array, Array, Array]:
    """(A (N, 4, 4), B (N, 4), D (4,) of a_ref, Q (N, 4, 4), end cost (4, 4)): the same at every speed."""
    M, step = np.zeros((STATES + 2, STATES + 2)), np.zeros((STATES + 2, STATES + 2))
    M[0, 1] = 1.0
    M[1, 2], M[1, STATES + 1] = -1.0, 1.0
    M[2, 2], M[2, 3] = -1.0 / mpc.accel_lag_s, 1.0 / mpc.accel_lag_s
    M[3, STATES] = 1.0
    exponential(M, mpc.dt_s, step)
    A, B = np.ascontiguousarray(step[:STATES, :STATES]), np.ascontiguousarray(step[:STATES, STATES])
    Q = np.diag((mpc.weights.distance, mpc.weights.speed, 0.0, 0.0)) * mpc.dt_s
    P = end_cost(A, B, Q, mpc.weights.jerk * mpc.dt_s, END_ROUNDS)
    N = mpc.steps
    return (
        np.tile(A, (N, 1, 1)), np.tile(B, (N, 1)), np.ascontiguousarray(step[:STATES, STATES + 1]),
        np.tile(Q, (N, 1, 1)), P,
    )  # fmt: skip

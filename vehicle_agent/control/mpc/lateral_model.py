"""The lateral half of the error model, step by step along the horizon (Snow Lion, eqs. 3-5, corrected).

State z (6,): e_lat (m, left of the trajectory positive) and its rate, e_psi (rad) and its rate, the tangent
of the front wheels' angle and of its command. Input: the command's rate. Known: psi_dot_tar = V curvature.
e_lon and its rate, the paper's other two states, are in `longitudinal.py`: no term of A couples them.

The paper's e_lat belongs to the centre of gravity. Here it is the offset of the centre of gravity from its
place with the rear axle on the trajectory: e_lat = e_rear + l_r e_psi, so e_rear follows from the state. Its
rate is the paper's less l_r psi_dot_tar, which moves terms of A into C and adds -l_r psi_ddot_tar.
"""

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array

STATES = 6
# Columns of the step's matrix: the state, then psi_dot_tar, the input and psi_ddot_tar.
TARGET, INPUT, TARGET_RATE = 6, 7, 8
SIZE = 9
# Kinematic below the first speed, dynamic above the second, blended between (eq. 4 is singular at V = 0).
BLEND_MPS = (1.0, 2.0)
# Time constant with which the kinematic rows bring the rates to those of the wheel angle.
KINEMATIC_S = 0.02


class Chassis(msgspec.Struct, frozen=True):
    """The vehicle's parameters in eq. 4.

    cog_to_*_m         l_f and l_r, from the centre of gravity to the axles
    cornering_*_npr    C_f and C_r of an axle (both wheels), N/rad
    steer_lag_s        first-order, from the command (after its dead time) to the wheels
    """

    mass_kg: float = 1400.0
    yaw_inertia_kgm2: float = 1800.0
    cog_to_front_m: float = 1.248
    cog_to_rear_m: float = 1.352
    cornering_front_npr: float = 60_000.0
    cornering_rear_npr: float = 70_000.0
    steer_lag_s: float = 0.05

    def __post_init__(self) -> None:
        if not all(value > 0.0 for value in self.row().tolist()):
            raise ValueError("every value of a chassis must be positive and finite")

    def row(self) -> Array:
        """(7,) the parameters for the kernels, in the order of the fields."""
        return np.array(msgspec.structs.astuple(self), dtype=np.float64)

    @property
    def wheelbase_m(self) -> float:
        return self.cog_to_front_m + self.cog_to_rear_m

    @property
    def rear_slip_per_mps2(self) -> float:
        """Slip angle of the rear axle in a steady turn, rad per m/s2 of lateral acceleration."""
        return self.mass_kg * self.cog_to_front_m / (self.wheelbase_m * self.cornering_rear_npr)

    @property
    def understeer_s2pm(self) -> float:
        """K in yaw rate = V delta / (L + K V^2), in s2/m times m."""
        front, rear = (
            self.cog_to_rear_m / self.cornering_front_npr,
            self.cog_to_front_m / self.cornering_rear_npr,
        )
        return self.mass_kg / self.wheelbase_m * (front - rear)


@njit(cache=True)
def dynamic_share(speed_mps: float) -> float:
    """Share of the dynamic model, 0..1."""
    t = min(max((speed_mps - BLEND_MPS[0]) / (BLEND_MPS[1] - BLEND_MPS[0]), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


@njit(cache=True)
def rates_matrix(speed: float, compliance: float, p: Array, M: Array) -> None:
    """Fills M (SIZE, SIZE): d/dt of [z, psi_dot_tar, input, psi_ddot_tar] at one speed.

    compliance  tyre compliance over the nominal: both stiffnesses are divided by it; near 0 the wheels roll
                without slip. p from `Chassis.row`.
    """
    mass, inertia, lf, lr, lag = p[0], p[1], p[2], p[3], p[6]
    cf, cr = p[4] / compliance, p[5] / compliance
    M[:, :] = 0.0
    M[0, 1], M[2, 3] = 1.0, 1.0
    w = dynamic_share(speed)
    k = (1.0 - w) / KINEMATIC_S
    turn = speed / (lf + lr)
    M[1, 1], M[1, 2], M[1, 4], M[1, TARGET] = -k, k * speed, k * lr * turn, -k * lr
    M[3, 3], M[3, 4], M[3, TARGET] = -k, k * turn, -k
    if w > 0.0:
        a22, a24 = -(cf + cr) / (mass * speed), -(cf * lf - cr * lr) / (mass * speed)
        a42 = -(cf * lf - cr * lr) / (inertia * speed)
        a44 = -(cf * lf * lf + cr * lr * lr) / (inertia * speed)
        M[1, 1] += w * a22
        M[1, 2] += w * (cf + cr) / mass
        M[1, 3] += w * a24
        M[1, 4] += w * cf / mass
        M[1, TARGET] += w * (a24 - speed + a22 * lr)
        M[1, TARGET_RATE] = -w * lr
        M[3, 1] += w * a42
        M[3, 2] += w * (cf * lf - cr * lr) / inertia
        M[3, 3] += w * a44
        M[3, 4] += w * cf * lf / inertia
        M[3, TARGET] += w * (a44 + a42 * lr)
        M[3, TARGET_RATE] = -w
    M[4, 4], M[4, 5] = -1.0 / lag, 1.0 / lag
    M[5, INPUT] = 1.0
    M[TARGET, TARGET_RATE] = 1.0


@njit(cache=True)
def exponential(M: Array, dt: float, out: Array) -> None:
    """out = exp(M dt) by two halves of the (0, 2) Pade form, which is stable for any stiff M.

    M and out (n, n). Error of a mode of rate w: about (w dt)^3 / 24.
    """
    n = M.shape[0]
    h = 0.5 * dt
    left = np.zeros((n, 2 * n))
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(n):
                if M[i, k] != 0.0:
                    total += M[i, k] * M[k, j]
            left[i, j] = 0.5 * h * h * total - h * M[i, j]
        left[i, i] += 1.0
        left[i, n + i] = 1.0
    for c in range(n):
        pivot = c
        for r in range(c + 1, n):
            if abs(left[r, c]) > abs(left[pivot, c]):
                pivot = r
        if pivot != c:
            for j in range(2 * n):
                left[c, j], left[pivot, j] = left[pivot, j], left[c, j]
        inverse = 1.0 / left[c, c]
        for j in range(c, 2 * n):
            left[c, j] *= inverse
        for r in range(n):
            factor = left[r, c]
            if r != c and factor != 0.0:
                for j in range(c, 2 * n):
                    left[r, j] -= factor * left[c, j]
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += left[i, n + k] * left[k, n + j]
            out[i, j] = total

"""How the vehicle answers its commands: dead times, lags, and the pedals' accelerations.

The same kernel carries the belief about the actuators from the last tick to this one, and leads the vehicle
on over the commands that are still on their way.
"""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, wrap_angle

SUBSTEP_S = 0.005
# Columns of a moving vehicle: pose (map), wheels (as the steering reports them), throttle and brake in
# effect, speed, distance driven.
MX, MY, MYAW, MWHEELS, MTHROTTLE, MBRAKE, MSPEED, MS = range(8)
MOVING_SIZE = 8


class Drivetrain(msgspec.Struct, frozen=True):
    """The identified response. *_delay_s pure dead time, *_lag_s first-order.

    throttle_per_mps2  pedal per acceleration at rest; throttle_fade_mps: the speed at which full throttle no
                       longer accelerates, the acceleration falling in proportion before
    brake_*            pedal = gain ln(a + knee) + offset (`brake_map.BrakeMap`)
    """

    steer_delay_s: float = 0.25
    steer_lag_s: float = 0.05
    throttle_delay_s: float = 0.25
    throttle_lag_s: float = 0.15
    brake_delay_s: float = 0.2
    brake_lag_s: float = 0.05
    throttle_per_mps2: float = 0.4
    throttle_fade_mps: float = 8.0
    brake_gain: float = 0.2473
    brake_offset: float = 0.5695
    brake_knee_mps2: float = 0.1
    coast_mps2: float = 0.15

    def row(self) -> Array:
        """(12,) as the kernels take it, in the order of the fields."""
        return np.array(msgspec.structs.astuple(self), dtype=np.float64)

    def memory(self, dt_s: float) -> int:
        """How many commands may be on their way."""
        return math.ceil(max(self.steer_delay_s, self.throttle_delay_s, self.brake_delay_s) / dt_s) + 2


(
    D_STEER_DELAY, D_STEER_LAG, D_THROTTLE_DELAY, D_THROTTLE_LAG, D_BRAKE_DELAY, D_BRAKE_LAG,
    D_PER, D_FADE, D_GAIN, D_OFFSET, D_KNEE, D_COAST,
) = range(12)  # fmt: skip


@njit(cache=True)
def pedal_accel_mps2(throttle: float, brake: float, speed_mps: float, p: Array) -> float:
    """The acceleration that the pedals in effect give a nominal vehicle on the level; p from
    `Drivetrain.row`."""
    push = throttle / p[D_PER] * max(0.0, 1.0 - speed_mps / p[D_FADE])
    held = 0.0
    if brake > 0.0:
        held = max(0.0, math.exp((brake - p[D_OFFSET]) / p[D_GAIN]) - p[D_KNEE])
    return float(push - held - p[D_COAST])


@njit(cache=True)
def _on_its_way(commands: Array, column: int, t_s: float, delay_s: float, dt_s: float) -> float:
    """The command in effect t_s from now; commands (m, 3), one each dt_s, the newest given dt_s ago."""
    m = commands.shape[0]
    i = m + math.floor((t_s - delay_s) / dt_s)
    return float(commands[min(max(i, 0), m - 1), column])


@njit(cache=True)
def carried(
    moving: Array, commands: Array, start_s: float, end_s: float, rest_mps2: float, turning: Array,
    dt_s: float, p: Array,
) -> None:  # fmt: skip
    """Move the vehicle (MOVING_SIZE,) in place from start_s to end_s, both counted from now.

    commands   (m, 3) steering (rad), throttle, brake, as `_on_its_way` reads them
    rest_mps2  acceleration beyond what the pedals explain: load, slope, wind
    turning    (4,) steering bias in rad, wheelbase in m, and K (s2/m m) and rear slip (rad per m/s2) of a
               steady turn; the tyres are taken as settled, which they are within a tenth of a second
    """
    steps = round((end_s - start_s) / SUBSTEP_S)
    h = SUBSTEP_S
    for k in range(steps):
        t = start_s + (k + 0.5) * h
        steer = _on_its_way(commands, 0, t, p[D_STEER_DELAY], dt_s)
        throttle = _on_its_way(commands, 1, t, p[D_THROTTLE_DELAY], dt_s)
        brake = _on_its_way(commands, 2, t, p[D_BRAKE_DELAY], dt_s)
        moving[MWHEELS] += (steer - moving[MWHEELS]) * (1.0 - math.exp(-h / p[D_STEER_LAG]))
        moving[MTHROTTLE] += (throttle - moving[MTHROTTLE]) * (1.0 - math.exp(-h / p[D_THROTTLE_LAG]))
        moving[MBRAKE] += (brake - moving[MBRAKE]) * (1.0 - math.exp(-h / p[D_BRAKE_LAG]))
        v = moving[MSPEED]
        accel = pedal_accel_mps2(moving[MTHROTTLE], moving[MBRAKE], v, p) + rest_mps2
        after = max(0.0, v + accel * h)
        mean = 0.5 * (v + after)
        yaw_rate = mean * math.tan(moving[MWHEELS] + turning[0]) / (turning[1] + turning[2] * mean * mean)
        course = moving[MYAW] + 0.5 * yaw_rate * h - turning[3] * mean * yaw_rate
        moving[MX] += mean * math.cos(course) * h
        moving[MY] += mean * math.sin(course) * h
        moving[MYAW] = wrap_angle(moving[MYAW] + yaw_rate * h)
        moving[MSPEED] = after
        moving[MS] += mean * h

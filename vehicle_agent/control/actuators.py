"""The vehicle's response to commands: dead times, lags, and the pedals' accelerations.

One kernel propagates the estimate from the last tick to this one, and the vehicle over the commands that have
not taken effect yet.
"""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, wrap_angle

SUBSTEP_S = 0.005
# Entries of a vehicle's state: pose (map), wheel angle (as the steering reports it), throttle and brake in
# effect, speed, distance driven.
MX, MY, MYAW, MWHEELS, MTHROTTLE, MBRAKE, MSPEED, MS = range(8)
VEHICLE_SIZE = 8


class Drivetrain(msgspec.Struct, frozen=True):
    """The identified response. *_delay_s: dead time; *_lag_s: first-order lag.

    throttle_per_mps2  pedal per acceleration at rest
    throttle_fade_mps  speed at which full throttle no longer accelerates, falling linearly to it
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
        """(12,) the parameters for the kernels, in the order of the fields."""
        return np.array(msgspec.structs.astuple(self), dtype=np.float64)

    def with_gains(self, drive_gain: float, brake_gain: float) -> "Drivetrain":
        """The response of a vehicle whose throttle and brake are so many times as strong."""
        return msgspec.structs.replace(
            self,
            throttle_per_mps2=self.throttle_per_mps2 / drive_gain,
            brake_offset=self.brake_offset - self.brake_gain * math.log(brake_gain),
            brake_knee_mps2=self.brake_knee_mps2 * brake_gain,
        )

    def pending_commands_max(self, dt_s: float) -> int:
        """Number of commands that may not have taken effect yet."""
        return math.ceil(max(self.steer_delay_s, self.throttle_delay_s, self.brake_delay_s) / dt_s) + 2


(
    D_STEER_DELAY, D_STEER_LAG, D_THROTTLE_DELAY, D_THROTTLE_LAG, D_BRAKE_DELAY, D_BRAKE_LAG,
    D_PER, D_FADE, D_GAIN, D_OFFSET, D_KNEE, D_COAST,
) = range(12)  # fmt: skip


@njit(cache=True)
def pedal_accel_mps2(throttle: float, brake: float, speed_mps: float, p: Array) -> float:
    """Acceleration of a nominal vehicle on level ground for the pedals in effect; p from `Drivetrain.row`."""
    drive_mps2 = throttle / p[D_PER] * max(0.0, 1.0 - speed_mps / p[D_FADE])
    brake_mps2 = 0.0
    if brake > 0.0:
        brake_mps2 = max(0.0, math.exp((brake - p[D_OFFSET]) / p[D_GAIN]) - p[D_KNEE])
    return float(drive_mps2 - brake_mps2 - p[D_COAST])


@njit(cache=True)
def _command_at(commands: Array, column: int, t_s: float, delay_s: float, dt_s: float) -> float:
    """The command in effect t_s from now; commands (m, 3), one every dt_s, the newest dt_s ago."""
    m = commands.shape[0]
    i = m + math.floor((t_s - delay_s) / dt_s)
    return float(commands[min(max(i, 0), m - 1), column])


@njit(cache=True)
def propagate(
    vehicle: Array, commands: Array, start_s: float, end_s: float, disturbance_mps2: float,
    turn_params: Array, dt_s: float, p: Array,
) -> None:  # fmt: skip
    """Moves the vehicle (VEHICLE_SIZE,) in place from start_s to end_s, both counted from now.

    commands          (m, 3) steering (rad), throttle, brake, as `_command_at` reads them
    disturbance_mps2  acceleration that the pedals do not explain: load, slope, wind
    turn_params       (4,) steering bias (rad), wheelbase (m), K (s2/m m) and rear slip (rad per m/s2) of a
                      steady turn; the tyres settle within 0.1 s and are taken as settled
    """
    steps = round((end_s - start_s) / SUBSTEP_S)
    h = SUBSTEP_S
    for k in range(steps):
        t = start_s + (k + 0.5) * h
        steer = _command_at(commands, 0, t, p[D_STEER_DELAY], dt_s)
        throttle = _command_at(commands, 1, t, p[D_THROTTLE_DELAY], dt_s)
        brake = _command_at(commands, 2, t, p[D_BRAKE_DELAY], dt_s)
        vehicle[MWHEELS] += (steer - vehicle[MWHEELS]) * (1.0 - math.exp(-h / p[D_STEER_LAG]))
        vehicle[MTHROTTLE] += (throttle - vehicle[MTHROTTLE]) * (1.0 - math.exp(-h / p[D_THROTTLE_LAG]))
        vehicle[MBRAKE] += (brake - vehicle[MBRAKE]) * (1.0 - math.exp(-h / p[D_BRAKE_LAG]))
        v = vehicle[MSPEED]
        accel = pedal_accel_mps2(vehicle[MTHROTTLE], vehicle[MBRAKE], v, p) + disturbance_mps2
        after = max(0.0, v + accel * h)
        mean = 0.5 * (v + after)
        yaw_rate = (
            mean
            * math.tan(vehicle[MWHEELS] + turn_params[0])
            / (turn_params[1] + turn_params[2] * mean * mean)
        )
        course = vehicle[MYAW] + 0.5 * yaw_rate * h - turn_params[3] * mean * yaw_rate
        vehicle[MX] += mean * math.cos(course) * h
        vehicle[MY] += mean * math.sin(course) * h
        vehicle[MYAW] = wrap_angle(vehicle[MYAW] + yaw_rate * h)
        vehicle[MSPEED] = after
        vehicle[MS] += mean * h

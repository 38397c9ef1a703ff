"""A program of pedal steps from which a vehicle's response can be identified."""

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array

ACCELERATE, COAST, BRAKE, STAND = 0.0, 1.0, 2.0, 3.0
# Entries of the program's state: the phase, the number of the cycle, the time in the phase.
PHASE, CYCLE, IN_PHASE_S = range(3)
STATE_SIZE = 3


class PedalProgram(msgspec.Struct, frozen=True):
    """Cycles of full pedal steps: accelerate, coast, brake, and in every third cycle stand.

    throttle_ratios, brake_ratios  of the cycles in turn; their numbers have no common factor, so that all
                                   pairs occur
    speed_mps_max, speed_mps_min   a cycle accelerates up to the first and brakes down to the second
    coast_s, stand_s, phase_s_max  durations; a phase that does not reach its speed ends after the last
    """

    throttle_ratios: tuple[float, ...]
    brake_ratios: tuple[float, ...]
    speed_mps_max: float
    speed_mps_min: float = 0.5
    coast_s: float = 1.2
    stand_s: float = 1.0
    phase_s_max: float = 8.0
    hold_ratio: float = 0.5

    def initial(self) -> Array:
        return np.zeros(STATE_SIZE)

    def row(self) -> Array:
        """(6,) speeds and durations for the kernel."""
        return np.array(
            (
                self.speed_mps_max,
                self.speed_mps_min,
                self.coast_s,
                self.stand_s,
                self.phase_s_max,
                self.hold_ratio,
            )
        )


@njit(cache=True)
def program_pedals(
    state: Array, speed_mps: float, dt_s: float, throttles: Array, brakes: Array, p: Array
) -> tuple[float, float]:
    """(throttle, brake) of this tick; advances state (STATE_SIZE,) in place. p from `PedalProgram.row`."""
    phase, cycle, elapsed_s = state[PHASE], int(state[CYCLE]), state[IN_PHASE_S] + dt_s
    stands = cycle % 3 == 2
    ended = elapsed_s >= p[4]
    if phase == ACCELERATE:
        ended = ended or speed_mps >= p[0]
    elif phase == COAST:
        ended = elapsed_s >= p[2]
    elif phase == BRAKE:
        ended = ended or speed_mps <= (0.02 if stands else p[1])
    else:
        ended = elapsed_s >= p[3]
    if ended:
        elapsed_s = 0.0
        if phase == BRAKE and stands:
            phase = STAND
        elif phase in (BRAKE, STAND):
            phase, cycle = ACCELERATE, cycle + 1
        else:
            phase += 1.0
    state[PHASE], state[CYCLE], state[IN_PHASE_S] = phase, float(cycle), elapsed_s
    if phase == ACCELERATE:
        return throttles[cycle % throttles.shape[0]], 0.0
    if phase == BRAKE:
        return 0.0, brakes[cycle % brakes.shape[0]]
    return 0.0, p[5] if phase == STAND else 0.0

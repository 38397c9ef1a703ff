"""Random numbers whose generator is a value: xoshiro256** (Blackman and Vigna 2018), for kernels.

The state is part of the room's state, so that a replay draws the same numbers.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

GeneratorState = NDArray[np.uint64]
_MANTISSA_BITS = 53


def generator(seed: int) -> GeneratorState:
    """(4,) the state for this seed, by splitmix64."""
    mask = (1 << 64) - 1
    state = np.empty(4, dtype=np.uint64)
    z = seed & mask
    for i in range(4):
        z = (z + 0x9E3779B97F4A7C15) & mask
        mixed = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
        mixed = ((mixed ^ (mixed >> 27)) * 0x94D049BB133111EB) & mask
        state[i] = mixed ^ (mixed >> 31)
    return state


@njit(cache=True)
def uniform(state: GeneratorState) -> float:
    """In [0, 1); moves the state on."""
    product = state[1] * np.uint64(5)
    turned = (product << np.uint64(7)) | (product >> np.uint64(57))
    drawn = turned * np.uint64(9)
    shifted = state[1] << np.uint64(17)
    state[2] ^= state[0]
    state[3] ^= state[1]
    state[1] ^= state[2]
    state[0] ^= state[3]
    state[2] ^= shifted
    state[3] = (state[3] << np.uint64(45)) | (state[3] >> np.uint64(19))
    return float(drawn >> np.uint64(64 - _MANTISSA_BITS)) / 9007199254740992.0


@njit(cache=True)
def normal(state: GeneratorState) -> float:
    """Of mean 0 and standard deviation 1 (Box and Muller 1958)."""
    radius = math.sqrt(-2.0 * math.log(1.0 - uniform(state)))
    return radius * math.cos(2.0 * math.pi * uniform(state))

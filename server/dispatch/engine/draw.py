"""Random numbers inside compiled kernels: one 64-bit state that the caller owns, so that a search repeats."""

import numpy as np
from numba import uint64

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import kernel

# SplitMix64 (Steele, Lea, Flood 2014).
_STEP = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_SCALE = 1.0 / 9007199254740992.0


def seeded(seed: int) -> AnyArray:
    """(1,) uint64 state."""
    return np.array([seed % 2**64], dtype=np.uint64)


@kernel
def bits(state: AnyArray) -> np.uint64:
    """The next 64 bits."""
    state[0] += _STEP
    z = state[0]
    z = (z ^ (z >> uint64(30))) * _MIX_1
    z = (z ^ (z >> uint64(27))) * _MIX_2
    return np.uint64(z ^ (z >> uint64(31)))


@kernel
def uniform(state: AnyArray) -> float:
    """In [0, 1)."""
    return np.float64(bits(state) >> uint64(11)) * _SCALE


@kernel
def below(state: AnyArray, n: int) -> int:
    """A whole number in [0, n)."""
    return int(uniform(state) * n)


@kernel
def shuffle(state: AnyArray, items: AnyArray, n: int) -> None:
    """Put the first n items in random order (Fisher and Yates)."""
    for k in range(n - 1, 0, -1):
        other = below(state, k + 1)
        items[k], items[other] = items[other], items[k]

"""Pauses between attempts: they grow, and clients that failed together do not come back together."""

import random
from collections.abc import Iterator

FIRST_S = 0.25
LONGEST_S = 30.0


def pauses(rng: random.Random) -> Iterator[float]:
    """Endless pauses in seconds: a random part of a bound that doubles up to LONGEST_S ("full jitter")."""
    bound_s = FIRST_S
    while True:
        yield rng.uniform(0.0, bound_s)
        bound_s = min(2.0 * bound_s, LONGEST_S)

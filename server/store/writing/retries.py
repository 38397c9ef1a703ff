"""Growing, jittered pauses between attempts, for a bounded time. Time, chance and waiting are parameters."""

import random
import time
from collections.abc import Callable
from dataclasses import dataclass

FIRST_PAUSE_S = 0.05
PAUSE_S_MAX = 1.0
PATIENCE_S = 10.0


def _sleep(seconds: float) -> bool:
    time.sleep(seconds)
    return True


@dataclass(frozen=True, slots=True)
class Retries:
    """pause: waits so many seconds; False when nothing should be tried any more."""

    patience_s: float = PATIENCE_S
    pause: Callable[[float], bool] = _sleep
    chance: Callable[[], float] = random.random
    monotonic_s: Callable[[], float] = time.monotonic

    def begin(self) -> "Patience":
        return Patience(self)


NO_RETRIES = Retries(patience_s=0.0)


class Patience:
    """Of one piece of work, from its first attempt on."""

    def __init__(self, retries: Retries) -> None:
        self._retries = retries
        self._ends_s = retries.monotonic_s() + retries.patience_s
        self._pause_s = FIRST_PAUSE_S

    def wait(self) -> bool:
        """Pause before the next attempt; False without a pause when there is none.

        Each pause is half fixed and half random, so that several servers do not come back all at once.
        """
        left_s = self._ends_s - self._retries.monotonic_s()
        if left_s <= 0.0:
            return False
        pause_s = self._pause_s * (0.5 + 0.5 * self._retries.chance())
        self._pause_s = min(2.0 * self._pause_s, PAUSE_S_MAX)
        return self._retries.pause(min(pause_s, left_s))

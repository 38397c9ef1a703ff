"""How long a vehicle waits before it dials or downloads again. Pure but for the numbers that it draws."""

from collections.abc import Callable

from contract.wire.close_reasons import Retry

# After a farewell with "dial again now", so that vehicles told at one moment do not dial at one moment.
AT_ONCE_WITHIN_S = 0.2
FIRST_WAIT_S = 0.5
LONGEST_WAIT_S = 15.0
# A wait lies between this part of what is due and all of it.
SHORTEST_PART = 0.5


class Redial:
    """The waits of one vehicle: short after a good connection, doubled after each failure in a row."""

    def __init__(
        self, draw: Callable[[], float], first_s: float = FIRST_WAIT_S, longest_s: float = LONGEST_WAIT_S
    ) -> None:
        """draw: a random number from 0 to 1; first_s: due after the first failure; longest_s: at most"""
        self._draw = draw
        self._first_s, self._longest_s = first_s, longest_s
        self._due_s = first_s

    def wait_s(self, *, was_welcomed: bool, retry: Retry = "later") -> float:
        """The wait after a connection, or after an attempt that led to none.

        was_welcomed  the server had opened a session on it
        retry         what its farewell advised
        """
        if was_welcomed:
            self._due_s = self._first_s
            if retry == "at_once":
                return AT_ONCE_WITHIN_S * self._draw()
        due_s = self._due_s
        self._due_s = self._first_s if was_welcomed else min(2.0 * due_s, self._longest_s)
        return due_s * (SHORTEST_PART + (1.0 - SHORTEST_PART) * self._draw())

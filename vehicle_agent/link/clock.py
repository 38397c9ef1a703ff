"""Server clock minus vehicle clock, from question and answer over the link."""

from collections import deque

SAMPLES_MAX = 8


class ClockOffset:
    """The offset of the exchange with the shortest round trip among the last few (RFC 5905, section 10).

    Half the round trip bounds the error of that sample.
    """

    def __init__(self) -> None:
        self.offset_ns = 0
        self.round_trip_ns = -1
        self._samples: deque[tuple[int, int]] = deque(maxlen=SAMPLES_MAX)

    def restart(self, server_ns: int, now_ns: int) -> None:
        """A first, rough value from the welcome, so that an order can be judged at once."""
        self._samples.clear()
        self.offset_ns = server_ns - now_ns
        self.round_trip_ns = -1

    def add(self, asked_ns: int, server_ns: int, answered_ns: int) -> None:
        """One exchange: asked and answered on the vehicle's clock, server_ns on the server's."""
        if answered_ns < asked_ns:
            raise ValueError("an answer cannot come before its question")
        middle_ns = asked_ns + (answered_ns - asked_ns) // 2
        self._samples.append((answered_ns - asked_ns, server_ns - middle_ns))
        self.round_trip_ns, self.offset_ns = min(self._samples)

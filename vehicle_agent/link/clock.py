"""Server clock minus vehicle clock, from request and response over the link."""

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
        """Sets a first, rough offset from the welcome, so that an order can be checked at once."""
        self._samples.clear()
        self.offset_ns = server_ns - now_ns
        self.round_trip_ns = -1

    def add(self, sent_ns: int, server_ns: int, received_ns: int) -> None:
        """Adds one exchange: sent and received by the vehicle's clock, server_ns by the server's."""
        if received_ns < sent_ns:
            raise ValueError("a response cannot come before its request")
        middle_ns = sent_ns + (received_ns - sent_ns) // 2
        self._samples.append((received_ns - sent_ns, server_ns - middle_ns))
        self.round_trip_ns, self.offset_ns = min(self._samples)

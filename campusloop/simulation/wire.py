"""The wire between vehicles and the server: streams with latency, which faults cut, delay or repeat."""

import random
from collections.abc import Callable
from dataclasses import dataclass, field

from campusloop.simulation.timeline import Timeline

LATENCY_S = (0.01, 0.06)
# How long a server takes to notice that a silent peer is gone: websocket pings, live.
PEER_TIMEOUT_S = 40.0
# How late frames of a half closed connection arrive, while the vehicle has dialled again.
STRAGGLERS_S = (1.0, 12.0)

Receive = Callable[[bytes], None]
Closed = Callable[[str], None]


@dataclass
class PathState:
    """The network between one vehicle and the server.

    is_up           False: whatever is sent is lost without a word, and no dial succeeds
    delay_s         added to the latency of every frame
    repeat_ratio    this share of the frames arrives twice
    """

    is_up: bool = True
    delay_s: float = 0.0
    repeat_ratio: float = 0.0


@dataclass
class End:
    """One end of a connection; `on_message` and `on_close` are set by its owner."""

    connection: "Connection"
    is_vehicle: bool
    is_open: bool = True
    last_due_ns: int = 0
    on_message: Receive = field(default=lambda _data: None)
    on_close: Closed = field(default=lambda _reason: None)

    def listen(self, on_message: Receive, on_close: Closed) -> None:
        self.on_message, self.on_close = on_message, on_close

    def send(self, data: bytes) -> None:
        if self.is_open:
            self.connection.carry(self, data)

    def close(self, code: int, reason: str) -> None:
        """An orderly close: frames sent before it still arrive."""
        if self.is_open:
            self.is_open = False
            self.connection.carry_close(self, f"{code} {reason}")


class Connection:
    """Frames arrive whole and in order, at each end until that end is closed."""

    def __init__(self, timeline: Timeline, path: PathState, rng: random.Random) -> None:
        self._timeline, self._path, self._rng = timeline, path, rng
        self.vehicle = End(self, is_vehicle=True)
        self.server = End(self, is_vehicle=False)

    def carry(self, sender: End, data: bytes) -> None:
        if not self._path.is_up:
            return
        receiver = self._other(sender)
        for _ in range(2 if self._rng.random() < self._path.repeat_ratio else 1):
            self._timeline.at(self._due_ns(sender), lambda: self._deliver(receiver, data))

    def carry_close(self, closer: End, reason: str) -> None:
        receiver = self._other(closer)
        if self._path.is_up:
            self._timeline.at(self._due_ns(closer), lambda: self._end(receiver, reason))
        else:
            self._timeline.after(PEER_TIMEOUT_S, lambda: self._end(receiver, "nothing heard"))

    def cut(self) -> None:
        """Both ends learn of it now; frames under way are lost."""
        self._end(self.vehicle, "cut")
        self._end(self.server, "cut")

    def half_close(self) -> None:
        """The vehicle learns of it now. What it has sent arrives late; it may be connected again by then."""
        stragglers_s = self._rng.uniform(*STRAGGLERS_S)
        self.server.last_due_ns = max(self.server.last_due_ns, self._timeline.now_ns)
        self._end(self.vehicle, "reset")
        self._timeline.after(stragglers_s, lambda: self._end(self.server, "reset by peer"))

    def _deliver(self, receiver: End, data: bytes) -> None:
        if receiver.is_open:
            receiver.on_message(data)

    def _end(self, end: End, reason: str) -> None:
        if end.is_open:
            end.is_open = False
            end.on_close(reason)

    def _due_ns(self, sender: End) -> int:
        latency_s = self._rng.uniform(*LATENCY_S) + self._path.delay_s
        sender.last_due_ns = max(self._timeline.now_ns + round(latency_s * 1e9), sender.last_due_ns)
        return sender.last_due_ns

    def _other(self, end: End) -> End:
        return self.server if end is self.vehicle else self.vehicle

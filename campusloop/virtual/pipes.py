"""The in-memory wire: message pipes with a seeded latency, under the same sessions as real sockets."""

from collections.abc import Callable

import numpy as np

from campusloop.virtual.conductor import Conductor

Receive = Callable[[bytes], None]
Closed = Callable[[str], None]


class PipeEnd:
    """One side of a pipe. Messages arrive whole, once and in order, until the pipe is cut."""

    def __init__(self, name: str, pipe: "Pipe") -> None:
        self.name = name
        self._pipe = pipe
        self.on_message: Receive = self._unexpected
        self.on_close: Closed = lambda _reason: None

    def send(self, data: bytes) -> None:
        self._pipe.carry(self, data)

    def close(self, reason: str) -> None:
        self._pipe.close(self, reason)

    def _unexpected(self, data: bytes) -> None:
        raise AssertionError(f"{self.name}: no receiver, got {data[:80]!r}")


class Pipe:
    """Two ends, a latency for each message, and a `cut` that loses the messages under way."""

    def __init__(
        self, conductor: Conductor, name: str, latency_s: tuple[float, float] = (0.01, 0.06)
    ) -> None:
        self.left = PipeEnd(f"{name}/left", self)
        self.right = PipeEnd(f"{name}/right", self)
        self.is_open = True
        self._conductor = conductor
        self._rng: np.random.Generator = conductor.rng(f"pipe/{name}")
        self._latency_s = latency_s
        self._last_due_ns = {self.left.name: 0, self.right.name: 0}

    def carry(self, sender: PipeEnd, data: bytes) -> None:
        if not self.is_open:
            return
        receiver = self._other(sender)
        self._post(sender, lambda: receiver.on_message(data))

    def close(self, closer: PipeEnd, reason: str) -> None:
        """An orderly close: messages sent before it still arrive."""
        receiver = self._other(closer)

        def end() -> None:
            self.is_open = False
            receiver.on_close(reason)

        if self.is_open:
            self._post(closer, end)

    def cut(self, reason: str = "cut") -> None:
        """The network fails: both ends are closed now, and messages under way are lost."""
        if self.is_open:
            self.is_open = False
            self.left.on_close(reason)
            self.right.on_close(reason)

    def _post(self, sender: PipeEnd, action: Callable[[], None]) -> None:
        latency_ns = round(self._rng.uniform(*self._latency_s) * 1e9)
        due_ns = max(self._conductor.now_ns + latency_ns, self._last_due_ns[sender.name])
        self._last_due_ns[sender.name] = due_ns

        def deliver() -> None:
            if self.is_open:
                action()

        self._conductor.post(sender.name, due_ns, deliver)

    def _other(self, end: PipeEnd) -> PipeEnd:
        return self.right if end is self.left else self.left

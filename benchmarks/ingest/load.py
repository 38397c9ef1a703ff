"""The load generator: one loop over all sockets, so that it costs less than the server that it measures."""

import gc
import select
import socket
import time
from collections.abc import Callable, Sequence

from benchmarks.ingest.connections import Connection, VehicleConnection

_DIALLED_AT_A_TIME = 100
_POLL_MS_MAX = 2
_FROZEN_BYTES = 32 * 1024


class LoadFailed(Exception):
    """A connection ended, or did not open in time."""


def _fail(connection: Connection) -> None:
    raise LoadFailed(f"a connection ended: {connection.ended}")


class Sockets:
    """Every connection of the generator, and the loop that reads them."""

    def __init__(self, on_end: Callable[[Connection], None] = _fail) -> None:
        """on_end: called when a connection has ended; it raises LoadFailed, or removes the connection"""
        self._on_end = on_end
        self._poll = select.epoll()
        self._by_descriptor: dict[int, Connection] = {}

    def add(self, connection: Connection) -> None:
        descriptor = connection.socket.fileno()
        self._by_descriptor[descriptor] = connection
        self._poll.register(descriptor, select.EPOLLIN | select.EPOLLOUT)

    def freeze(self, connection: Connection) -> None:
        """Read it no more, and keep it open. The kernel's buffer is small, so that the server notices."""
        connection.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _FROZEN_BYTES)
        self._poll.unregister(connection.socket.fileno())

    def turn(self, timeout_ms: float) -> None:
        """Handle what can be read or written now."""
        ready = self._poll.poll(timeout_ms / 1e3)
        now_s = time.perf_counter()
        for descriptor, events in ready:
            connection = self._by_descriptor[descriptor]
            if events & select.EPOLLOUT:
                connection.flush()
                if not connection.has_unsent:
                    self._poll.modify(descriptor, select.EPOLLIN)
            if events & ~select.EPOLLOUT:
                connection.readable(now_s)
            if connection.ended:
                self._on_end(connection)

    def remove(self, connection: Connection) -> None:
        """Close it and forget it."""
        descriptor = connection.socket.fileno()
        self._poll.unregister(descriptor)
        del self._by_descriptor[descriptor]
        connection.socket.close()

    def send(self, connection: Connection, payload: bytes) -> None:
        connection.send(payload)
        if connection.has_unsent:
            self._poll.modify(connection.socket.fileno(), select.EPOLLIN | select.EPOLLOUT)

    def close(self) -> None:
        for connection in self._by_descriptor.values():
            connection.socket.close()
        self._poll.close()


def open_all(
    sockets: Sockets, dial: Callable[[int], VehicleConnection], count: int, within_s: float
) -> list[VehicleConnection]:
    """That many open sessions, a hundred dialled at a time. Raises LoadFailed."""
    opened: list[VehicleConnection] = []
    waiting: list[VehicleConnection] = []
    until_s = time.perf_counter() + within_s
    while len(opened) < count:
        while len(waiting) < _DIALLED_AT_A_TIME and len(opened) + len(waiting) < count:
            connection = dial(len(opened) + len(waiting))
            sockets.add(connection)
            waiting.append(connection)
        sockets.turn(_POLL_MS_MAX)
        opened += [connection for connection in waiting if connection.is_open]
        waiting = [connection for connection in waiting if not connection.is_open]
        if time.perf_counter() > until_s:
            raise LoadFailed(f"only {len(opened)} of {count} sessions opened within {within_s:.0f} s")
    return sorted(opened, key=lambda connection: connection.number)


class Beat:
    """Something that is due so many times a second, evenly."""

    def __init__(self, begins_s: float, per_s: float, act: Callable[[int, float], None]) -> None:
        self._begins_s, self._per_s, self._act = begins_s, per_s, act
        self._number = 0

    def catch_up(self, now_s: float) -> None:
        """Do what is due by now, each with the moment at which it was due."""
        due = int((now_s - self._begins_s) * self._per_s)
        while self._number < due:
            self._act(self._number, self._begins_s + self._number / self._per_s)
            self._number += 1


def run_beats(sockets: Sockets, beats: Sequence[Beat], until_s: float) -> None:
    """Send what is due and read what comes, until then."""
    gc.disable()
    try:
        while (now_s := time.perf_counter()) < until_s:
            for beat in beats:
                beat.catch_up(now_s)
            sockets.turn(1)
    finally:
        gc.enable()

"""Numbered events that survive any cut: at-least-once delivery, exactly-once effect. No I/O here.

`EventLog` is the vehicle's side: it numbers, keeps and repeats. `is_new` is the server's side: it lets
each (boot, sequence) through once and in order. The callers persist what they return.
"""

from collections import deque
from collections.abc import Iterable

import msgspec

from contract.wire.messages import EventLogState, VehicleEvent


class LoggedEvent(msgspec.Struct, frozen=True):
    boot_id: str
    sequence: int
    stamp_ns: int
    body: VehicleEvent


class EventLog:
    """Unacknowledged events of this boot and of earlier ones, oldest boot first.

    Earlier boots' events keep their boot_id, so that the server never takes one twice.
    """

    def __init__(self, boot_id: str, earlier: Iterable[LoggedEvent] = ()) -> None:
        self.boot_id = boot_id
        self._kept: dict[str, deque[LoggedEvent]] = {}
        self._next = 0
        for event in earlier:
            if event.boot_id == boot_id:
                raise ValueError("a boot_id must be new for every boot")
            self._kept.setdefault(event.boot_id, deque()).append(event)
        self._kept[boot_id] = deque()

    def append(self, stamp_ns: int, body: VehicleEvent) -> LoggedEvent:
        """Number the event; persist what comes back before it is sent."""
        event = LoggedEvent(self.boot_id, self._next, stamp_ns, body)
        self._next += 1
        self._kept[self.boot_id].append(event)
        return event

    def acknowledge(self, boot_id: str, next_sequence: int) -> int:
        """Forget what the server has stored; returns how many events that were. Repeats are harmless."""
        kept = self._kept.get(boot_id)
        if kept is None:
            return 0
        forgotten = 0
        while kept and kept[0].sequence < next_sequence:
            kept.popleft()
            forgotten += 1
        if not kept and boot_id != self.boot_id:
            del self._kept[boot_id]
        return forgotten

    def logs(self) -> tuple[EventLogState, ...]:
        """For the hello: where each boot's unacknowledged events begin and end."""
        return tuple(
            EventLogState(boot_id, kept[0].sequence, kept[-1].sequence + 1)
            if kept
            else EventLogState(boot_id, self._next, self._next)
            for boot_id, kept in self._kept.items()
        )

    def pending(self) -> list[LoggedEvent]:
        """Everything to (re)send, oldest boot first, in order."""
        return [event for kept in self._kept.values() for event in kept]


class SequenceGap(Exception):
    """An event came before its predecessor: the sender must repeat from `expected`."""

    def __init__(self, boot_id: str, expected: int, got: int) -> None:
        super().__init__(f"boot {boot_id}: expected event {expected}, got {got}")
        self.boot_id, self.expected, self.got = boot_id, expected, got


def is_new(expected: int, boot_id: str, sequence: int) -> bool:
    """Server's side: is this event the next one (True), or one already taken (False)?

    expected   how many events of this boot are stored
    Raises SequenceGap when events between are missing: nothing is taken out of order.
    """
    if sequence > expected:
        raise SequenceGap(boot_id, expected, sequence)
    return sequence == expected

"""Traces of rides: what server, link, tick and gate did for one ride, from its booking to a CAN frame.

The ids of a trace are made of the ride's id. So every process adds to the same trace, and nothing about it is
on the wire.
"""

import hashlib
from collections.abc import Iterable
from typing import Protocol

import msgspec

from contract.wire.messages import Order

BOOKING = "booking"
# So many (ride, step) pairs are remembered, so that a repeated order makes no second span.
REMEMBERED_MAX = 10_000


class Span(msgspec.Struct, frozen=True):
    """One step of a ride, in nanoseconds of UTC. parent_id is empty for the booking, which is the root.

    trace_id, span_id, parent_id  32, 16 and 16 hexadecimal digits
    """

    trace_id: str
    span_id: str
    parent_id: str
    name: str
    begin_ns: int
    end_ns: int
    attributes: dict[str, str]


class Spans(Protocol):
    """Takes the spans of one process. None of its calls waits."""

    def add(self, span: Span) -> None: ...

    def close(self) -> None:
        """Send what is left; the process ends."""
        ...


class SpanSource(Protocol):
    """Opens a process's spans; can be pickled."""

    def open(self, process: str) -> Spans | None:
        """None: nothing is traced."""
        ...


class NoSpans(msgspec.Struct, frozen=True):
    """Nothing is traced, and nothing of it costs anything."""

    def open(self, process: str) -> Spans | None:
        return None


NO_SPANS = NoSpans()


class RideSpans:
    """Makes the spans of rides, each step of a ride once.

    attributes  of all of them, e.g. the vehicle
    """

    def __init__(self, spans: Spans, **attributes: str) -> None:
        self._spans, self._attributes = spans, attributes
        self._remembered: dict[tuple[str, str, str], None] = {}

    def add(
        self, ride_ids: Iterable[str], name: str, begin_ns: int, end_ns: int, **attributes: str
    ) -> tuple[str, ...]:
        """The rides for which this step is new: each has a span of it now."""
        known = self._attributes | attributes
        fresh = tuple(ride_id for ride_id in ride_ids if self._is_new(ride_id, name, known))
        for ride_id in fresh:
            is_root = name == BOOKING
            span_id = root_id_of(ride_id) if is_root else _hex(16, ride_id, name, known.get("vehicle_id", ""))
            parent_id = "" if is_root else root_id_of(ride_id)
            fields = {"ride_id": ride_id, **known}
            self._spans.add(
                Span(trace_id_of(ride_id), span_id, parent_id, name, begin_ns, max(begin_ns, end_ns), fields)
            )
        return fresh

    def _is_new(self, ride_id: str, name: str, attributes: dict[str, str]) -> bool:
        key = (ride_id, name, attributes.get("vehicle_id", ""))
        if key in self._remembered:
            return False
        self._remembered[key] = None
        if len(self._remembered) > REMEMBERED_MAX:
            del self._remembered[next(iter(self._remembered))]
        return True


def trace_id_of(ride_id: str) -> str:
    return _hex(32, "trace", ride_id)


def root_id_of(ride_id: str) -> str:
    """Of the booking's span."""
    return _hex(16, "root", ride_id)


def rides_of(order: Order) -> tuple[str, ...]:
    """The rides that the order serves, each once, in the order of its visits."""
    riders = (rider.ride_id for visit in order.visits for rider in (*visit.board, *visit.alight))
    return tuple(dict.fromkeys(riders))


def _hex(digits: int, *parts: str) -> str:
    return hashlib.sha256("\n".join(("campusloop", *parts)).encode()).hexdigest()[:digits]

"""What a link needs from outside: a transport, and the hub's ports."""

from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from contract.tracing import RideSpans
from contract.wire.messages import CameraPicture, EventReport, OnboardScene
from server.domain.fleet.vehicles import StatusReport
from server.fleet.refused_hellos import RefusedHellos
from server.usecases.ports.clock_and_ids import Clock
from server.usecases.ports.unit_of_work import Transactions

# The link itself, which imports this file.
L = TypeVar("L")


class Transport(Protocol):
    """A message pipe. Both calls return at once; `close` lets what was sent before it still go out."""

    def send(self, data: bytes) -> None: ...

    def close(self, code: int, reason: str) -> None: ...


@dataclass(frozen=True, slots=True)
class LinkPorts(Generic[L]):
    """What a link needs from the hub: ports and callbacks.

    spawn   runs the link's task; when that fails, the link is ended
    opened  registers the link
    ended   forgets the link, and records that its session has ended
    spans   of rides whose orders are sent; None: they are not traced
    store   takes an event and when it came; `events_stored` or `events_refused` follows
    """

    clock: Clock
    transactions: Transactions
    spawn: Callable[[str, Coroutine[Any, Any, None], L], None]
    opened: Callable[[L], None]
    ended: Callable[[L], None]
    store: Callable[[L, EventReport, int], None]
    note_status: Callable[[StatusReport], None]
    note_scene: Callable[[str, OnboardScene], None]
    note_picture: Callable[[str, CameraPicture], None]
    hello_timeout_s: float
    refused: RefusedHellos
    spans: RideSpans | None = None

"""One vehicle's outbox and session, in the order that loses nothing.

The mission's memory is on disk before an order is accepted. An event is on disk before it is sent. Messages
of the server reach the tick as inbox items.
"""

from pathlib import Path

import msgspec
import structlog

from contract.wire.messages import (
    OnboardScene,
    OrderAccepted,
    OrderProgress,
    OrderRejected,
    Status,
    VehicleEvent,
)
from vehicle_agent.link.outbox import Outbox
from vehicle_agent.link.session import Identity, Sign, VehicleSession

log = structlog.get_logger()


class TickUpdate(msgspec.Struct, frozen=True):
    """A tick's data for the link; sent only in ticks that have some.

    memory    the mission's memory, MessagePack, when it has changed
    progress  the order's progress for the next hello, when memory has changed
    scene     for an operator who asked for it
    """

    stamp_ns: int
    report: Status | None = None
    events: tuple[VehicleEvent, ...] = ()
    answers: tuple[OrderAccepted | OrderRejected, ...] = ()
    memory: bytes | None = None
    progress: OrderProgress | None = None
    scene: OnboardScene | None = None


class LinkBridge:
    """Writes a vehicle's events and memory to its outbox before its session sends them."""

    def __init__(
        self,
        folder: Path,
        identity: Identity,
        sign: Sign,
        progress: OrderProgress | None = None,
        *,
        sync: bool = True,
    ) -> None:
        self._outbox = Outbox(folder, identity.boot_id, sync=sync)
        self.session = VehicleSession(identity, sign, self._outbox.log, progress)

    def process_update(self, update: TickUpdate, now_ns: int) -> None:
        """All three steps at once, for a caller that may block (virtual time)."""
        lines = self.number_events(update)
        self.write(update, lines)
        self.send(update, now_ns)

    def number_events(self, update: TickUpdate) -> bytes:
        """First step: numbers the events; returns the lines for `write`."""
        return self._outbox.number_events(update.stamp_ns, update.events)

    def write(self, update: TickUpdate, lines: bytes) -> None:
        """Second step, blocking: writes memory and events to disk; lines: from `number_events`.

        Raises OSError, e.g. for a full disk; it may be repeated.
        """
        if update.memory is not None:
            self._outbox.save_memory(update.memory, lines)
        self._outbox.write(lines)

    def send(self, update: TickUpdate, now_ns: int) -> None:
        """Third step: hands everything to the session."""
        if update.memory is not None:
            self.session.progress = update.progress
        if update.events:
            self.session.send_new_events(now_ns)
            try:
                self._outbox.compact()
            except OSError as error:
                log.warning("outbox.not_compacted", error=str(error))
        for answer in update.answers:
            self.session.answer(answer)
        if update.report is not None:
            self.session.report(update.report)
        if update.scene is not None:
            self.session.show(update.scene)

    def close(self) -> None:
        self._outbox.close()

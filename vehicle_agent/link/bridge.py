"""The link process's desk for one vehicle: everything between the tick and the server that needs a disk.

Order matters and is the point of this file: the mission's memory is on disk before an order is accepted,
an event is on disk before it is sent, and what the server says reaches the tick as inbox items.
"""

from pathlib import Path

import msgspec

from contract.wire.messages import OrderAccepted, OrderProgress, OrderRejected, Status, VehicleEvent
from vehicle_agent.link.outbox import Outbox
from vehicle_agent.link.session import Identity, Sign, VehicleSession
from vehicle_agent.signals import LinkMessage


class TickUpdate(msgspec.Struct, frozen=True):
    """What a tick tells the link: only in ticks that have something to tell.

    memory   the mission's memory, MessagePack, when it has changed
    progress  what the vehicle follows, for the next hello, when memory has changed
    """

    stamp_ns: int
    report: Status | None = None
    events: tuple[VehicleEvent, ...] = ()
    answers: tuple[OrderAccepted | OrderRejected, ...] = ()
    memory: bytes | None = None
    progress: OrderProgress | None = None


class LinkBridge:
    """One vehicle's outbox and session, wired in the only order that loses nothing."""

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

    def tick_news(self, news: TickUpdate, now_ns: int) -> None:
        """All three steps at once, for who may block (virtual time)."""
        lines = self.number(news)
        self.write(news, lines)
        self.speak(news, now_ns)

    def number(self, news: TickUpdate) -> bytes:
        """First: the events get their numbers."""
        return self._outbox.number(news.stamp_ns, news.events)

    def write(self, news: TickUpdate, lines: bytes) -> None:
        """Second, and blocking: to disk. `lines` is what `number` gave for this news."""
        if news.memory is not None:
            self._outbox.save_memory(news.memory)
        self._outbox.write(lines)

    def speak(self, news: TickUpdate, now_ns: int) -> None:
        """Third: to the wire."""
        if news.memory is not None:
            self.session.progress = news.progress
        if news.events:
            self.session.happened(now_ns)
            self._outbox.shrink()
        for answer in news.answers:
            self.session.answer(answer)
        if news.report is not None:
            self.session.report(news.report)

    def take_words(self) -> list[LinkMessage]:
        return self.session.take_words()

    def close(self) -> None:
        self._outbox.close()

"""One vehicle's connection: a session, its transport, and the task that performs the session's actions."""

import asyncio
import base64
import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import structlog

from contract.geometry import Pose2
from contract.wire.close_reasons import CloseCode, close_reason
from contract.wire.codec import encode
from contract.wire.messages import (
    EventLogState,
    EventReport,
    FleetVehicle,
    Goodbye,
    Hello,
    OrderAccepted,
    OrderRejected,
    Presence,
    Status,
)
from contract.wire.sequence import SequenceGap
from server.domain.errors import KeyUnknown, OrderUnknown, SessionFenced, VehicleUnknown
from server.domain.fleet.vehicles import StatusReport
from server.domain.instants import ns_of
from server.domain.record.events import RecordedEvent
from server.fleet.actions import (
    Action,
    Close,
    FindKey,
    NoteAnswer,
    NoteStatus,
    OpenSession,
    ReportViolation,
    Send,
    StoreEvent,
)
from server.fleet.backlog import Backlog
from server.fleet.sent_messages import SentMessages
from server.fleet.session import Actions, VehicleSession
from server.usecases.fleet import events, quarantine, vehicle_sessions, vehicles
from server.usecases.fleet.vehicle_sessions import HelloFacts
from server.usecases.orders import orders, outbox
from server.usecases.ports.clock_and_ids import Clock
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork

FRAMES_WAITING_MAX = 200

log = structlog.get_logger("fleet.link")


class _QueueItem(enum.Enum):
    """Items in the queue of frames that are not frames."""

    PUSH = "push"
    GONE = "gone"


class Transport(Protocol):
    """A message pipe. Both calls return at once; `close` lets what was sent before it still go out."""

    def send(self, data: bytes) -> None: ...

    def close(self, code: int, reason: str) -> None: ...


@dataclass(frozen=True, slots=True)
class LinkPorts:
    """What a link needs from the hub: ports and callbacks.

    opened  registers the link
    ended   forgets the link, and records that its session has ended
    """

    clock: Clock
    transactions: Transactions
    opened: "Callable[[Link], None]"
    ended: "Callable[[Link], None]"
    note_status: Callable[[StatusReport], None]
    note_event: Callable[[str, EventReport], None]
    hello_timeout_s: float


class Link:
    """`received` takes the frames, in order; `run` handles them and everything else, one at a time."""

    def __init__(self, nonce: str, transport: Transport, ports: LinkPorts) -> None:
        self.session = VehicleSession(nonce)
        self._transport = transport
        self._ports = ports
        self._frames: asyncio.Queue[bytes | str | _QueueItem] = asyncio.Queue()
        self._room = asyncio.Event()
        self._push_due = False
        self._backlog = Backlog()
        self._sent = SentMessages()

    @property
    def vehicle_id(self) -> str:
        return self.session.vehicle_id

    @property
    def awaits_answers(self) -> bool:
        return self._sent.unanswered or self._backlog.is_waiting

    # ---------------------------------------------------------------- called by transport and hub

    def received(self, data: bytes | str) -> None:
        self._frames.put_nowait(data)

    def closed(self, reason: str) -> None:
        """The transport is gone."""
        log.info("link.closed", vehicle_id=self.vehicle_id, reason=reason)
        self._frames.put_nowait(_QueueItem.GONE)

    async def ready(self) -> None:
        """Wait until there is room for another frame: a fast sender is slowed down, not buffered."""
        if self._frames.qsize() > FRAMES_WAITING_MAX:
            self._room.clear()
            await self._room.wait()

    def push(self) -> None:
        """Send the outbox soon; repeated calls before that have no further effect."""
        if not self._push_due:
            self._push_due = True
            self._frames.put_nowait(_QueueItem.PUSH)

    def send_fleet_vehicle(self, vehicle_id: str, pose_map: Pose2, speed_mps: float) -> None:
        """Send the position of a fleet vehicle; dropped while the session is not open."""
        self._send(FleetVehicle(self.session.epoch, vehicle_id, self._now_ns(), pose_map, speed_mps))

    def send_presence(self, area_id: str, count: int, seen_ns: int) -> None:
        """Send a camera's report on an area; dropped while the session is not open."""
        self._send(Presence(self.session.epoch, area_id, seen_ns, count))

    def _send(self, message: FleetVehicle | Presence) -> None:
        for action in self.session.send(message):
            assert isinstance(action, Send)
            self._transport.send(encode(action.message))

    def end(self, code: CloseCode, detail: str) -> None:
        """Say goodbye from outside the link's own task."""
        for action in self.session.close(code, detail):
            assert isinstance(action, Close)
            self._say_goodbye(action)

    async def run(self) -> None:
        """Run until the session is closed or the transport is gone."""
        for action in self.session.begin(self._now_ns()):
            await self._perform(action)
        try:
            await self._take_frames()
        finally:
            self._room.set()
            self._ports.ended(self)

    # ---------------------------------------------------------------- the link's own task

    async def _take_frames(self) -> None:
        deadline = asyncio.get_running_loop().time() + self._ports.hello_timeout_s
        while self.session.state != "closed":
            if self._frames.empty():
                self._room.set()
            frame = await self._next_frame(deadline)
            if frame is _QueueItem.GONE:
                return
            try:
                await self._handle(frame)
            except SessionFenced as error:
                self.end("superseded", error.detail)
            except (KeyUnknown, VehicleUnknown) as error:
                self.end("key_unknown", error.detail)

    async def _next_frame(self, hello_deadline: float) -> bytes | str | _QueueItem:
        if self.session.state == "open":
            return await self._frames.get()
        try:
            async with asyncio.timeout_at(hello_deadline):
                return await self._frames.get()
        except TimeoutError:
            self.end("hello_late", f"no hello within {self._ports.hello_timeout_s:.0f} s")
            return _QueueItem.GONE

    async def _handle(self, frame: bytes | str | _QueueItem) -> None:
        if isinstance(frame, _QueueItem):
            self._push_due = False
            await self._push_outbox()
        else:
            await self._perform_all(self.session.received(frame, self._now_ns()))

    async def _perform_all(self, actions: Actions) -> None:
        for action in actions:
            await self._perform(action)

    async def _perform(self, action: Action) -> None:
        if isinstance(action, Send):
            self._transport.send(encode(action.message))
        elif isinstance(action, Close):
            self._say_goodbye(action)
        elif isinstance(action, FindKey):
            await self._find_key(action.vehicle_id)
        elif isinstance(action, OpenSession):
            await self._open(action.hello)
        elif isinstance(action, StoreEvent):
            await self._store(action.report)
        elif isinstance(action, ReportViolation):
            await self._report_violation(action.detail)
        elif isinstance(action, NoteStatus):
            self._note(action.status)
        elif isinstance(action, NoteAnswer):
            await self._answer(action.answer)

    async def _find_key(self, vehicle_id: str) -> None:
        key = await self._ports.transactions.run(lambda uow: vehicles.key_of(uow, vehicle_id))
        await self._perform_all(self.session.key_found(base64.b64decode(key)))

    async def _open(self, hello: Hello) -> None:
        conflict = await self._ports.transactions.run(
            lambda uow: vehicle_sessions.key_conflict(uow, hello.vehicle_id, hello.boot_id)
        )
        if conflict:
            self.end("key_conflict", conflict)
            return
        facts = _facts(hello)
        opened = await self._ports.transactions.run(lambda uow: vehicle_sessions.open_session(uow, facts))
        acknowledged = dict(opened.acknowledged)
        self._backlog.begin(hello.event_logs, acknowledged, self._now_ns())
        welcome = self.session.welcomed(opened.epoch, _boot_logs(acknowledged), self._now_ns())
        await self._perform_all(welcome)
        log.info("link.opened", vehicle_id=self.vehicle_id, epoch=opened.epoch, boot_id=self.session.boot_id)
        self._ports.opened(self)
        await self._push_outbox()

    async def _store(self, report: EventReport) -> None:
        event = RecordedEvent(
            self.vehicle_id, report.boot_id, report.sequence, report.stamp_ns, self._now_ns(), report.body
        )
        try:
            stored = await self._ports.transactions.run(lambda uow: self._apply(uow, event))
        except SequenceGap as gap:
            await self._perform_all(self.session.events_stored(gap.boot_id, gap.expected))
            return
        await self._perform_all(self.session.events_stored(report.boot_id, stored.next_sequence))
        if stored.is_new:
            self._ports.note_event(self.vehicle_id, report)
        if self._backlog.stored(report.boot_id, stored.next_sequence):
            await self._push_outbox()

    def _apply(self, uow: UnitOfWork, event: RecordedEvent) -> events.EventResult:
        vehicle_sessions.require_epoch(uow, self.vehicle_id, self.session.epoch)
        return events.apply_event(uow, event)

    async def _report_violation(self, detail: str) -> None:
        log.warning("link.violation", vehicle_id=self.vehicle_id, detail=detail)
        await self._ports.transactions.run(lambda uow: quarantine.begin(uow, self.vehicle_id, detail))

    def _note(self, status: Status) -> None:
        now = self._ports.clock.now()
        self._ports.note_status(StatusReport(self.vehicle_id, self.session.boot_id, now, status))

    async def _answer(self, answer: OrderAccepted | OrderRejected) -> None:
        def work(uow: UnitOfWork) -> None:
            vehicle_sessions.require_epoch(uow, self.vehicle_id, self.session.epoch)
            if isinstance(answer, OrderAccepted):
                orders.accepted(uow, self.vehicle_id, answer.order_id, answer.revision)
            else:
                orders.rejected(uow, self.vehicle_id, answer)

        try:
            await self._ports.transactions.run(work)
        except OrderUnknown as error:
            # The answer is dropped: the present order is in the outbox and is sent again.
            log.warning("order.unknown", vehicle_id=self.vehicle_id, detail=error.detail)

    async def _push_outbox(self) -> None:
        if self.session.state != "open" or self._backlog.holds_back(self._now_ns()):
            return
        waiting = await self._ports.transactions.run(lambda uow: outbox.outbox_of(uow, self.vehicle_id))
        for message in self._sent.choose(waiting, self._now_ns()):
            await self._perform_all(self.session.send(message))

    def _say_goodbye(self, action: Close) -> None:
        row = close_reason(action.code)
        log.info("link.goodbye", vehicle_id=self.vehicle_id, code=row.code, detail=action.detail)
        self._transport.send(encode(Goodbye(row.code, f"{action.detail}. {row.advice}")))
        self._transport.close(row.number, row.code)
        self._frames.put_nowait(_QueueItem.GONE)

    def _now_ns(self) -> int:
        return ns_of(self._ports.clock.now())


def _boot_logs(acknowledged: Mapping[str, int]) -> tuple[EventLogState, ...]:
    return tuple(EventLogState(boot_id, stored, stored) for boot_id, stored in acknowledged.items())


def _facts(hello: Hello) -> HelloFacts:
    return HelloFacts(
        vehicle_id=hello.vehicle_id,
        boot_id=hello.boot_id,
        software=hello.software,
        stack=hello.stack,
        map_version=hello.map_version,
        logs=hello.event_logs,
        progress=hello.progress,
        seats=hello.seats,
        wheelchair_places=hello.wheelchair_places,
    )

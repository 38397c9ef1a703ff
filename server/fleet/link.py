"""One vehicle's connection: a session, its transport, and what the session's actions need from the server.

What needs no database is done at once, in the call that brought the frame. Events are handed to
`EventIntake`, which stores those of all links together. For anything else one task works, and later frames
wait until it has ended. A link that is only listened to has no task.
"""

import asyncio
import base64
from collections.abc import Callable, Mapping, Sequence

import structlog

from contract.geometry import Pose2
from contract.tracing import rides_of
from contract.wire.bounds import LONG_CHARACTERS_MAX
from contract.wire.close_reasons import CloseCode, close_reason
from contract.wire.codec import encode
from contract.wire.maps import MAPS_SINCE_PROTOCOL
from contract.wire.messages import (
    EventLogState,
    FleetVehicle,
    Goodbye,
    Hello,
    Order,
    OrderAccepted,
    OrderRejected,
    Presence,
    Status,
)
from contract.wire.scans import SCANS_REQUESTED, ScansRequested
from server.domain.errors import KeyUnknown, OrderUnknown, SessionFenced, VehicleUnknown
from server.domain.fleet.vehicles import StatusReport
from server.domain.fleet.vehicles import VehicleSession as OpenedSession
from server.domain.instants import ns_of
from server.fleet.actions import (
    Action,
    Close,
    FindKey,
    NoteAnswer,
    NotePicture,
    NoteScene,
    NoteStatus,
    OpenSession,
    PushOutbox,
    ReportViolation,
    Send,
    StoreEvent,
)
from server.fleet.backlog import Backlog
from server.fleet.hello import facts_of
from server.fleet.link_ports import LinkPorts, Transport
from server.fleet.sent_messages import Announcement, SentMessages
from server.fleet.session import Actions, VehicleSession
from server.usecases.fleet import (
    localization_changes,
    map_changes,
    quarantine,
    scans,
    vehicle_sessions,
    vehicles,
)
from server.usecases.orders import orders, outbox
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import audit

FRAMES_WAITING_MAX = 200

log = structlog.get_logger("fleet.link")


class Link:
    """`begin`, then `received` takes the frames in order, and `closed` the end of the transport."""

    __slots__ = (
        "_address",
        "_backlog",
        "_hello_timer",
        "_is_gone",
        "_is_working",
        "_on_room",
        "_ports",
        "_push_due",
        "_sent",
        "_settled",
        "_transport",
        "_unsettled",
        "_waiting",
        "session",
    )

    def __init__(self, nonce: str, transport: Transport, ports: "LinkPorts[Link]", address: str) -> None:
        self.session = VehicleSession(nonce)
        self._address = address
        self._transport = transport
        self._ports = ports
        self._backlog = Backlog()
        self._sent = SentMessages()
        # Frames that came while the link's task works. Nearly always none; an empty deque takes 600 bytes.
        self._waiting: list[bytes | str] = []
        self._is_working = False
        self._push_due = False
        # The transport is gone, or the hub has been told that the session has ended.
        self._is_gone = False
        # Events that were handed on and are not stored yet; who waits until there is none.
        self._unsettled = 0
        self._settled: asyncio.Future[None] | None = None
        self._on_room: Callable[[], None] | None = None
        self._hello_timer: asyncio.TimerHandle | None = None

    @property
    def vehicle_id(self) -> str:
        return self.session.vehicle_id

    @property
    def awaits_answers(self) -> bool:
        return self._sent.unanswered or self._backlog.is_waiting

    @property
    def is_full(self) -> bool:
        """No further frame should be read before `when_ready`: a fast sender is slowed down, not buffered."""
        return len(self._waiting) + self._unsettled > FRAMES_WAITING_MAX and not self._is_gone

    # ---------------------------------------------------------------- called by transport and hub

    def begin(self) -> None:
        """Send the challenge; a hello must follow in time."""
        loop = asyncio.get_running_loop()
        self._hello_timer = loop.call_later(self._ports.hello_timeout_s, self._hello_is_late)
        self._perform(self.session.begin(self._now_ns()))

    def go_on_with(self, transport: Transport) -> None:
        """The same connection, without what stood in between until now."""
        self._transport = transport

    def received(self, data: bytes | str) -> None:
        if self._is_working:
            self._waiting.append(data)
        else:
            self._perform(self.session.received(data, self._now_ns()))

    def closed(self, reason: str) -> None:
        """The transport is gone."""
        log.info("link.closed", vehicle_id=self.vehicle_id, reason=reason)
        self.session.close("server_leaving", reason)
        self._finish()

    def when_ready(self, call: Callable[[], None]) -> None:
        """Call it, once, when there is room for further frames."""
        self._on_room = call
        self._tell_room()

    def push(self) -> None:
        """Send the outbox soon; repeated calls before that have no further effect."""
        if self._is_working:
            self._push_due = True
        else:
            self._perform((PushOutbox(),))

    def send_fleet_vehicle(self, vehicle_id: str, pose_map: Pose2, speed_mps: float) -> None:
        """Send the position of a fleet vehicle; dropped while the session is not open."""
        now_ns = self._now_ns()
        self._perform(
            self.session.send(FleetVehicle(self.session.epoch, vehicle_id, now_ns, pose_map, speed_mps))
        )

    def send_presence(self, area_id: str, count: int, seen_ns: int) -> None:
        """Send a camera's report on an area; dropped while the session is not open."""
        self._perform(self.session.send(Presence(self.session.epoch, area_id, seen_ns, count)))

    def events_stored(self, next_sequences: Mapping[str, int], handled: int) -> None:
        """handled: so many events were stored, were stored before, or came too early.

        next_sequences  the number that each of their boots continues with
        """
        self._settle(handled)
        is_complete = False
        for boot_id, next_sequence in next_sequences.items():
            self._perform(self.session.events_stored(boot_id, next_sequence))
            is_complete = self._backlog.stored(boot_id, next_sequence) or is_complete
        if is_complete:
            self.push()

    def events_refused(self, code: CloseCode, detail: str, handled: int) -> None:
        """The events are not stored, and the session ends."""
        self._settle(handled)
        self.end(code, detail)

    def end(self, code: CloseCode, detail: str) -> None:
        """Say goodbye from outside the link's own task."""
        self._perform(self.session.close(code, detail))

    # ---------------------------------------------------------------- actions

    def _perform(self, actions: Sequence[Action]) -> None:
        """Perform them; from the first one that needs the database on, in a task."""
        for number, action in enumerate(actions):
            if not self._perform_at_once(action):
                assert not self._is_working, f"{action} while the task of {self.vehicle_id} works"
                self._is_working = True
                self._ports.spawn("link.work", self._work(actions[number:]), self)
                return

    def _perform_at_once(self, action: Action) -> bool:
        """False for an action that has to wait for the database."""
        if isinstance(action, StoreEvent):
            self._unsettled += 1
            self._ports.store(self, action.report, action.received_ns)
        elif isinstance(action, NoteStatus):
            self._note(action.status)
        elif isinstance(action, NoteScene):
            self._ports.note_scene(self.vehicle_id, action.scene)
        elif isinstance(action, NotePicture):
            self._ports.note_picture(self.vehicle_id, action.picture)
        elif isinstance(action, Send):
            self._transport.send(encode(action.message))
        elif isinstance(action, Close):
            self._say_goodbye(action)
        else:
            return False
        return True

    async def _work(self, actions: Sequence[Action]) -> None:
        """Perform the actions, then what came in the meantime."""
        try:
            await self._work_off(actions)
        except SessionFenced as error:
            self._perform(self.session.close("superseded", error.detail))
        except (KeyUnknown, VehicleUnknown) as error:
            is_greeting = self.session.state == "checking"
            self._perform(self.session.close("key_unknown", error.detail))
            if is_greeting:
                await self._record_refusal("key_unknown")
        finally:
            self._is_working = False
            if self.session.state == "closed":
                self._finish()

    async def _work_off(self, actions: Sequence[Action]) -> None:
        while True:
            for action in actions:
                if not self._perform_at_once(action):
                    await self._perform_slowly(action)
            if self.session.state == "closed":
                return
            if self._push_due:
                self._push_due = False
                actions = (PushOutbox(),)
            elif self._waiting:
                actions = self.session.received(self._waiting.pop(0), self._now_ns())
                self._tell_room()
            else:
                return

    async def _perform_slowly(self, action: Action) -> None:
        if isinstance(action, FindKey):
            await self._find_key(action.vehicle_id)
        elif isinstance(action, OpenSession):
            await self._open(action.hello)
        elif isinstance(action, ReportViolation):
            await self._report_violation(action.detail)
        elif isinstance(action, NoteAnswer):
            await self._answer(action.answer)
        elif isinstance(action, PushOutbox):
            await self._push_outbox()

    async def _perform_all(self, actions: Actions) -> None:
        for action in actions:
            if not self._perform_at_once(action):
                await self._perform_slowly(action)

    # ---------------------------------------------------------------- what the actions do

    def _note(self, status: Status) -> None:
        now = self._ports.clock.now()
        self._ports.note_status(StatusReport(self.vehicle_id, self.session.boot_id, now, status))

    def _say_goodbye(self, action: Close) -> None:
        row = close_reason(action.code)
        log.info("link.goodbye", vehicle_id=self.vehicle_id, code=row.code, detail=action.detail)
        # What the vehicle sent may be quoted in it, and may be longer than the wire allows.
        detail = action.detail[: LONG_CHARACTERS_MAX - len(row.advice) - 2]
        self._transport.send(encode(Goodbye(row.code, f"{detail}. {row.advice}")))
        self._transport.close(row.number, row.code)
        self._finish()

    async def _find_key(self, vehicle_id: str) -> None:
        key = await self._ports.transactions.run(lambda uow: vehicles.key_of(uow, vehicle_id))
        actions = self.session.key_found(base64.b64decode(key))
        await self._perform_all(actions)
        if any(isinstance(action, Close) and action.code == "signature_wrong" for action in actions):
            await self._record_refusal("signature_wrong")

    async def _record_refusal(self, code: CloseCode) -> None:
        """Somebody says to be a vehicle and is not: the audit log tells the operators from where."""
        entry = self._ports.refused.entry(self.vehicle_id, self._address, code)
        if entry is not None:
            await self._ports.transactions.run(lambda uow: audit.append(uow, *entry))

    async def _open(self, hello: Hello) -> None:
        facts = facts_of(hello)

        def work(uow: UnitOfWork) -> str | OpenedSession:
            conflict = vehicle_sessions.key_conflict(uow, hello.vehicle_id, hello.boot_id)
            return conflict or vehicle_sessions.open_session(uow, facts)

        opened = await self._ports.transactions.run(work)
        if isinstance(opened, str):
            await self._perform_all(self.session.close("key_conflict", opened))
            return
        acknowledged = dict(opened.acknowledged)
        self._backlog.begin(hello.event_logs, acknowledged, self._now_ns())
        await self._perform_all(self.session.welcomed(opened.epoch, _boot_logs(acknowledged), self._now_ns()))
        if self.session.state == "open":
            epoch, boot_id = opened.epoch, self.session.boot_id
            log.info("link.opened", vehicle_id=self.vehicle_id, epoch=epoch, boot_id=boot_id)
            self._stop_hello_timer()
            self._ports.opened(self)
            await self._push_outbox()

    async def _report_violation(self, detail: str) -> None:
        log.warning("link.violation", vehicle_id=self.vehicle_id, detail=detail)
        await self._ports.transactions.run(lambda uow: quarantine.begin(uow, self.vehicle_id, detail))

    async def _answer(self, answer: OrderAccepted | OrderRejected) -> None:
        def work(uow: UnitOfWork) -> None:
            vehicle_sessions.require_epoch(uow, self.vehicle_id, self.session.epoch)
            if isinstance(answer, OrderAccepted):
                orders.accepted(uow, self.vehicle_id, answer.order_id, answer.revision)
            else:
                orders.rejected(uow, self.vehicle_id, answer)

        await self._events_settled()
        try:
            await self._ports.transactions.run(work)
        except OrderUnknown as error:
            # The answer is dropped: the present order is in the outbox and is sent again.
            log.warning("order.unknown", vehicle_id=self.vehicle_id, detail=error.detail)

    async def _push_outbox(self) -> None:
        await self._events_settled()
        if self.session.state != "open" or self._backlog.holds_back(self._now_ns()):
            return
        begun_ns = self._now_ns()
        waiting, published, areas = await self._ports.transactions.run(self._waiting_messages)
        for message in self._sent.choose(waiting, self._now_ns(), published, areas):
            await self._perform_all(self.session.send(message))
            if self._ports.spans is not None and isinstance(message, Order):
                rides, fields = (
                    rides_of(message),
                    {"vehicle_id": self.vehicle_id, "order_id": message.order_id},
                )
                self._ports.spans.add(rides, "order.sent", begun_ns, self._now_ns(), **fields)

    def _waiting_messages(
        self, uow: UnitOfWork
    ) -> tuple[outbox.Outbox, list[Announcement], ScansRequested | None]:
        published = map_changes.announcement(uow, self.vehicle_id, self._sent.announced)
        if published is not None and self.session.protocol < MAPS_SINCE_PROTOCOL:
            map_changes.note_old_agent(uow, self.vehicle_id)
            published = None
        areas: ScansRequested | None = scans.requested_areas(uow, self.session.epoch)
        if areas is not None and SCANS_REQUESTED not in self.session.understands:
            scans.note_old_agent(uow, self.vehicle_id, areas)
            areas = None
        told: list[Announcement] = [] if published is None else [published]
        by_scans = localization_changes.announcement(uow, self.vehicle_id, self._sent.announced_localization)
        if by_scans is not None:
            told.append(by_scans)
        return outbox.outbox_of(uow, self.vehicle_id, self.session.understands), told, areas

    # ---------------------------------------------------------------- waiting, and the end

    async def _events_settled(self) -> None:
        """What the vehicle reported before is stored first: answers and orders rest on it."""
        if self._unsettled:
            self._settled = asyncio.get_running_loop().create_future()
            await self._settled
            self._settled = None

    def _settle(self, handled: int) -> None:
        self._unsettled -= handled
        if self._unsettled == 0 and self._settled is not None and not self._settled.done():
            self._settled.set_result(None)
        self._tell_room()

    def _tell_room(self) -> None:
        if self._on_room is not None and not self.is_full:
            call, self._on_room = self._on_room, None
            call()

    def _hello_is_late(self) -> None:
        if self.session.state == "challenged":
            self.end("hello_late", f"no hello within {self._ports.hello_timeout_s:.0f} s")

    def _stop_hello_timer(self) -> None:
        if self._hello_timer is not None:
            self._hello_timer.cancel()
            self._hello_timer = None

    def _finish(self) -> None:
        """The session is over: tell the hub once, when the task has ended."""
        if self._is_working or self._is_gone:
            return
        self._is_gone = True
        self._stop_hello_timer()
        self._waiting.clear()
        self._tell_room()
        self._ports.ended(self)

    def _now_ns(self) -> int:
        return ns_of(self._ports.clock.now())


def _boot_logs(acknowledged: Mapping[str, int]) -> tuple[EventLogState, ...]:
    return tuple(EventLogState(boot_id, stored, stored) for boot_id, stored in acknowledged.items())

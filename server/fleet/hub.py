"""All vehicle links of this server process: one open session a vehicle, the newest one.

Transports are anything with `send` and `close`: a websocket live, an in-memory pipe in virtual time.
"""

import asyncio
import math
from collections import deque
from collections.abc import Coroutine
from dataclasses import dataclass

import msgspec
import structlog

from contract.tracing import RideSpans
from contract.wire.codec import decode_from_vehicle, encode
from contract.wire.messages import CameraPicture, EventReport, OnboardScene, Status
from server.domain.fleet.vehicles import StatusReport
from server.fleet.brakings import BrakingWatch, HardBraking
from server.fleet.event_intake import EventIntake
from server.fleet.link import Link
from server.fleet.link_ports import LinkPorts, Transport
from server.fleet.nearby import Nearby
from server.fleet.presence import AreaPresence
from server.fleet.refused_hellos import RefusedHellos
from server.supervision.standing_tasks import PeriodicTask, StandingTask, TopicReader
from server.supervision.supervisor import Supervisor
from server.usecases.fleet import vehicle_sessions
from server.usecases.ports import topics
from server.usecases.ports.bus import Bus
from server.usecases.ports.clock_and_ids import Clock, Ids
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.record.server_events import record_braking

FLUSH_EVERY_S = 0.5
PUSH_EVERY_S = 1.0
# A server that stops has so many vehicles on their way to other servers at a time, and all away after the
# longest time. One that is not taken up for so long is not waited for.
AWAY_MAX = 20
LEAVE_WITHIN_S = 40.0
TAKEN_UP_WITHIN_S = 1.5
LEAVE_STEP_S = 0.02
# Meanwhile it writes seldom: after each of its commits the servers that open sessions read the fleet again.
LEAVING_BATCH_EVERY_S = 0.5
# Shuttles receive each other's positions within this distance: the view ahead and both bodies.
FLEET_VEHICLES_M = 60.0

log = structlog.get_logger("fleet.hub")


@dataclass(frozen=True, slots=True)
class _Job:
    name: str
    link: Link | None = None


class Hub:
    """`start`, then `attach` transports, then `close`."""

    def __init__(
        self,
        campus_id: str,
        clock: Clock,
        ids: Ids,
        transactions: Transactions,
        bus: Bus,
        supervisor: Supervisor,
        hello_timeout_s: float = 10.0,
        spans: RideSpans | None = None,
    ) -> None:
        self.campus_id = campus_id
        self.is_leaving = False
        # When each vehicle was sent away that no other server has taken up yet, and how many were.
        self._away: dict[str, float] = {}
        self._taken_up = 0
        self._supervisor = supervisor
        self._ids, self._transactions, self._bus = ids, transactions, bus
        self._events = EventIntake(transactions, self._note_event)
        self._ports: LinkPorts[Link] = LinkPorts(
            clock=clock,
            transactions=transactions,
            spawn=self._spawn_for,
            opened=self._opened,
            ended=self._ended,
            store=self._events.take,
            note_status=self._note_status,
            note_scene=self._note_scene,
            note_picture=self._note_picture,
            hello_timeout_s=hello_timeout_s,
            refused=RefusedHellos(clock),
            spans=spans,
        )
        self._links: dict[str, Link] = {}
        # In the order in which they came: a set's order differs from run to run.
        self._greeting: dict[Link, None] = {}
        self._outgoing: deque[tuple[str, bytes]] = deque()
        self._is_publishing = False
        self._loop: asyncio.AbstractEventLoop | None = None
        self._nearby = Nearby(FLEET_VEHICLES_M)
        self._statuses: dict[str, StatusReport] = {}
        self._tasks: dict[asyncio.Task[None], _Job] = {}
        self._standing: list[asyncio.Task[None]] = []
        self._ended_sessions: list[tuple[str, int]] = []
        self._braking_watch = BrakingWatch()
        self._brakings: list[HardBraking] = []
        self._record = PeriodicTask("hub.record", self._record_reports, FLUSH_EVERY_S)

    async def start(self) -> None:
        self._loop = asyncio.get_running_loop()
        readers = [
            TopicReader(f"hub.{name}", self._bus, topic, take)
            for name, topic, take in (
                ("outbox", topics.vehicle_outbox(self.campus_id, "*"), self._outbox_changed),
                ("sessions", topics.vehicle_session(self.campus_id, "*"), self._session_opened),
                ("positions", topics.vehicle_live(self.campus_id, "*"), self._vehicle_moved),
                ("presence", topics.area_presence(self.campus_id, "*"), self._presence_seen),
            )
        ]
        for reader in readers:
            await reader.subscribe()
        push = PeriodicTask("hub.push", self._push_unanswered, PUSH_EVERY_S)
        standing: list[StandingTask] = [*readers, self._events, self._record, push]
        self._standing = [self._supervisor.start(task) for task in standing]

    def attach(self, transport: Transport, address: str = "") -> Link:
        """Begin a session on a new transport; the caller uses `received` and `closed` of the link.

        address  of whoever dialled, for the audit log
        """
        link = Link(self._ids.token(), transport, self._ports, address)
        self._greeting[link] = None
        link.begin()
        return link

    def connected(self) -> tuple[str, ...]:
        """Vehicles with an open session here, by id."""
        return tuple(sorted(self._links))

    async def leave(self) -> None:
        """Say goodbye to the vehicles as fast as other servers take them up. None may be attached meanwhile.

        The bus tells of the sessions that other servers open. If they open none, there are none.
        """
        self.is_leaving = True
        self._events.batch_every_s = LEAVING_BATCH_EVERY_S
        loop = asyncio.get_running_loop()
        begun_s = loop.time()
        here = deque((*self._links.values(), *self._greeting))
        count = len(here)
        while here:
            elapsed_s = loop.time() - begun_s
            since_s = loop.time() - TAKEN_UP_WITHIN_S
            self._away = {name: sent_s for name, sent_s in self._away.items() if sent_s > since_s}
            late = count * elapsed_s / LEAVE_WITHIN_S - (count - len(here))
            is_alone = elapsed_s > TAKEN_UP_WITHIN_S and not self._taken_up
            due = len(here) if is_alone else max(AWAY_MAX - len(self._away), math.floor(late))
            for _ in range(min(due, len(here))):
                link = here.popleft()
                if link.vehicle_id:
                    self._away[link.vehicle_id] = loop.time()
                link.end("server_leaving", "the server is stopping")
            await asyncio.sleep(LEAVE_STEP_S)

    async def close(self) -> None:
        """Say goodbye to every vehicle, end all tasks, and store the last statuses."""
        for link in (*self._greeting, *self._links.values()):
            link.end("server_leaving", "the server is stopping")
        links = [task for task, job in self._tasks.items() if job.link is not None]
        if links:
            await asyncio.wait(links)
        rest = [*self._standing, *self._tasks]
        for task in rest:
            task.cancel()
        if rest:
            await asyncio.wait(rest)
        await self._record_reports()

    # ---------------------------------------------------------------- messages of links

    def _opened(self, link: Link) -> None:
        older = self._links.get(link.vehicle_id)
        self._links[link.vehicle_id] = link
        self._greeting.pop(link, None)
        if older is not None:
            older.end("superseded", f"boot {link.session.boot_id} opened a newer session")

    def _ended(self, link: Link) -> None:
        self._greeting.pop(link, None)
        if self._links.get(link.vehicle_id) is link:
            del self._links[link.vehicle_id]
        if link.session.epoch:
            self._ended_sessions.append((link.vehicle_id, link.session.epoch))
            if not self.is_leaving:
                self._record.wake()

    def _note_status(self, report: StatusReport) -> None:
        self._statuses[report.vehicle_id] = report
        braking = self._braking_watch.note(report)
        if braking is not None:
            self._brakings.append(braking)
        topic = topics.vehicle_live(self.campus_id, report.vehicle_id)
        self._publish(topic, encode(report.status))

    def _note_scene(self, vehicle_id: str, scene: OnboardScene) -> None:
        topic = topics.vehicle_scene(self.campus_id, vehicle_id)
        if self._bus.wants(topic):
            self._publish(topic, encode(scene))

    def _note_picture(self, vehicle_id: str, picture: CameraPicture) -> None:
        topic = topics.vehicle_camera(self.campus_id, vehicle_id)
        if self._bus.wants(topic):
            self._publish(topic, encode(picture))

    def _note_event(self, vehicle_id: str, report: EventReport) -> None:
        topic = topics.vehicle_event(self.campus_id, vehicle_id)
        if self._bus.wants(topic):
            self._publish(topic, encode(report))

    def _publish(self, topic: str, payload: bytes) -> None:
        """Soon, and in order. One task publishes what has come until it runs."""
        self._outgoing.append((topic, payload))
        if not self._is_publishing:
            self._is_publishing = True
            self._spawn("hub.publish", self._publish_outgoing())

    async def _publish_outgoing(self) -> None:
        try:
            while self._outgoing:
                await self._bus.publish(*self._outgoing.popleft())
        finally:
            self._is_publishing = False

    # ---------------------------------------------------------------- messages of the bus

    def _outbox_changed(self, topic: str, _: bytes) -> None:
        link = self._links.get(_vehicle_of(topic))
        if link is not None:
            link.push()

    def _session_opened(self, topic: str, payload: bytes) -> None:
        """Another replica may hold the newer session."""
        if self._away.pop(_vehicle_of(topic), None) is not None:
            self._taken_up += 1
        link = self._links.get(_vehicle_of(topic))
        opened = msgspec.json.decode(payload, type=_SessionOpened)
        if link is None or link.session.epoch >= opened.epoch:
            return
        if opened.key_conflict:
            link.end("key_conflict", f"another agent said hello with the key of {link.vehicle_id}")
        else:
            link.end("superseded", f"session {opened.epoch} of {link.vehicle_id} is newer")

    def _vehicle_moved(self, topic: str, payload: bytes) -> None:
        """Send the position to the shuttles near by that are linked to this replica."""
        status = decode_from_vehicle(payload)
        assert isinstance(status, Status), f"{topic} carries a {type(status).__name__}"
        vehicle_id, pose = _vehicle_of(topic), status.pose_map
        for other in self._nearby.move(vehicle_id, pose.x_m, pose.y_m):
            link = self._links.get(other)
            if link is not None:
                link.send_fleet_vehicle(vehicle_id, pose, status.speed_mps)

    def _presence_seen(self, _: str, payload: bytes) -> None:
        """Send the report to the shuttles near the area that are linked to this replica."""
        presence = msgspec.json.decode(payload, type=AreaPresence)
        for vehicle_id in self._nearby.around(presence.x_m, presence.y_m):
            link = self._links.get(vehicle_id)
            if link is not None:
                link.send_presence(presence.area_id, presence.count, presence.stamp_ns)

    # ---------------------------------------------------------------- standing tasks

    async def _record_reports(self) -> None:
        """Store the newest status of each vehicle (the run log has all of them), and which sessions ended.

        What cannot be stored now is kept for the next period.
        """
        statuses, self._statuses = self._statuses, {}
        ended, self._ended_sessions = self._ended_sessions, []
        brakings, self._brakings = self._brakings, []
        if not statuses and not ended:
            return
        reports = [report for _, report in sorted(statuses.items())]

        def work(uow: UnitOfWork) -> None:
            for vehicle_id, epoch in ended:
                vehicle_sessions.close_session(uow, vehicle_id, epoch)
            if reports:
                vehicle_sessions.record_status(uow, reports)
            for braking in brakings:
                record_braking(uow, braking.vehicle_id, braking.at, braking.by)

        try:
            await self._transactions.run(work)
        except Exception:
            self._statuses = statuses | self._statuses
            self._ended_sessions = ended + self._ended_sessions
            self._brakings = brakings + self._brakings
            raise

    async def _push_unanswered(self) -> None:
        for link in self._links.values():
            if link.awaits_answers:
                link.push()

    def _spawn_for(self, name: str, work: Coroutine[object, None, None], link: Link) -> None:
        self._spawn(name, work, link)

    def _spawn(self, name: str, work: Coroutine[object, None, None], link: Link | None = None) -> None:
        # In virtual time frames are delivered between two steps of the loop.
        task = (self._loop or asyncio.get_running_loop()).create_task(work)
        self._tasks[task] = _Job(name, link)
        task.add_done_callback(self._task_done)

    def _task_done(self, task: asyncio.Task[None]) -> None:
        job = self._tasks.pop(task)
        error = None if task.cancelled() else task.exception()
        if error is None:
            return
        log.error("hub.task_failed", task=job.name, exc_info=error)
        if job.link is not None:
            job.link.end("server_fault", "the server failed to handle a frame")
        context = {"message": f"{job.name} failed", "exception": error, "task": task}
        task.get_loop().call_exception_handler(context)


class _SessionOpened(msgspec.Struct, frozen=True):
    epoch: int
    key_conflict: int = 0


def _vehicle_of(topic: str) -> str:
    """Topics are campus/ID/vehicle/ID/..."""
    return topic.split("/")[3]

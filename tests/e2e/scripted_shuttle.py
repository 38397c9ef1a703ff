"""A shuttle that follows its orders over the real websocket, quicker than a real one and without its physics.

Link, way and leave are the agent's own; the wheels, doors and people are this script's. It runs on an
asyncio loop in a thread of its own, so that a test may block on a browser.
"""

import asyncio
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

from contract.geometry import Pose2
from contract.roads.network import RoadNetwork
from contract.wire.camera_picture import ShownCameraState
from contract.wire.messages import (
    LATER_KINDS,
    CameraPicture,
    Command,
    CommandDone,
    DoorsChanged,
    DriveMode,
    FaultRaised,
    FaultReport,
    Grants,
    ModeChanged,
    Order,
    OrderAccepted,
    OrderProgress,
    PassengerTap,
    RiderAlighted,
    RiderBoarded,
    RiderNoShow,
    RiderTask,
    SectionGrant,
    Status,
    TapAnswered,
    VehicleEvent,
    Visit,
    VisitChanged,
    VisitProgress,
    VisitState,
)
from contract.wire.reasons import FaultCode
from tests.e2e.onboard_scene import a_scene
from vehicle_agent.link.bridge import LinkBridge, TickUpdate
from vehicle_agent.link.client import LinkClient
from vehicle_agent.link.keys import load_or_create_key, public_key_text, signature_text
from vehicle_agent.link.session import Identity
from vehicle_agent.mission.memory import MissionMemory
from vehicle_agent.mission.order_line import LanePoint, OrderLine, order_line
from vehicle_agent.mission.sections import (
    OccupiedSection,
    VehicleExtent,
    find_occupied_sections,
    movement_authority,
    release_sections,
)
from vehicle_agent.signals import LinkMessage

STEP_S = 0.2
MARGIN_M = 0.5
FOOTSTEP_M = 1.0
SLACK_M = 0.3
BODY = VehicleExtent(front_m=3.5, back_m=0.85)
PATIENCE_S = 12.0
SCREEN_TO = "→ {name}"
SCREEN_REST = "CAMPUSLOOP"
SHOWN_S = 5.0


@dataclass
class Journey:
    """What the shuttle follows and how far it has got."""

    place: LanePoint
    order: Order | None = None
    line: OrderLine | None = None
    s_m: float = 0.0
    driven_m: float = 0.0
    states: dict[str, VisitState] = field(default_factory=dict)
    grants: tuple[SectionGrant, ...] = ()
    gone: tuple[SectionGrant, ...] = ()
    footing: tuple[OccupiedSection, ...] = ()

    def next_visit(self) -> Visit | None:
        visits = () if self.order is None else self.order.visits
        return next((v for v in visits if self.states[v.visit_id] in ("pending", "under_way")), None)


class ScriptedShuttle:
    """start(), stop(); `speed_mps` may be changed while it drives; 0 makes it stand where it is.

    Its doors stay open at a stop until everybody who has to board or alight there has tapped, or until its
    patience is over: then who is missing did not show up.
    """

    def __init__(
        self, folder: Path, vehicle_id: str, network: RoadNetwork, place: LanePoint, speed_mps: float = 12.0
    ) -> None:
        self.vehicle_id = vehicle_id
        self.speed_mps = speed_mps
        self._key = load_or_create_key(folder / "key.pem")
        self._folder = folder
        self._network = network
        self._journey = Journey(place)
        self._mode: DriveMode = "held"
        self._doors_open = False
        self._waiting_for = ""
        self._aboard: dict[str, RiderTask] = {}
        self._spoken = ""
        self._stood_s = 0.0
        self._shown_until_s = 0.0
        self.named: Pose2 | None = None
        # What it says that it stands before, and the kinds of the commands that it was given.
        self.obstacle_m: float | None = None
        self.commanded: list[str] = []
        # Its cameras, each with the picture that it sees.
        self.cameras: dict[str, bytes] = {}
        self._camera_until_s: dict[str, float] = {}
        self._events: list[VehicleEvent] = []
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._tasks: list[asyncio.Task[None]] = []

    @property
    def public_key(self) -> str:
        return public_key_text(self._key)

    def sign(self, text: bytes) -> str:
        return signature_text(self._key, text)

    def start(self, url: str) -> None:
        identity = Identity(self.vehicle_id, "boot-1", "0.1.0", "scripted", self._network.map_version, 6, 1)
        self._desk = LinkBridge(self._folder, identity, self.sign, sync=False)
        self._client = LinkClient(url, self._desk, self._receive, time.monotonic_ns)
        self._thread.start()
        asyncio.run_coroutine_threadsafe(self._begin(), self._loop).result(10)

    def stop(self) -> None:
        """Raises what ended its driving or its link before, if anything did."""
        try:
            asyncio.run_coroutine_threadsafe(self._end(), self._loop).result(10)
        finally:
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join(10)
            self._loop.close()

    def stop_with_fault(self, code: FaultCode) -> None:
        """As a guard does that sees a fault: it stands until an operator resumes it."""
        self._loop.call_soon_threadsafe(self._latch, code)

    def name_lidar(self, code: FaultCode, lidar: str, *, cleared: bool = False) -> None:
        """As an agent does whose lidar process says that something is wrong with one; it drives on."""
        self._loop.call_soon_threadsafe(
            self._events.append, FaultRaised(FaultReport(code, "warning", 0, lidar), cleared)
        )

    def _latch(self, code: FaultCode) -> None:
        self._mode = "minimal_risk"
        self._events.append(ModeChanged("minimal_risk", "fault", "", (code,)))

    async def _begin(self) -> None:
        self._tasks = [self._loop.create_task(self._client.run()), self._loop.create_task(self._live())]

    async def _end(self) -> None:
        for task in self._tasks:
            task.cancel()
        for ended in await asyncio.gather(*self._tasks, return_exceptions=True):
            if not isinstance(ended, asyncio.CancelledError):
                raise RuntimeError("the scripted shuttle ended before its test") from ended

    async def _live(self) -> None:
        while True:
            self._step()
            self._report()
            await asyncio.sleep(STEP_S)

    # ------------------------------------------------------------ receiving

    def _receive(self, message: LinkMessage) -> None:
        if isinstance(message, Order):
            self._take(message)
        elif isinstance(message, Grants):
            self._journey.grants = self._still_held(message.sections)
        elif isinstance(message, Command):
            self._obey(message)
        elif isinstance(message, PassengerTap):
            self._tapped(message)

    def _take(self, order: Order) -> None:
        journey = self._journey
        if journey.order is None or (journey.order.order_id, journey.order.revision) != (
            order.order_id,
            order.revision,
        ):
            journey.line = order_line(self._network, order.visits, journey.place, 1)
            journey.s_m = journey.place.s_m
            journey.order = order
            for visit in order.visits:
                journey.states.setdefault(visit.visit_id, "pending")
        journey.grants = self._still_held(order.sections)
        self._report(OrderAccepted(0, order.order_id, order.revision))

    def _still_held(self, grants: tuple[SectionGrant, ...]) -> tuple[SectionGrant, ...]:
        return tuple(grant for grant in grants if grant not in self._journey.gone)

    def _obey(self, command: Command) -> None:
        self.commanded.append(command.kind)
        if command.kind == "announce":
            self._spoken = command.text
        elif command.kind == "show_scene":
            self._shown_until_s = time.monotonic() + SHOWN_S
        elif command.kind == "show_camera":
            camera = command.text or next(iter(self.cameras), "")
            self._camera_until_s[camera] = time.monotonic() + SHOWN_S
        elif command.kind == "set_position":
            self.named = command.pose_map
            self._events.append(
                CommandDone(command.command_id, True, "scans agree, 1.2 m from the named place")
            )
            return
        elif command.kind not in LATER_KINDS:
            self._mode = "autonomous" if command.kind == "resume" else "held"
            self._events.append(ModeChanged(self._mode, detail=command.kind))
        self._events.append(CommandDone(command.command_id, True))

    def _tapped(self, tap: PassengerTap) -> None:
        visit = self._journey.next_visit()
        tasks = () if visit is None else visit.board if tap.kind == "board" else visit.alight
        rider = next((task for task in tasks if task.ride_id == tap.ride_id), None)
        accepted = self._doors_open and rider is not None
        self._events.append(
            TapAnswered(tap.tap_id, tap.ride_id, accepted, "" if accepted else "not standing")
        )
        if rider is None or not accepted:
            return
        if tap.kind == "board":
            self._aboard[rider.ride_id] = rider
            self._events.append(RiderBoarded(rider.ride_id, "tap"))
        elif self._aboard.pop(rider.ride_id, None) is not None:
            self._events.append(RiderAlighted(rider.ride_id, "tap"))

    # ------------------------------------------------------------ driving

    def _step(self) -> None:
        self._waiting_for = ""
        visit = self._journey.next_visit()
        if visit is None or self._mode != "autonomous":
            return
        if self._journey.states[visit.visit_id] == "pending":
            self._drive(visit)
        elif self._everybody_done(visit):
            self._leave(visit)

    def _everybody_done(self, visit: Visit) -> bool:
        waiting = [rider for rider in visit.board if rider.ride_id not in self._aboard]
        staying = [rider for rider in visit.alight if rider.ride_id in self._aboard]
        self._stood_s += STEP_S
        if self._stood_s < PATIENCE_S:
            return not waiting and not staying
        self._events += [RiderNoShow(rider.ride_id) for rider in waiting]
        return not staying

    def _drive(self, visit: Visit) -> None:
        journey, line = self._journey, self._journey.line
        assert line is not None
        spans = line.line.sections
        target_m = line.visit_s(visit.visit_id)
        assert target_m is not None
        authority = movement_authority(spans, journey.grants, journey.s_m, BODY, MARGIN_M)
        reach_m = min(target_m, authority.hold_s_m, journey.s_m + self.speed_mps * STEP_S)
        stands = reach_m <= journey.s_m
        self._waiting_for = authority.waiting_for if stands and authority.hold_s_m < target_m else ""
        # However quick it is, it sets foot on every section, or it could not give a short one back.
        while journey.s_m < reach_m:
            step_m = min(FOOTSTEP_M, reach_m - journey.s_m)
            journey.driven_m += step_m
            journey.s_m += step_m
            self._release(spans)
        journey.place = line.place(journey.s_m)
        # A stop that it was told of while leaving it lies a little behind.
        if journey.s_m > target_m - 0.01:
            self._arrive(visit)

    def _release(self, spans: tuple[tuple[str, float, float], ...]) -> None:
        journey = self._journey
        standing = find_occupied_sections(
            journey.footing, spans, journey.grants, journey.s_m, journey.driven_m, BODY
        )
        memory = MissionMemory(grants=journey.grants, released=journey.gone)
        memory, journey.footing, said = release_sections(memory, standing, journey.driven_m, SLACK_M)
        journey.grants, journey.gone = memory.grants, memory.released
        self._events += said

    def _arrive(self, visit: Visit) -> None:
        self._journey.states[visit.visit_id] = "under_way"
        self._stood_s = 0.0
        self._events.append(VisitChanged(visit.visit_id, visit.stop_id, "under_way"))
        if visit.kind == "stop":
            self._doors_open = True
            self._spoken = visit.name_en or visit.name
            self._events.append(DoorsChanged(True, visit.visit_id))

    def _leave(self, visit: Visit) -> None:
        if self._doors_open:
            self._doors_open = False
            self._events.append(DoorsChanged(False, visit.visit_id))
        self._journey.states[visit.visit_id] = "done"
        self._events.append(VisitChanged(visit.visit_id, visit.stop_id, "done"))

    # ------------------------------------------------------------ reporting

    def _report(self, *answers: OrderAccepted) -> None:
        events, self._events = tuple(self._events), []
        now_ns = time.monotonic_ns()
        news = TickUpdate(
            now_ns,
            self._status(now_ns),
            events,
            answers,
            memory=b"scripted",
            progress=self._holding(),
            scene=a_scene(now_ns) if time.monotonic() < self._shown_until_s else None,
        )
        self._desk.process_update(news, now_ns)
        for camera, until_s in self._camera_until_s.items():
            if time.monotonic() < until_s:
                self._desk.session.show(self._picture(camera, now_ns))
        self._client.wake()

    def _picture(self, camera: str, now_ns: int) -> CameraPicture:
        jpeg, names = self.cameras.get(camera, b""), tuple(self.cameras)
        state: ShownCameraState = "recording" if jpeg else "no_picture" if names else "no_cameras"
        return CameraPicture(0, now_ns, camera, state, names, coarse=True, jpeg=jpeg)

    def _holding(self) -> OrderProgress | None:
        order = self._journey.order
        if order is None:
            return None
        progress = tuple(VisitProgress(v.visit_id, self._journey.states[v.visit_id]) for v in order.visits)
        return OrderProgress(order.order_id, order.revision, progress)

    def _status(self, now_ns: int) -> Status:
        journey, place = self._journey, self._journey.place
        visit = journey.next_visit()
        drives = (
            visit is not None
            and self._mode == "autonomous"
            and journey.states[visit.visit_id] == "pending"
            and self.speed_mps > 0.0
            and not self._waiting_for
        )
        name = "" if visit is None else visit.name_en or visit.name
        return Status(
            epoch=0,
            stamp_ns=now_ns,
            pose_map=Pose2(*self._network.pose(place.lane_id, place.s_m)),
            speed_mps=3.0 if drives else 0.0,
            accel_mps2=0.0,
            steer_rad=0.0,
            mode=self._mode,
            battery_ratio=0.82,
            doors_open=self._doors_open,
            lane_id=place.lane_id,
            s_m=place.s_m,
            order_id="" if journey.order is None else journey.order.order_id,
            revision=0 if journey.order is None else journey.order.revision,
            visit_id="" if visit is None else visit.visit_id,
            aboard=tuple(self._aboard),
            screen=SCREEN_TO.format(name=name) if name else SCREEN_REST,
            spoken=self._spoken,
            # What stands before it is nearer than the road that it may not enter.
            waiting_for=self._waiting_for if self.obstacle_m is None else "",
            obstacle_m=self.obstacle_m,
        )

"""A shuttle that obeys its orders section by section, at planned speed, and tells what happens to it.

Its way and its leave are computed by the onboard mission's own functions; everything else is a stand-in.
"""

from dataclasses import dataclass, field

from contract.geometry import Pose2
from contract.roads.network import RoadNetwork
from contract.wire.messages import (
    EventLogState,
    ModeChanged,
    Order,
    OrderProgress,
    OrderRejected,
    RiderAlighted,
    RiderBoarded,
    RiderNoShow,
    RiderTask,
    SectionGrant,
    Status,
    VehicleEvent,
    Visit,
    VisitChanged,
    VisitProgress,
    VisitState,
)
from server.domain.fleet.vehicles import StatusReport
from server.domain.instants import ns_of
from server.domain.orders.orders import OrderState
from server.domain.record.events import RecordedEvent
from server.usecases.fleet import events, vehicle_sessions
from server.usecases.fleet.events import EventResult
from server.usecases.fleet.vehicle_sessions import HelloFacts
from server.usecases.orders import orders, outbox
from server.usecases.ports import topics
from tests.server.usecases.campus_under_test import CampusUnderTest
from vehicle_agent.mission.memory import MissionMemory
from vehicle_agent.mission.order_line import LanePoint, OrderLine, order_line
from vehicle_agent.mission.sections import (
    OccupiedSection,
    VehicleExtent,
    find_occupied_sections,
    movement_authority,
    release_sections,
)

STEP_S = 2.0
BODY = VehicleExtent(front_m=3.5, back_m=0.85)
MARGIN_M = 0.3
ARRIVED_M = 0.3


@dataclass
class FakeShuttle:
    """place: where the rear axle is. no_shows: rides that nobody boards for.

    drain_per_s, charge_per_s  of a battery: while it drives, and while it stands idle at a charger
    """

    campus: CampusUnderTest
    vehicle_id: str
    network: RoadNetwork
    place: LanePoint
    speed_mps: float = 3.0
    boot_id: str = "boot-1"
    seats: int = 6
    wheelchair_places: int = 0
    mode: str = "held"
    epoch: int = 0
    sequence: int = 0
    order: Order | None = None
    line: OrderLine | None = None
    s_m: float = 0.0
    states: dict[str, VisitState] = field(default_factory=dict)
    grants: tuple[SectionGrant, ...] = ()
    gone: tuple[SectionGrant, ...] = ()
    footing: tuple[OccupiedSection, ...] = ()
    aboard: dict[str, RiderTask] = field(default_factory=dict)
    no_shows: set[str] = field(default_factory=set)
    dwelt_s: float = 0.0
    rejected: list[str] = field(default_factory=list)
    told: list[VehicleEvent] = field(default_factory=list)
    driven_m: float = 0.0
    waited_for: str = ""
    connected: bool = False
    astray: Pose2 | None = None
    is_fresh: bool = True
    battery_ratio: float = 1.0
    drain_per_s: float = 0.0
    charge_per_s: float = 0.0

    # ------------------------------------------------------------ link

    def connect(self) -> None:
        """Say hello with what it holds, then report where it is."""
        progress = None
        if self.order is not None:
            visits = tuple(VisitProgress(v, s) for v, s in self.states.items())
            progress = OrderProgress(self.order.order_id, self.order.revision, visits)
        hello = HelloFacts(
            self.vehicle_id,
            self.boot_id,
            "test",
            "fake",
            self.network.map_version,
            (EventLogState(self.boot_id, self.sequence, len(self.told)),),
            progress,
            self.seats,
            self.wheelchair_places,
        )
        session = self.campus.do(lambda uow: vehicle_sessions.open_session(uow, hello))
        self.epoch = session.epoch
        self.connected = True
        self.is_fresh = True
        self.flush()
        self.report()

    def connect_at(self, pose_map: Pose2) -> None:
        """Say hello and report a position that has nothing to do with where it is."""
        self.astray = pose_map
        self.connect()
        self.astray = None

    def disconnect(self) -> None:
        self.connected = False
        self.campus.do(lambda uow: vehicle_sessions.close_session(uow, self.vehicle_id, self.epoch))

    def resume(self) -> None:
        self.mode = "autonomous"
        self.say(ModeChanged("autonomous", detail="resumed"))

    def hold(self) -> None:
        self.mode = "held"
        self.say(ModeChanged("held", detail="test"))

    def recover(self) -> None:
        """Be there again, and driving."""
        if not self.connected:
            self.connect()
        if self.mode != "autonomous":
            self.resume()

    def say(self, body: VehicleEvent) -> None:
        """Tell the server, at once or when the link is there again."""
        self.told.append(body)
        if self.connected:
            self.flush()

    def flush(self) -> None:
        while self.sequence < len(self.told):
            self.send(self.sequence)
            self.sequence += 1

    def send(self, sequence: int) -> EventResult:
        now = ns_of(self.campus.clock.now())
        event = RecordedEvent(self.vehicle_id, self.boot_id, sequence, now, now, self.told[sequence])
        return self.campus.do(lambda uow: events.apply_event(uow, event))

    def report(self) -> None:
        report = self.status_report()
        self.campus.do(lambda uow: vehicle_sessions.record_status(uow, [report]))

    def status_report(self) -> StatusReport:
        return StatusReport(self.vehicle_id, self.boot_id, self.campus.clock.now(), self.status())

    def status(self) -> Status:
        heading_for = self.next_visit()
        x_m, y_m, yaw_rad = self.network.pose(self.place.lane_id, self.place.s_m)
        return Status(
            epoch=self.epoch,
            stamp_ns=ns_of(self.campus.clock.now()),
            pose_map=self.astray or Pose2(x_m, y_m, yaw_rad),
            speed_mps=self.speed_mps if self._drives() else 0.0,
            accel_mps2=0.0,
            steer_rad=0.0,
            mode=self.mode,  # type: ignore[arg-type]
            battery_ratio=self.battery_ratio,
            doors_open=False,
            lane_id=self.place.lane_id,
            s_m=self.place.s_m,
            order_id="" if self.order is None else self.order.order_id,
            revision=0 if self.order is None else self.order.revision,
            visit_id="" if heading_for is None else heading_for.visit_id,
            aboard=tuple(self.aboard),
            waiting_for=self.waited_for,
        )

    def _drives(self) -> bool:
        visit = self.next_visit()
        goes_on = visit is not None and self.states[visit.visit_id] == "pending"
        return goes_on and self.mode == "autonomous" and not self.waited_for

    def fetch(self) -> None:
        """Take what the outbox holds."""
        waiting = self.campus.do(lambda uow: outbox.outbox_of(uow, self.vehicle_id))
        if waiting.order is not None:
            self.take(waiting.order)
        if waiting.grants is not None and self.order is not None:
            assert waiting.grants.order_id == self.order.order_id
            self.grants = tuple(g for g in waiting.grants.sections if g not in self.gone)

    def take(self, order: Order) -> None:
        done = {v for v, s in self.states.items() if s in ("done", "skipped")}
        under_way = [v for v, s in self.states.items() if s == "under_way"]
        clash = done & {visit.visit_id for visit in order.visits}
        if clash or (under_way and order.visits[0].visit_id != under_way[0]):
            self.reject(order, "visit_under_way", f"{sorted(clash)} {under_way}")
            return
        self.line = order_line(self.network, order.visits, self.place, 1)
        assert self.line.line.lane_ids == _lanes(order, self.place.lane_id), "the route was not followed"
        self.s_m = self.place.s_m
        for visit in order.visits:
            self.states.setdefault(visit.visit_id, "pending")
        self.order = order
        self.grants = tuple(g for g in order.sections if g not in self.gone)
        number = (order.order_id, order.revision)
        self.campus.do(lambda uow: orders.accepted(uow, self.vehicle_id, *number))

    def reject(self, order: Order, code: str, detail: str) -> None:
        self.rejected.append(f"{code}: {detail}")
        progress = tuple(VisitProgress(v, s) for v, s in self.states.items())
        answer = OrderRejected(
            self.epoch,
            order.order_id,
            order.revision,
            code,
            detail,
            progress,  # type: ignore[arg-type]
        )
        self.campus.do(lambda uow: orders.rejected(uow, self.vehicle_id, answer))

    # ------------------------------------------------------------ driving

    def step(self) -> None:
        """One second of life."""
        told = self.campus.bus.heard(topics.vehicle_outbox(self.campus.road_map.campus_id, self.vehicle_id))
        if self.connected and (told or self.is_fresh):
            self.is_fresh = False
            self.fetch()
        visit = self.next_visit()
        if visit is not None and self.mode == "autonomous":
            if self.states[visit.visit_id] == "under_way":
                self._dwell(visit)
            else:
                self._drive(visit)
        elif visit is None and self._is_at_charger():
            self.battery_ratio = min(1.0, self.battery_ratio + self.charge_per_s * STEP_S)

    def _is_at_charger(self) -> bool:
        lane_id, s_m = self.place.lane_id, self.place.s_m
        places = self.network.road_map.charging_places
        return any(place.lane_id == lane_id and abs(place.s_m - s_m) <= ARRIVED_M for place in places)

    def next_visit(self) -> Visit | None:
        if self.order is None:
            return None
        return next(
            (v for v in self.order.visits if self.states[v.visit_id] in ("pending", "under_way")), None
        )

    def _drive(self, visit: Visit) -> None:
        assert self.line is not None
        spans = self.line.line.sections
        self._release(spans)
        authority = movement_authority(spans, self.grants, self.s_m, BODY, MARGIN_M)
        target_m = self.line.visit_s(visit.visit_id)
        assert target_m is not None
        self.waited_for = authority.waiting_for if authority.hold_s_m < min(target_m, self.s_m + 0.01) else ""
        reach_m = min(target_m, authority.hold_s_m, self.s_m + self.speed_mps * STEP_S)
        if reach_m > self.s_m:
            self.battery_ratio -= self.drain_per_s * (reach_m - self.s_m) / self.speed_mps
            self.driven_m += reach_m - self.s_m
            self.s_m = reach_m
            self.place = self.line.place(self.s_m)
        self._release(spans)
        if abs(self.s_m - target_m) <= ARRIVED_M:
            self._arrive(visit)

    def _release(self, spans: tuple[tuple[str, float, float], ...]) -> None:
        memory = MissionMemory(grants=self.grants, released=self.gone)
        standing = find_occupied_sections(self.footing, spans, self.grants, self.s_m, self.driven_m, BODY)
        memory, self.footing, said = release_sections(memory, standing, self.driven_m, 0.3)
        self.grants, self.gone = memory.grants, memory.released
        for event in said:
            self.say(event)

    def _arrive(self, visit: Visit) -> None:
        self.states[visit.visit_id] = "under_way"
        self.dwelt_s = 0.0
        self.say(VisitChanged(visit.visit_id, visit.stop_id, "under_way"))
        if visit.kind == "rest":
            self._leave(visit)

    def _dwell(self, visit: Visit) -> None:
        if self.dwelt_s == 0.0:
            for rider in visit.alight:
                if rider.ride_id in self.aboard:
                    del self.aboard[rider.ride_id]
                    self.say(RiderAlighted(rider.ride_id, "code"))
        self.dwelt_s += STEP_S
        now_ns = ns_of(self.campus.clock.now())
        if self.dwelt_s >= visit.dwell_s and now_ns >= visit.not_before_ns:
            for rider in visit.board:
                if rider.ride_id in self.no_shows:
                    self.say(RiderNoShow(rider.ride_id))
                elif rider.ride_id not in self.aboard:
                    self.aboard[rider.ride_id] = rider
                    self.say(RiderBoarded(rider.ride_id, "code"))
            assert sum(rider.party for rider in self.aboard.values()) <= self.seats
            self._leave(visit)

    def _leave(self, visit: Visit) -> None:
        self.states[visit.visit_id] = "done"
        self.say(VisitChanged(visit.visit_id, visit.stop_id, "done"))


def _lanes(order: Order, here: str) -> tuple[str, ...]:
    """The order's own lanes from the vehicle's lane on."""
    lanes: list[str] = []
    for visit in order.visits:
        lanes += visit.route[1:] if lanes and lanes[-1] == visit.route[0] else visit.route
    return tuple(lanes[lanes.index(here) :])


def states_of_order(campus: CampusUnderTest, vehicle_id: str) -> OrderState | None:
    order = campus.read(lambda uow: uow.orders.current(vehicle_id))
    return None if order is None else order.state

"""The whole service in virtual time: one server, its store, a fleet, people and faults; and the verdict."""

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import httpx
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from campusloop.clients.ride_demand import stop_pairs
from campusloop.simulation.clocks import WallClock
from campusloop.simulation.faults import FaultInjector, Surroundings
from campusloop.simulation.fleet.body import SPEED_MPS_MAX, Body
from campusloop.simulation.fleet.surroundings import VehicleSetup
from campusloop.simulation.fleet.vehicle import SimulatedVehicle
from campusloop.simulation.history.records import Violation
from campusloop.simulation.history.vehicles import FleetRules as HistoryRules
from campusloop.simulation.history.vehicles import stuck_outboxes
from campusloop.simulation.judgement import CheckedState, judge
from campusloop.simulation.network import Network, PeopleTransport
from campusloop.simulation.observation import Observation
from campusloop.simulation.people.operators import Operators
from campusloop.simulation.people.passengers import Passengers
from campusloop.simulation.people.requests import ServiceClient
from campusloop.simulation.process.service_process import Machine, ServiceProcess, prepare
from campusloop.simulation.process.store import SimulatedDatabase, StoreFaults
from campusloop.simulation.process.store_facts import store_facts
from campusloop.simulation.timeline import Timeline
from campusloop.virtual.campus import ORIGIN
from campusloop.virtual.event_loop import VirtualLoop
from contract.geometry import Pose2
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from server.adapters import SeededIds
from server.domain.errors import StoreFailure
from server.domain.rules import FleetRules
from server.domain.service.timetable import ServiceHours
from server.store.roads.map_library import MapLibrary
from vehicle_agent.config import Profile
from vehicle_agent.link.keys import public_key_text, signature_text
from vehicle_agent.mission.mission import Mission
from vehicle_agent.stacks.rooms import mission_rules

START_NS = 1_000_000_000
BEGINS = datetime(2026, 9, 1, 0, 0, tzinfo=UTC)
# After the last fault and booking: time for every ride that was promised by then.
SETTLE_S = 2400.0
# The vehicles' first minutes are without faults: they enrol and are released.
BEGIN_FAULTS_S = 60.0
# Before the end, each vehicle gets a command that it must carry out.
LAST_CHECK_S = 120.0
# A ride may end so much later than promised, or than the last fault: as a share of the time to settle.
FORGOTTEN_RATIO = 0.6
RESTART_S = (2.0, 20.0)
RIDE_M = (200.0, 1500.0)
SEATS = 6


@dataclass(frozen=True, slots=True)
class SimulationOptions:
    """hours: of faults and bookings. faults: their kinds. rides_1ph: bookings of the whole campus in an hour.

    settle_s  how long the service has afterwards to end what it has promised
    """

    road_map: RoadMap
    folder: Path
    seed: int = 1
    vehicles: int = 20
    hours: float = 1.0
    faults: Collection[str] = ()
    rides_1ph: float = 120.0
    settle_s: float = SETTLE_S


@dataclass(frozen=True, slots=True)
class SimulationResult:
    """digest: of everything that happened, in order. context: the last lines about each violation."""

    virtual_s: float
    digest: str
    lines: int
    violations: list[Violation]
    context: dict[str, list[str]]
    faults: dict[str, int]
    rides: dict[str, int]
    answers: dict[str, int]
    bookings: int
    events: int
    starts: int
    driven_m: float


@dataclass
class _Life:
    """The server's lives: one process at a time, started again by a service manager."""

    starts: int = 0
    defects: list[str] = field(default_factory=list)


class SimulatedService:
    """Call `run` once."""

    def __init__(self, options: SimulationOptions) -> None:
        self.options = options
        self.timeline = Timeline(options.seed, START_NS)
        clock = WallClock(self.timeline, BEGINS, START_NS)
        rules = FleetRules(hours=ServiceHours(options.road_map.timezone, ()), speed_cap_mps=SPEED_MPS_MAX)
        self.database = SimulatedDatabase()
        self.machine = Machine(
            self.timeline,
            options.road_map,
            options.folder / "server",
            self.database,
            clock,
            SeededIds(options.seed),
            rules,
            MapLibrary(rules),
        )
        self.store_faults = StoreFaults()
        self.network = Network(self.timeline)
        self.people: VirtualLoop = self.timeline.new_loop()
        self.transport = PeopleTransport(self.network, self.timeline)
        self._http = httpx.AsyncClient(base_url=ORIGIN, transport=self.transport)
        self._restart_rng = self.timeline.rng("service manager")
        self._life = _Life()
        names = tuple(f"shuttle-{number:02d}" for number in range(1, options.vehicles + 1))
        self.observation = Observation(
            self.now_s, clock, HistoryRules(rules.order_valid_s), dict.fromkeys(names, SEATS)
        )
        self.passengers = self._passengers(clock)
        self.vehicles, self._keys = self._fleet(names)
        self.operators = self._operators(names)

    def now_s(self) -> float:
        return (self.timeline.now_ns - START_NS) * 1e-9

    # ---------------------------------------------------------------- the whole run

    def run(self) -> SimulationResult:
        options = self.options
        prepare(self.machine)
        self.start_server()
        self.people.create_task(self._open_campus())
        injector = FaultInjector(
            Surroundings(
                self.timeline,
                self.network,
                self.transport,
                self.database,
                self.store_faults,
                self.machine.clock,
                self.vehicles,
                self.observation,
                self.crash_server,
            ),
            tuple(options.faults),
        )
        injector.begin(after_s=BEGIN_FAULTS_S)
        faults_end_s = options.hours * 3600.0
        self._run_to(faults_end_s)
        injector.end()
        self.passengers.is_open = self.operators.is_open = False
        self._run_to(faults_end_s + options.settle_s - LAST_CHECK_S)
        at_check = CheckedState(
            {name: _sections_left(vehicle) for name, vehicle in self.vehicles.items()},
            self.observation.durable_now(),
            tuple(self.observation.seen),
        )
        oldest = self._oldest_events()
        commands: dict[str, str] = {}
        check = self.people.create_task(self._command_each(commands))
        self._run_to(faults_end_s + options.settle_s)
        check.cancel()
        for violation in stuck_outboxes(self.now_s(), oldest, self._oldest_events()):
            self.observation.violated(violation)
        return self._result(faults_end_s, commands, at_check)

    def _run_to(self, until_s: float) -> None:
        self.timeline.run_until(START_NS + round(until_s * 1e9))

    def _oldest_events(self) -> dict[str, tuple[str, int]]:
        events = {name: vehicle.oldest_event for name, vehicle in self.vehicles.items()}
        return {name: event for name, event in events.items() if event is not None}

    async def _open_campus(self) -> None:
        """Enrol and start the vehicles, and let the people in."""
        await self.operators.sign_in()
        for vehicle_id, vehicle in self.vehicles.items():
            await self.operators.enrol(vehicle_id, self._keys[vehicle_id], SEATS, 0)
            vehicle.boot()
        for work in (self.operators.watch(), self.operators.intervene(), self.passengers.run()):
            self.people.create_task(work)

    async def _command_each(self, commands: dict[str, str]) -> None:
        for vehicle_id in self.vehicles:
            commands[vehicle_id] = await self.operators.announce(vehicle_id, "a test of the loudspeaker")

    # ---------------------------------------------------------------- the server

    def start_server(self) -> None:
        """As a service manager does: if it cannot start, again after a while."""
        try:
            if self._life.starts:
                prepare(self.machine)
        except StoreFailure as error:
            self.observation.note("server", f"cannot start: {error.code}")
            self.timeline.after(5.0, self.start_server)
            return
        self._life.starts += 1
        self.observation.note("server", "starts")
        self.network.service = ServiceProcess(self.machine, self.store_faults, self._server_ended)

    def crash_server(self, cause: str) -> None:
        if self.network.service is not None:
            self.network.service.crash(cause)

    def _server_ended(self, cause: str) -> None:
        assert self.network.service is not None
        self.observation.note("server", f"ends: {cause}")
        self._take_defects(self.network.service)
        self.network.lose_service()
        self.timeline.after(self._restart_rng.uniform(*RESTART_S), self.start_server)

    def _end_quietly(self) -> None:
        """End the last process, so that none of its tasks is left."""
        service = self.network.service
        if service is not None:
            service.end_tasks()

    def _take_defects(self, service: ServiceProcess) -> None:
        for defect in service.defects:
            self.observation.violated(Violation(self.now_s(), "server_defect", defect[:80], defect))

    # ---------------------------------------------------------------- parts

    def _client(self, name: str) -> ServiceClient:
        return ServiceClient(self._http, self.timeline.rng(name), self.observation.answered)

    def _passengers(self, clock: WallClock) -> Passengers:
        rng = self.timeline.rng
        return Passengers(
            self._client("passengers' phones"),
            clock,
            tuple(stop_pairs(self.options.road_map, *RIDE_M)),
            3600.0 / self.options.rides_1ph,
            rng("passengers"),
            rng("doors"),
            self.observation.acknowledge,
            self.now_s,
        )

    def _operators(self, names: tuple[str, ...]) -> Operators:
        lanes = tuple(lane.lane_id for lane in self.options.road_map.lanes)
        return Operators(
            self._client("operators' console"),
            names,
            lanes,
            self.timeline.rng("operators"),
            lambda: tuple(name for name, v in self.vehicles.items() if v.is_held and v.is_running),
        )

    def _fleet(self, names: tuple[str, ...]) -> tuple[dict[str, SimulatedVehicle], dict[str, str]]:
        """Each vehicle at a resting place of its own, with a key made from the seed."""
        road_map = self.options.road_map
        network = RoadNetwork(road_map)
        mission = Mission(network, mission_rules(Profile()))
        vehicles, keys = {}, {}
        for vehicle_id, place in zip(names, road_map.resting_places, strict=False):
            rng = self.timeline.rng(f"key of {vehicle_id}")
            key = Ed25519PrivateKey.from_private_bytes(rng.randbytes(32))
            keys[vehicle_id] = public_key_text(key)
            setup = VehicleSetup(
                vehicle_id,
                self.options.folder / vehicle_id,
                mission,
                SEATS,
                0,
                lambda text, key=key: signature_text(key, text),  # type: ignore[misc]
            )
            body = Body(Pose2(*network.pose(place.lane_id, place.s_m)))
            vehicles[vehicle_id] = SimulatedVehicle(
                setup, body, self.timeline, self.network, self.passengers, self.observation
            )
        return vehicles, keys

    def _result(
        self,
        faults_end_s: float,
        commands: dict[str, str],
        at_check: CheckedState,
    ) -> SimulationResult:
        observation, service = self.observation, self.network.service
        if service is not None:
            self._take_defects(service)
        facts = store_facts(
            self.database.engine,
            self.machine.context(),
            self.now_s(),
            faults_end_s,
            clock_was_wrong=bool(observation.faults["server-clock"]),
        )
        fleet, bound_s = tuple(self.vehicles), FORGOTTEN_RATIO * self.options.settle_s
        for violation in judge(observation, facts, service, self.machine, fleet, commands, at_check, bound_s):
            observation.violated(violation)
        self._end_quietly()
        rides = Counter(ride.state for ride in facts.rides)
        for ride in facts.rides:
            observation.note(ride.ride_id, f"ends as {ride.state} {ride.reason}")
        return SimulationResult(
            virtual_s=self.now_s(),
            digest=observation.journal.digest(),
            lines=observation.journal.lines,
            violations=observation.violations,
            context={v.subject: observation.journal.about(v.subject) for v in observation.violations},
            faults=dict(sorted(observation.faults.items())),
            rides=dict(sorted(rides.items())),
            answers=dict(sorted(observation.answers.items())),
            bookings=len(observation.acknowledged),
            events=sum(len(events) for events in facts.events.values()),
            starts=self._life.starts,
            driven_m=sum(vehicle.body.driven_m for vehicle in self.vehicles.values()),
        )


def _sections_left(vehicle: SimulatedVehicle) -> frozenset[tuple[str, int]]:
    memory = vehicle.memory
    return frozenset((grant.section_id, grant.fence) for grant in (() if memory is None else memory.released))

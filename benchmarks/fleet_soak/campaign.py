"""The campaign: a real server, a fleet on real connections, people who ask it, and the history's verdict."""

import asyncio
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import httpx

from benchmarks.bookings.postgresql import deadlocks
from benchmarks.faults.installation import MAP, PASSWORD, Installation, an_installation
from benchmarks.fleet_soak.fleet import SEATS, SoakFleet
from benchmarks.fleet_soak.real_link import RealNetwork
from benchmarks.fleet_soak.real_schedule import MachineClock, RealSchedule
from benchmarks.fleet_soak.timed_client import TimedClient
from campusloop.clients.ride_demand import stop_pairs
from campusloop.simulation.history.records import StoredRide, Violation
from campusloop.simulation.history.vehicles import FleetRules as HistoryRules
from campusloop.simulation.history.vehicles import stuck_outboxes
from campusloop.simulation.judgement import CheckedState, judge_history
from campusloop.simulation.observation import Observation
from campusloop.simulation.people.operators import Operators
from campusloop.simulation.people.passengers import Passengers
from campusloop.simulation.process.store_facts import StoreFacts, store_facts
from campusloop.simulation.service import FORGOTTEN_RATIO, RIDE_M
from campusloop.virtual.campus import TICKET_KEYS, QuickHasher
from contract.roads.load import load_map
from contract.roads.model import RoadMap
from server.adapters import RandomIds, SystemClock
from server.domain.rules import FleetRules
from server.store.engine import open_engine
from server.store.roads.map_library import MapLibrary
from server.store.unit_of_work import Context

_LAST_CHECK_S = 120.0
_PROGRESS_EVERY_S = 60.0
_MEMORY_AFTER_S = 600.0


@dataclass(frozen=True, slots=True)
class SoakOptions:
    """bookings_s: how long people book; settle_s: how long the fleet then has to end what was promised.

    disturb_s  a vehicle's connection or computer fails every so often on average; 0: never
    """

    seed: int
    vehicles: int
    bookings_s: float
    settle_s: float
    rides_1ph: float
    disturb_s: float


@dataclass
class Soak:
    """memory_mb: of the server, after its first ten minutes and at the end."""

    database: str
    bookings: int = 0
    events: int = 0
    driven_m: float = 0.0
    rides: Mapping[str, int] = field(default_factory=dict)
    answers: Mapping[str, int] = field(default_factory=dict)
    answers_s: list[float] = field(default_factory=list)
    cuts: int = 0
    crashes: int = 0
    dials: int = 0
    interventions: int = 0
    server_cpu_s: float = 0.0
    memory_mb: tuple[float, float] = (0.0, 0.0)
    server_starts: int = 0
    deadlocks: int = 0
    sick: tuple[str, ...] = ()
    violations: list[Violation] = field(default_factory=list)


class _Campaign:
    def __init__(self, installation: Installation, options: SoakOptions) -> None:
        self.installation, self.options = installation, options
        self.schedule, self.clock = RealSchedule(options.seed), MachineClock()
        self.road_map: RoadMap = load_map(MAP)
        self.network = RealNetwork(installation.websocket("/ws/vehicle"))
        names = [f"shuttle-{number:02d}" for number in range(1, options.vehicles + 1)]
        self.observation = Observation(
            lambda: self.schedule.now_s,
            self.clock,
            HistoryRules(FleetRules().order_valid_s),
            dict.fromkeys(names, SEATS),
        )
        self.http = httpx.AsyncClient(base_url=installation.origin, trust_env=False, timeout=30.0)
        self.passengers_client = self._client("passengers' phones")
        rng = self.schedule.rng
        self.passengers = Passengers(
            self.passengers_client,
            self.clock,
            tuple(stop_pairs(self.road_map, *RIDE_M)),
            3600.0 / options.rides_1ph,
            rng("passengers"),
            rng("doors"),
            self.observation.acknowledge,
            lambda: self.schedule.now_s,
        )
        self.fleet = SoakFleet(
            self.road_map,
            options.vehicles,
            installation.folder / "vehicles",
            self.schedule,
            self.network,
            self.passengers,
            self.observation,
        )
        self.operators = Operators(
            self._client("operators' console"),
            names,
            [lane.lane_id for lane in self.road_map.lanes],
            rng("operators"),
            self.fleet.held,
            credentials=("operator", PASSWORD),
        )
        self.defects: list[str] = []
        self._early_mb = 0.0
        asyncio.get_running_loop().set_exception_handler(self._failed)

    async def run(self) -> Soak:
        await self.operators.sign_in()
        for vehicle_id, vehicle in self.fleet.vehicles.items():
            await self.operators.enrol(vehicle_id, self.fleet.public_keys[vehicle_id], SEATS, 0)
            vehicle.boot()
        work = [self.operators.watch(), self.operators.intervene(), self.passengers.run(), self._progress()]
        if self.options.disturb_s > 0.0:
            work.append(self._disturb())
        tasks = [asyncio.create_task(each) for each in work]
        try:
            return await self._through(tasks)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self.network.close()
            await self.http.aclose()

    async def _through(self, tasks: "list[asyncio.Task[None]]") -> Soak:
        options = self.options
        await self._until(options.bookings_s, tasks)
        self.passengers.is_open = self.operators.is_open = False
        await self._until(options.bookings_s + options.settle_s - _LAST_CHECK_S, tasks)
        at_check = CheckedState(
            self.fleet.sections_left(), self.observation.durable_now(), tuple(self.observation.seen)
        )
        oldest = self.fleet.oldest_events()
        commands = {
            vehicle_id: await self.operators.announce(vehicle_id, "a test of the loudspeaker")
            for vehicle_id in self.fleet.vehicles
        }
        await self._until(options.bookings_s + options.settle_s, tasks)
        for violation in stuck_outboxes(self.schedule.now_s, oldest, self.fleet.oldest_events()):
            self.observation.violated(violation)
        return await self._verdict(commands, at_check)

    async def _until(self, end_s: float, tasks: "list[asyncio.Task[None]]") -> None:
        """Raises what ended a task of people, which work to the end."""
        while self.schedule.now_s < end_s:
            await asyncio.sleep(min(1.0, max(0.01, end_s - self.schedule.now_s)))
            for task in tasks:
                if task.done() and not task.cancelled() and (error := task.exception()) is not None:
                    raise error

    async def _disturb(self) -> None:
        rng = self.schedule.rng("disturbances")
        while self.operators.is_open:
            await asyncio.sleep(rng.expovariate(1.0 / self.options.disturb_s))
            if self.operators.is_open:
                self.observation.note("fleet", self.fleet.disturb(rng))

    async def _progress(self) -> None:
        while True:
            await asyncio.sleep(_PROGRESS_EVERY_S)
            if self._early_mb == 0.0 and self.schedule.now_s > _MEMORY_AFTER_S:
                self._early_mb = self._memory_mb()
            print(
                f"{self.schedule.now_s / 60.0:.0f} min: {len(self.observation.acknowledged)} bookings, "
                f"{self.fleet.driven_m / 1000.0:.1f} km, {self._memory_mb():.0f} MB, "
                f"{len(self.observation.violations)} violations",
                flush=True,
            )

    def _memory_mb(self) -> float:
        return float(self.installation.process.memory_info().rss) / 1e6

    async def _verdict(self, commands: Mapping[str, str], at_check: CheckedState) -> Soak:
        options, observation, fleet = self.options, self.observation, tuple(self.fleet.vehicles)
        cpu = self.installation.process.cpu_times()
        readiness = await self.installation.readiness()
        facts = await asyncio.to_thread(self._facts)
        found = judge_history(
            observation, facts, fleet, commands, at_check, FORGOTTEN_RATIO * options.settle_s
        )
        at_s = self.schedule.now_s
        found += [
            Violation(at_s, "vehicle_unreachable", name, "has no session at the end")
            for name in fleet
            if name not in facts.connected
        ]
        found += [Violation(at_s, "task_dead", name, "is not good, by /ready") for name in readiness.sick]
        found += [Violation(at_s, "vehicle_defect", text[:80], text) for text in self.defects]
        for violation in found:
            observation.violated(violation)
        url = self.installation.database_url
        return Soak(
            "postgresql" if url else "sqlite",
            bookings=len(observation.acknowledged),
            events=sum(len(events) for events in facts.events.values()),
            driven_m=self.fleet.driven_m,
            rides=_by_state(facts.rides),
            answers=dict(sorted(observation.answers.items())),
            answers_s=self.passengers_client.answers_s,
            cuts=self.fleet.cuts,
            crashes=self.fleet.crashes,
            dials=self.network.dials,
            interventions=self.operators.interventions,
            server_cpu_s=cpu.user + cpu.system,
            memory_mb=(self._early_mb, self._memory_mb()),
            server_starts=self.installation.starts,
            deadlocks=deadlocks(url) if url else 0,
            sick=readiness.sick,
            violations=observation.violations,
        )

    def _facts(self) -> StoreFacts:
        """Read beside the running server."""
        rules, road_map = FleetRules(), self.road_map
        context = Context(
            road_map.campus_id,
            SystemClock(),
            RandomIds(),
            rules,
            QuickHasher(),
            MapLibrary(rules),
            TICKET_KEYS,
        )
        engine = open_engine(self.installation.url)
        try:
            return store_facts(
                engine, context, self.schedule.now_s, self.options.bookings_s, clock_was_wrong=False
            )
        finally:
            engine.dispose()

    def _client(self, name: str) -> TimedClient:
        return TimedClient(self.http, self.schedule.rng(name), self.observation.answered)

    def _failed(self, loop: asyncio.AbstractEventLoop, context: Mapping[str, object]) -> None:
        """A callback raised: vehicles step in callbacks."""
        self.defects.append(f"{context.get('message')}: {context.get('exception')!r}")
        loop.default_exception_handler(dict(context))


def _by_state(rides: tuple[StoredRide, ...]) -> dict[str, int]:
    return dict(sorted(Counter(ride.state for ride in rides).items()))


async def soak(database_url: str, folder: Path, options: SoakOptions) -> Soak:
    """database_url: empty for SQLite in the folder"""
    async with an_installation(folder, database_url) as installation:
        return await _Campaign(installation, options).run()

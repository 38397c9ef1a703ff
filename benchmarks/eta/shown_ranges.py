"""Hours of the simulated service, with every range that passengers were shown, and what came."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path

from campusloop.simulation.service import SimulatedService, SimulationOptions
from contract.roads.model import RoadMap
from server.domain.planning.eta_ranges import ExpectedRange, PlannedPickup, standing_of
from server.domain.rides.rides import Promise, Ride, RideState
from server.store.unit_of_work import SqlUnitOfWork
from server.usecases.planning.outlooks import outlook_of

EVERY_S = 60.0
VEHICLES = 20
RIDES_1PH = 120.0
SETTLE_S = 2400.0


@dataclass(frozen=True, slots=True)
class ShownRange:
    """What a passenger was shown at one time, and what came.

    ahead_s   from then to the planned pickup or arrival
    standing  of a pickup's plan to the promise, as `eta_ranges` has it; "" for an arrival
    came      when the party boarded, or got off; one that boards before its window opens counts from there
    """

    ride_id: str
    at: datetime
    ahead_s: float
    standing: str
    shown: ExpectedRange
    came: datetime

    @property
    def is_inside(self) -> bool:
        return self.shown.earliest <= self.came <= self.shown.latest

    @property
    def width_s(self) -> float:
        return (self.shown.latest - self.shown.earliest).total_seconds()


@dataclass(frozen=True, slots=True)
class SimulatedHours:
    """ranges: of pickups; arrivals: ranges of arrivals, shown to parties aboard;
    waiting: the same, shown to parties that wait
    violations: rules of the history that were broken meanwhile; `simulate-service` looks into them."""

    ranges: list[ShownRange]
    arrivals: list[ShownRange]
    waiting: list[ShownRange]
    violations: list[str]


@dataclass(frozen=True, slots=True)
class _Asked:
    """A range that was shown, before what came is known. promise: of a pickup, None for an arrival.

    is_waiting  the range of an arrival was shown to a party that waits
    """

    ride_id: str
    at: datetime
    eta: datetime
    promise: Promise | None
    shown: ExpectedRange
    is_waiting: bool = False


@dataclass
class _Watch:
    """Reads once a minute what the server would answer to every passenger who waits or rides."""

    service: SimulatedService
    asked: list[_Asked] = field(default_factory=list)

    def begin(self) -> None:
        self.service.timeline.after(EVERY_S, self._look)

    def _look(self) -> None:
        self.begin()
        with self.service.database.engine.connect() as connection:
            uow = SqlUnitOfWork(connection, self.service.machine.context())
            for ride in uow.rides.in_states([RideState.ASSIGNED, RideState.ABOARD]):
                self._ask(uow, ride)

    def _ask(self, uow: SqlUnitOfWork, ride: Ride) -> None:
        told = outlook_of(uow, ride)
        if told.pickup is not None and ride.promise is not None and ride.pickup_eta is not None:
            self.asked.append(_Asked(ride.ride_id, uow.now, ride.pickup_eta, ride.promise, told.pickup))
        if told.arrival is not None and ride.arrival_eta is not None:
            waits = ride.state is RideState.ASSIGNED
            self.asked.append(_Asked(ride.ride_id, uow.now, ride.arrival_eta, None, told.arrival, waits))


def shown_ranges(road_map: RoadMap, folder: Path, seed: int, hours: float) -> SimulatedHours:
    """Of every ride that was picked up, and of every one that arrived."""
    options = SimulationOptions(road_map, folder, seed, VEHICLES, hours, (), RIDES_1PH, SETTLE_S)
    service = SimulatedService(options)
    watch = _Watch(service)
    watch.begin()
    begins = service.machine.clock.now()
    result = service.run()
    came_s: dict[str, dict[str, float]] = {"boarded": {}, "alighted": {}}
    for fact in service.observation.seen:
        came_s[fact.what].setdefault(fact.ride_id, fact.at_s)
    broken = [f"{one.rule} {one.subject}: {one.text}" for one in result.violations]
    pickups = list(_with_pickups(watch.asked, came_s["boarded"], begins))
    aboard, waiting = (
        list(
            _with_arrivals(
                [one for one in watch.asked if one.is_waiting == is_waiting], came_s["alighted"], begins
            )
        )
        for is_waiting in (False, True)
    )
    return SimulatedHours(pickups, aboard, waiting, broken)


def _with_pickups(asked: list[_Asked], boarded_s: dict[str, float], begins: datetime) -> Iterator[ShownRange]:
    for one in asked:
        if one.promise is None or one.ride_id not in boarded_s:
            continue
        picked_up = max(begins + timedelta(seconds=boarded_s[one.ride_id]), one.promise.pickup_from)
        planned = PlannedPickup(one.eta, one.promise.pickup_from, 0)
        ahead_s = (one.eta - one.at).total_seconds()
        yield ShownRange(one.ride_id, one.at, ahead_s, standing_of(planned), one.shown, picked_up)


def _with_arrivals(
    asked: list[_Asked], alighted_s: dict[str, float], begins: datetime
) -> Iterator[ShownRange]:
    for one in asked:
        if one.promise is None and one.ride_id in alighted_s:
            came = begins + timedelta(seconds=alighted_s[one.ride_id])
            ahead_s = (one.eta - one.at).total_seconds()
            yield ShownRange(one.ride_id, one.at, ahead_s, "", one.shown, came)

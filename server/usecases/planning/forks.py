"""A fork of the past: from a moment on the day's rides are dispatched again, as they were and changed.

The fork begins with what was so at that moment: where the shuttles were, who was on board, who waited. From
there on everything happens as planned (`fleet_day`), with the same rides, under the fleet of then and under a
changed one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from typing import Protocol

import numpy as np

from contract.roads.load import decode_map, encode_map
from contract.roads.network import RoadNetwork
from server.domain.errors import ForkImpossible
from server.domain.rides.rides import Ride, RideState
from server.domain.rules import FleetRules
from server.travel.fleet_roads import FleetRoads
from server.usecases.planning.day_figures import DayFigures, figures_of
from server.usecases.planning.fleet_day import POLICIES, FleetDay, Shuttle, Start, run_day
from server.usecases.planning.snapshot import seconds
from server.usecases.ports.unit_of_work import UnitOfWork

RIDES_MAX = 2_000
# A ride that was wanted long before the moment is over by then.
WANTED_BEFORE = timedelta(hours=6)
# A shuttle that was not heard for longer has no place at the moment, and begins at a resting place.
HEARD_WITHIN = timedelta(seconds=60)
_POSITIONS_MAX = 60_000
FLEET_MAX = 200
# The policy that the dispatcher has.
PRESENT_POLICY = "improvement"


@dataclass(frozen=True, slots=True)
class ForkRide:
    """A ride from the moment on. actual_pickup_at, actual_end: as it was; None: it did not happen.

    before_s  how long it had waited at the moment already
    promised  it had been taken at the moment
    """

    ride: str
    ride_code: str
    announced_at: datetime
    earliest: datetime
    from_stop: str
    to_stop: str
    party: int
    wheelchairs: int
    cancelled_at: datetime | None
    before_s: float
    promised: bool
    actual_pickup_at: datetime | None
    actual_state: str


@dataclass(frozen=True, slots=True)
class ForkStart:
    """Where a shuttle was, and when it was free: riders on board are taken to their stops first."""

    vehicle_id: str
    lane_id: str
    s_m: float
    ready_s: float


@dataclass(frozen=True, slots=True)
class ForkInput:
    """Everything that a fork needs, for a process of its own."""

    road_map: bytes
    closed: frozenset[str]
    rules: FleetRules
    rides: tuple[ForkRide, ...]
    fleet: tuple[Shuttle, ...]
    starts: tuple[ForkStart, ...]
    more: int
    policy: str


@dataclass(frozen=True, slots=True)
class ForkedRide:
    """A ride as it was and in both forks: seconds waited from the requested time to boarding, None without.

    then_state, present_end, changed_end  a ride's state then; "served", "refused", "cancelled" in the forks
    """

    ride_id: str
    ride_code: str
    from_stop: str
    to_stop: str
    party: int
    requested_at: datetime
    then_state: str
    then_wait_s: float | None
    present_end: str
    present_wait_s: float | None
    changed_end: str
    changed_wait_s: float | None


@dataclass(frozen=True, slots=True)
class ForkResult:
    """present: the fleet and the policy of then, dispatched again; changed: with the change.

    computing_s  what it took a processor; 0 where it was computed in the caller's own step
    """

    present_shuttles: int
    changed_shuttles: int
    placed: int
    present: DayFigures
    changed: DayFigures
    rides: tuple[ForkedRide, ...]
    computing_s: float = 0.0


class Forks(Protocol):
    """`run_fork` somewhere: inline, or in a child process."""

    async def run(self, fork: ForkInput, fork_id: str) -> ForkResult:
        """fork_id: by which it can be stopped, "" for none. Raises ForksBusy, ForkStopped."""
        ...

    def stop(self, fork_id: str) -> None:
        """Give up the fork of this name; its `run` raises ForkStopped. Raises ForkUnknown."""
        ...


def fork_input(uow: UnitOfWork, at: datetime, until: datetime, more: int, policy: str) -> ForkInput:
    """What was so at a moment, and what was requested from then on. Raises ForkImpossible."""
    roads = uow.roads()
    found = uow.past.wanted_rides(at - WANTED_BEFORE, until, RIDES_MAX + 1)
    if len(found) > RIDES_MAX:
        raise ForkImpossible(f"more than {RIDES_MAX} rides were requested in that time: choose a shorter one")
    known = roads.stop_numbers
    rides = [ride for ride in found if ride.from_stop in known and _destination(ride) in known]
    forked = tuple(one for ride in rides if (one := _fork_ride(ride, at)) is not None)
    if not forked:
        raise ForkImpossible("no ride waited at this moment, and none was requested after it")
    fleet = tuple(
        Shuttle(vehicle.vehicle_id, vehicle.seats, vehicle.wheelchair_places)
        for vehicle in uow.vehicles.all()
        if not vehicle.retired and vehicle.enrolled_at <= at
    )
    if not len(fleet) >= 1 or not 1 <= len(fleet) + more <= FLEET_MAX:
        raise ForkImpossible(f"a fleet of {len(fleet) + more} shuttles cannot be tried")
    return ForkInput(
        road_map=encode_map(roads.network.road_map),
        closed=roads.closed,
        rules=uow.rules,
        rides=tuple(sorted(forked, key=lambda ride: (ride.announced_at, ride.ride))),
        fleet=fleet,
        starts=_starts(uow, roads, rides, at),
        more=more,
        policy=policy,
    )


def run_fork(fork: ForkInput) -> ForkResult:
    """Pure, and slow: seconds for a day."""
    rules = fork.rules
    network = RoadNetwork(decode_map(fork.road_map))
    roads = FleetRoads(network, rules.speed_cap_mps, rules.travel_time_factor)
    if fork.closed:
        roads = roads.closed_to(fork.closed)
    starts = {
        start.vehicle_id: Start(
            roads.times_to_stops((start.lane_id, start.s_m), frozenset(), frozenset()), start.ready_s
        )
        for start in fork.starts
    }
    fleet = _resized(fork.fleet, fork.more)
    promised = frozenset(ride.ride for ride in fork.rides if ride.promised)

    def day(shuttles: tuple[Shuttle, ...], policy: str) -> FleetDay:
        return run_day(fork.rides, shuttles, roads, rules, POLICIES[policy], starts=starts, promised=promised)

    present, changed = day(fork.fleet, PRESENT_POLICY), day(fleet, fork.policy)
    return ForkResult(
        present_shuttles=len(fork.fleet),
        changed_shuttles=len(fleet),
        placed=len(starts),
        present=_figures(fork.rides, present),
        changed=_figures(fork.rides, changed),
        rides=tuple(_forked(ride, present, changed) for ride in fork.rides),
    )


def _destination(ride: Ride) -> str:
    return ride.first_to_stop or ride.to_stop


def _fork_ride(ride: Ride, at: datetime) -> ForkRide | None:
    """None for a ride that was over or on board at the moment."""
    is_over = ride.ended_at is not None and ride.ended_at <= at
    is_aboard = ride.boarded_at is not None and ride.boarded_at <= at
    destination = _destination(ride)
    if is_over or is_aboard or destination == ride.from_stop:
        return None
    return ForkRide(
        ride=ride.ride_id,
        ride_code=ride.ride_code,
        announced_at=max(ride.requested_at, at),
        earliest=max(ride.earliest, at),
        from_stop=ride.from_stop,
        to_stop=destination,
        party=ride.party,
        wheelchairs=ride.wheelchairs,
        cancelled_at=ride.ended_at if ride.state is RideState.CANCELLED else None,
        before_s=max((at - ride.earliest).total_seconds(), 0.0),
        promised=ride.requested_at < at and ride.state is not RideState.REFUSED,
        actual_pickup_at=ride.boarded_at,
        actual_state=str(ride.state),
    )


def _starts(uow: UnitOfWork, roads: FleetRoads, rides: Sequence[Ride], at: datetime) -> tuple[ForkStart, ...]:
    """Of the shuttles that were heard; one with riders on board is free at the stop of the last of them."""
    places: dict[str, tuple[str, float]] = {}
    for position in uow.past.positions(at - HEARD_WITHIN, at + timedelta(seconds=1), _POSITIONS_MAX):
        on_lane = roads.network.locate(position.x_m, position.y_m, position.yaw_rad)
        if on_lane is not None:
            places[position.vehicle_id] = on_lane[:2]
    busy = _busy_until(rides, at)
    stops = {stop.stop_id: (stop.lane_id, stop.s_m) for stop in roads.network.road_map.stops}
    found = []
    for vehicle_id, place in sorted(places.items()):
        until, stop_id = busy.get(vehicle_id, (at, ""))
        lane_id, s_m = stops.get(stop_id, place)
        found.append(ForkStart(vehicle_id, lane_id, s_m, seconds(until)))
    return tuple(found)


def _busy_until(rides: Sequence[Ride], at: datetime) -> Mapping[str, tuple[datetime, str]]:
    """When and where each vehicle's last rider of the moment got out."""
    busy: dict[str, tuple[datetime, str]] = {}
    for ride in rides:
        was_aboard = ride.boarded_at is not None and ride.boarded_at <= at
        if ride.vehicle_id is None or not was_aboard or ride.ended_at is None or ride.ended_at <= at:
            continue
        if ride.ended_at > busy.get(ride.vehicle_id, (at, ""))[0]:
            busy[ride.vehicle_id] = (ride.ended_at, ride.to_stop)
    return busy


def _resized(fleet: tuple[Shuttle, ...], more: int) -> tuple[Shuttle, ...]:
    """With copies of the first shuttle, or without the last ones."""
    if more <= 0:
        return fleet[: len(fleet) + more]
    return (*fleet, *(replace(fleet[0], vehicle_id=f"more-{k + 1}") for k in range(more)))


def _forked(ride: ForkRide, present: FleetDay, changed: FleetDay) -> ForkedRide:
    then = ride.actual_pickup_at
    wait_s = None if then is None else max((then - ride.earliest).total_seconds(), 0.0) + ride.before_s
    ends = [_end_of(day, ride) for day in (present, changed)]
    return ForkedRide(
        ride.ride,
        ride.ride_code,
        ride.from_stop,
        ride.to_stop,
        ride.party,
        ride.announced_at,
        ride.actual_state,
        None if wait_s is None else round(wait_s, 1),
        *ends[0],
        *ends[1],
    )


def _figures(rides: Sequence[ForkRide], day: FleetDay) -> DayFigures:
    """With the time that rides had waited at the moment already."""
    waits = [wait_s for ride in rides if (wait_s := _end_of(day, ride)[1]) is not None]
    return replace(
        figures_of(day),
        wait_median_s=round(float(np.percentile(waits, 50.0)), 1) if waits else None,
        wait_p95_s=round(float(np.percentile(waits, 95.0)), 1) if waits else None,
    )


def _end_of(day: FleetDay, ride: ForkRide) -> tuple[str, float | None]:
    outcome = day.outcomes[ride.ride]
    if outcome.cancelled:
        return "cancelled", None
    if outcome.pickup_s is None:
        return "refused", None
    return "served", round(outcome.pickup_s - outcome.earliest_s + ride.before_s, 1)

"""Simulates the dispatch of one day of rides for a fleet that drives exactly as planned.

There is no vehicle, no wire and no server: the dispatcher's schedule is advanced from event to event. A day
takes seconds, and two days can be compared ride by ride.
"""

import heapq
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from itertools import accumulate
from typing import Protocol

from contract.geometry import Array
from server.dispatch.answer import PromiseRules, answer_all
from server.dispatch.improve import CoolingSchedule, improve
from server.dispatch.problem import Problem, Request, VehicleState
from server.dispatch.schedule.schedule import Schedule
from server.dispatch.solve import without_deadline
from server.domain.rules import FleetRules
from server.travel.fleet_roads import FleetRoads
from server.usecases.planning.snapshot import seconds

_ATTEMPTS = 50
_IMPROVED_EVERY_S = 30.0
# No request is in the schedule for longer than its longest wait and ride plus this margin of its promise.
_MARGIN_S = 1800.0
# No window of a ride that is taken already ends before that.
_OPEN_S = 86_400.0
# Long after the last ride.
_THE_END_S = 1e6
_ANNOUNCED, _CANCELLED = 0, 1


class WantedRide(Protocol):
    """A ride that a passenger requests.

    announced_at  when it is booked; earliest: the earliest pickup
    cancelled_at  when it is cancelled, unless it is picked up before; None for never
    """

    @property
    def ride(self) -> str: ...
    @property
    def announced_at(self) -> datetime: ...
    @property
    def earliest(self) -> datetime: ...
    @property
    def from_stop(self) -> str: ...
    @property
    def to_stop(self) -> str: ...
    @property
    def party(self) -> int: ...
    @property
    def wheelchairs(self) -> int: ...
    @property
    def cancelled_at(self) -> datetime | None: ...


@dataclass(frozen=True, slots=True)
class Policy:
    """How rides are dispatched. slices: of improvement, every half a minute.

    departure_slack  as in `Schedule`
    """

    name: str
    text: str
    departure_slack: float = 0.0
    slices: int = 0


POLICIES: Mapping[str, Policy] = {
    policy.name: policy
    for policy in (
        Policy("insertion", "each ride is inserted where it costs least and is never moved"),
        Policy(
            "improvement", "insertion, then rides change positions and shuttles within their promises", 0.0, 8
        ),
        Policy("departure-slack", "insertion; shuttles depart later than they could", 0.75),
        Policy("departure-slack-improvement", "departure slack and improvement", 0.75, 8),
    )
}


@dataclass(frozen=True, slots=True)
class Shuttle:
    vehicle_id: str
    seats: int
    wheelchair_places: int


@dataclass(frozen=True, slots=True)
class Start:
    """Where a shuttle begins: (n,) seconds from there to every stop, and when it can set out."""

    to_stops_s: Array
    ready_s: float


@dataclass(slots=True)
class RideOutcome:
    """The result of a ride; times in seconds on the axis of the day, None if they did not happen.

    direct_s   the direct drive
    promise    pickup from, pickup to, arrival by; rule: why it was refused, "" if it was not
    """

    earliest_s: float
    direct_s: float
    dwell_s: float
    promise: tuple[float, float, float] | None = None
    rule: str = ""
    pickup_s: float | None = None
    arrival_s: float | None = None
    cancelled: bool = False


@dataclass(slots=True)
class FleetDay:
    """driven_s: of all shuttles; in_vain: rides cancelled when a shuttle was driving to the pickup."""

    outcomes: dict[str, RideOutcome] = field(default_factory=dict)
    driven_s: float = 0.0
    in_vain: int = 0


def run_day(
    rides: Sequence[WantedRide],
    fleet: Sequence[Shuttle],
    roads: FleetRoads,
    rules: FleetRules,
    policy: Policy,
    seed: int = 1,
    watch: Callable[[], None] = lambda: None,
    starts: Mapping[str, Start] | None = None,
    promised: frozenset[str] = frozenset(),
) -> FleetDay:
    """Answer every ride when it is announced, drive, improve and cancel, until the last ride has ended.

    rides   in the order of announcement, between stops of the map; fleet: at least one shuttle
    watch   called after each ride is answered
    starts  of shuttles, by id; the others begin at resting places
    promised  rides that are taken already, so that none of them is refused for its time
    """
    requests = {ride.ride: _request(ride, roads, rules, ride.ride in promised) for ride in rides}
    began_s = min(seconds(ride.announced_at) for ride in rides)
    begins = _starts(fleet, roads, began_s, starts or {})
    schedule = _schedule(fleet, roads, rules, begins, _rows_max(rides, requests), policy.departure_slack)
    promise_rules = _promise_rules(roads, rules)
    day = FleetDay()
    improved_s = began_s
    for at_s, kind, ride in _events(rides):
        while policy.slices and improved_s + _IMPROVED_EVERY_S < at_s:
            improved_s += _IMPROVED_EVERY_S
            if schedule.rows:
                _drive(schedule, improved_s, day)
                # The seed of each search differs, and is the same for every run of the day.
                search = seed + round(improved_s - began_s)
                improve(
                    schedule,
                    CoolingSchedule(policy.slices, _ATTEMPTS),
                    search,
                    policy.slices,
                    without_deadline,
                )
        _drive(schedule, at_s, day)
        if kind == _CANCELLED:
            _cancel(schedule, ride.ride, day)
        elif kind == _ANNOUNCED:
            request = requests[ride.ride]
            direct_s = float(schedule.problem.times[request.pickup, request.dropoff])
            day.outcomes[ride.ride] = RideOutcome(request.pickup_from_s, direct_s, rules.dwell_s)
            _answer(schedule, request, promise_rules, day.outcomes[ride.ride])
            watch()
    _drive(schedule, began_s + _THE_END_S, day)
    day.driven_s = schedule.driven_s
    return day


def _events(rides: Sequence[WantedRide]) -> Iterator[tuple[float, int, WantedRide]]:
    """In order of time; an announcement comes before a cancellation in the same second."""
    announced = [(seconds(ride.announced_at), _ANNOUNCED, k) for k, ride in enumerate(rides)]
    cancelled = [
        (max(seconds(ride.cancelled_at), seconds(ride.announced_at)), _CANCELLED, k)
        for k, ride in enumerate(rides)
        if ride.cancelled_at is not None
    ]
    for at_s, kind, k in heapq.merge(sorted(announced), sorted(cancelled)):
        yield at_s, kind, rides[k]


def _answer(schedule: Schedule, request: Request, promise_rules: PromiseRules, outcome: RideOutcome) -> None:
    schedule.add(request)
    answer = answer_all(schedule, [request.request_id], promise_rules)[0]
    outcome.promise, outcome.rule = answer.windows, answer.rule


def _cancel(schedule: Schedule, name: str, day: FleetDay) -> None:
    """A ride that is refused or picked up is not cancelled."""
    outcome = day.outcomes[name]
    if outcome.rule or outcome.pickup_s is not None:
        return
    outcome.cancelled = True
    day.in_vain += schedule.withdraw(name)


def _drive(schedule: Schedule, now_s: float, day: FleetDay) -> None:
    for visit in schedule.advance(now_s):
        outcome = day.outcomes[visit.request_id]
        if visit.alights:
            outcome.arrival_s = visit.at_s
        else:
            outcome.pickup_s = visit.at_s


def _request(ride: WantedRide, roads: FleetRoads, rules: FleetRules, is_promised: bool) -> Request:
    """The request with the windows of a booking; with open ones if it is taken already."""
    direct_s = roads.direct_s(ride.from_stop, ride.to_stop)
    earliest_s = max(seconds(ride.earliest), seconds(ride.announced_at))
    return Request(
        request_id=ride.ride,
        pickup=roads.stop_numbers[ride.from_stop],
        dropoff=roads.stop_numbers[ride.to_stop],
        party=ride.party,
        wheelchairs=ride.wheelchairs,
        pickup_from_s=earliest_s,
        pickup_to_s=earliest_s + (_OPEN_S if is_promised else rules.wait_s_max),
        arrive_by_s=float("inf"),
        ride_s_max=_OPEN_S if is_promised else rules.ride_s_max(direct_s),
    )


def _promise_rules(roads: FleetRoads, rules: FleetRules) -> PromiseRules:
    """Without alternatives, because the simulated passengers take none."""
    return replace(roads.promise_rules(rules), later_s_max=0.0)


def _schedule(
    fleet: Sequence[Shuttle],
    roads: FleetRoads,
    rules: FleetRules,
    starts: Sequence[Start],
    spare: int,
    departure_slack: float,
) -> Schedule:
    """An empty schedule with every shuttle where it starts."""
    vehicles = tuple(
        VehicleState(
            shuttle.vehicle_id, start.to_stops_s, start.ready_s, shuttle.seats, shuttle.wheelchair_places
        )
        for shuttle, start in zip(fleet, starts, strict=True)
    )
    problem = Problem(vehicles, {}, roads.stop_times(frozenset()), dwell_s=rules.dwell_s)
    return Schedule(problem, spare, departure_slack)


def _starts(
    fleet: Sequence[Shuttle], roads: FleetRoads, began_s: float, known: Mapping[str, Start]
) -> list[Start]:
    """Where each shuttle starts; those of which that is not known, one at each resting place in turn."""
    resting = roads.network.road_map.resting_places
    return [
        known.get(shuttle.vehicle_id) or Start(roads.times_from_rest(resting[number % len(resting)]), began_s)
        for number, shuttle in enumerate(fleet)
    ]


def _rows_max(rides: Sequence[WantedRide], requests: Mapping[str, Request]) -> int:
    """The rows that the schedule needs at most; improvement takes longer with every row."""
    changes = [(seconds(ride.announced_at), 1) for ride in rides]
    for request in requests.values():
        longest_s = min(request.ride_s_max, _THE_END_S)
        changes.append((request.pickup_to_s + longest_s + _MARGIN_S, -1))
    return max(accumulate(change for _, change in sorted(changes)))

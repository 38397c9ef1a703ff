"""The fleet as the dispatcher sees it: rows of the store turned into a problem of numbers."""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np

from contract.geometry import Array
from contract.wire.messages import Status
from server.dispatch.problem import Call, Chain, Problem, Request, VehicleState
from server.domain.fleet.vehicles import Vehicle
from server.domain.instants import EPOCH
from server.domain.orders.sections import Occupancy
from server.domain.planning.plans import Plan, PlannedVisit
from server.domain.rides.rides import Ride, RideState
from server.domain.rules import FleetRules
from server.domain.service.timetable import Departure
from server.travel.fleet_roads import FleetRoads
from server.travel.held_sections import times_over_held
from server.usecases.planning.battery_limits import ChargeLimits, within_battery
from server.usecases.planning.shift_limits import with_shifts
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.roads.resting import can_rest
from server.usecases.roads.road_positions import ARRIVED_M, RoadPosition, road_position
from server.usecases.roads.section_reservations import SectionReservations

ON_THE_WAY = (RideState.ASSIGNED, RideState.BOARDING, RideState.ABOARD)


@dataclass(frozen=True, slots=True)
class Snapshot:
    """problem's vehicles are those that are placed, by id; chained: call_id -> (departure, its call);
    charging: vehicles that rest at a charger or nowhere."""

    problem: Problem
    plans: dict[str, Plan]
    rides: dict[str, Ride]
    positions: dict[str, RoadPosition]
    chained: dict[str, tuple[Departure, int]]
    reservations: SectionReservations
    charging: frozenset[str]


@dataclass(frozen=True, slots=True)
class _DriveState:
    """Where a vehicle is, how far ahead it could still stop for a new visit, and the visit it drives to."""

    here: RoadPosition
    stopping_m: float
    heading_for: str


def take_snapshot(
    uow: UnitOfWork, wanted: Sequence[Ride] = (), departures: Sequence[Departure] = ()
) -> Snapshot:
    """Everything under way, and the rides and departures that need a vehicle, in the given order."""
    reservations = SectionReservations(uow)
    plans = {plan.vehicle_id: plan for plan in uow.plans.all()}
    rides = {ride.ride_id: ride for ride in (*uow.rides.in_states(ON_THE_WAY), *wanted)}
    riders: dict[str, dict[str, Ride]] = defaultdict(dict)
    for ride in rides.values():
        riders[ride.vehicle_id or ""][ride.ride_id] = ride
    vehicles: list[VehicleState] = []
    positions: dict[str, RoadPosition] = {}
    charges: list[ChargeLimits] = []
    for vehicle in uow.vehicles.all():
        status = _status(uow, vehicle)
        if status is None:
            continue
        charges.append(ChargeLimits(status.battery_ratio, vehicle.charging))
        plan = plans.setdefault(vehicle.vehicle_id, Plan(uow.campus_id, vehicle.vehicle_id, 0))
        occupancy = reservations.occupancy(vehicle.vehicle_id)
        drives = _drive(uow, vehicle.vehicle_id, occupancy, status)
        positions[vehicle.vehicle_id] = drives.here
        state = _vehicle(uow, vehicle, plan, occupancy, drives, riders[vehicle.vehicle_id])
        if vehicle.shifts is not None:
            planned = _planned(uow, plan, state.calls)
            state = with_shifts(uow, vehicle.shifts, state, planned, _until(wanted, departures))
        vehicles.append(state)
    requests = {ride.ride_id: request_of(uow, ride) for ride in rides.values()}
    chains, chained = _chains(uow, departures)
    times = uow.roads().stop_times(frozenset())
    problem = Problem(
        vehicles=tuple(
            within_battery(uow, vehicle, charge, requests, times)
            for vehicle, charge in zip(vehicles, charges, strict=True)
        ),
        requests=requests,
        times=times,
        open_requests=tuple(ride.ride_id for ride in wanted),
        open_chains=chains,
        dwell_s=uow.rules.dwell_s,
    )
    charging = frozenset(
        vehicle.vehicle_id for vehicle, charge in zip(vehicles, charges, strict=True) if charge.charging
    )
    return Snapshot(problem, plans, rides, positions, chained, reservations, charging)


def _planned(uow: UnitOfWork, plan: Plan, calls: Sequence[Call]) -> list[datetime]:
    """When each call is made as planned so far."""
    visits = {visit.visit_id: visit for visit in plan.visits}
    found = []
    for call in calls:
        visit = visits.get(call.call_id)
        known = [] if visit is None else [at for at in (visit.eta, visit.not_before) if at is not None]
        found.append(max([uow.now, *known]))
    return found


def _until(wanted: Sequence[Ride], departures: Sequence[Departure]) -> datetime:
    """The latest requested beginning of these."""
    begins = [ride.earliest if ride.promise is None else ride.promise.pickup_from for ride in wanted]
    return max([EPOCH, *begins, *(departure.calls[-1].leave_at for departure in departures)])


def seconds(moment: datetime) -> float:
    return moment.timestamp()


def moment(seconds_s: float) -> datetime:
    return EPOCH + timedelta(seconds=seconds_s)


def _status(uow: UnitOfWork, vehicle: Vehicle) -> Status | None:
    where = uow.vehicles.whereabouts(vehicle.vehicle_id) if vehicle.placed else None
    return None if where is None else where.status


def _drive(uow: UnitOfWork, vehicle_id: str, occupancy: Occupancy, status: Status) -> _DriveState:
    def make() -> _DriveState:
        here = road_position(uow.network(), occupancy.held_ids, status)
        return _DriveState(here, uow.rules.stopping_m(status.speed_mps), status.visit_id)

    return uow.roads().results.get(f"drive {vehicle_id}", (occupancy, status, uow.rules), make)


def _vehicle(
    uow: UnitOfWork,
    vehicle: Vehicle,
    plan: Plan,
    occupancy: Occupancy,
    drives: _DriveState,
    mine: dict[str, Ride],
) -> VehicleState:
    """mine: the vehicle's rides, those that are wanted left out."""
    roads = uow.roads()
    visits = [visit for visit in plan.visits if visit.kind == "stop" and _is_needed(visit, mine)]
    inside = tuple(ride_id for ride_id, ride in mine.items() if ride.state is RideState.ABOARD)
    return VehicleState(
        vehicle_id=vehicle.vehicle_id,
        to_places_s=roads.results.get(
            f"to stops {vehicle.vehicle_id}",
            (plan, occupancy, drives, visits[0] if visits else None),
            lambda: _to_stops_s(roads, plan, visits, occupancy, drives),
        ),
        ready_s=seconds(max(uow.now, vehicle.hold_ends or uow.now)),
        seats=vehicle.seats,
        wheelchair_places=vehicle.wheelchair_places,
        aboard=inside,
        calls=(
            *(_call(uow, visit, mine) for visit in visits),
            *_missing_drop_offs(uow, visits, mine),
        ),
        locked=1 if visits and visits[0].state == "under_way" else 0,
        accepts=vehicle.accepts_rides and (not roads.closed or can_rest(uow, plan, drives.here)),
    )


def _is_needed(visit: PlannedVisit, mine: dict[str, Ride]) -> bool:
    """The visit still has a purpose: riders of this vehicle, a departure, or no riders from the start."""
    riders = (*visit.board, *visit.alight)
    return (
        visit.state == "under_way"
        or bool(visit.departure_id)
        or not riders
        or any(ride_id in mine for ride_id in riders)
    )


def _missing_drop_offs(uow: UnitOfWork, visits: Sequence[PlannedVisit], mine: dict[str, Ride]) -> list[Call]:
    """Calls for riders aboard who have no visit to get out."""
    let_out = {ride_id for visit in visits for ride_id in visit.alight}
    places, dwell_s, factor = uow.roads().stop_numbers, uow.rules.dwell_s, uow.travel_time_factor_at(uow.now)
    return [
        Call(places[ride.to_stop], (), (ride_id,), dwell_s, travel_time_factor=factor)
        for ride_id, ride in mine.items()
        if ride.state is RideState.ABOARD and ride_id not in let_out
    ]


def _to_stops_s(
    roads: FleetRoads,
    plan: Plan,
    visits: Sequence[PlannedVisit],
    occupancy: Occupancy,
    drives: _DriveState,
) -> Array:
    """(stops,) planned seconds from the vehicle's own place."""
    here = drives.here
    own = frozenset({plan.resting_place_id})
    opened = frozenset((*occupancy.held_ids, *occupancy.ahead))
    held = occupancy.held_ids[here.index :]
    is_going_there = bool(visits) and visits[0].visit_id == drives.heading_for
    heading_for = visits[0].stop_id if is_going_there else ""
    place = (here.lane_id, here.s_m)
    row = times_over_held(roads, held, place, own, opened, drives.stopping_m, heading_for)
    if roads.closed:
        row = roads.without_closed_stops(row, [visit.stop_id for visit in visits])
    if visits and _is_there(visits[0], here):
        row[roads.stop_numbers[visits[0].stop_id]] = 0.0
    return row


def _is_there(visit: PlannedVisit, here: RoadPosition) -> bool:
    """The vehicle stands at the visit, or is past it within the noise of its position."""
    beyond_m = here.s_m - visit.s_m if here.lane_id == visit.lane_id else -1.0
    return visit.state == "under_way" or 0.0 <= beyond_m <= ARRIVED_M


def _call(uow: UnitOfWork, visit: PlannedVisit, mine: dict[str, Ride]) -> Call:
    roads, timed = uow.roads(), bool(visit.departure_id)
    return Call(
        place=roads.stop_numbers[visit.stop_id],
        board=tuple(r for r in visit.board if r in mine and mine[r].state is not RideState.ABOARD),
        alight=tuple(r for r in visit.alight if r in mine),
        dwell_s=visit.dwell_s,
        leave_from_s=seconds(visit.not_before) if timed and visit.not_before else -np.inf,
        arrive_by_s=seconds(visit.latest) if timed and visit.latest else np.inf,
        fixed=timed or not (visit.board or visit.alight),
        call_id=visit.visit_id,
        travel_time_factor=uow.travel_time_factor_at(max(uow.now, visit.not_before or uow.now)),
    )


def request_of(uow: UnitOfWork, ride: Ride) -> Request:
    begins = ride.earliest if ride.promise is None else ride.promise.pickup_from
    factor = uow.travel_time_factor_at(max(uow.now, begins))
    known = uow.roads().results.get(
        f"request {ride.ride_id}", (ride, uow.rules), lambda: _request(uow.roads(), uow.rules, ride, factor)
    )
    return known if known.travel_time_factor == factor else _request(uow.roads(), uow.rules, ride, factor)


def _request(roads: FleetRoads, rules: FleetRules, ride: Ride, factor: float) -> Request:
    direct_s = roads.direct_s(ride.from_stop, ride.to_stop)
    promise = ride.promise
    earliest_s = seconds(max(ride.earliest, ride.requested_at))
    pickup_to_s, arrive_by_s = earliest_s + rules.wait_s_max, _arrive_by_s(ride)
    if promise is not None:
        ahead_s = (promise.pickup_to - ride.requested_at).total_seconds()
        # The reserve is kept from others: a ride without a vehicle may use its whole promise.
        is_planned = ride.vehicle_id is not None
        reserve_s = rules.reserve_s(ahead_s, told_anew=ride.promise_broken) if is_planned else 0.0
        pickup_to_s, arrive_by_s = seconds(promise.pickup_to) - reserve_s, arrive_by_s - reserve_s
    return Request(
        request_id=ride.ride_id,
        pickup=roads.stop_numbers[ride.from_stop],
        dropoff=roads.stop_numbers[ride.to_stop],
        party=ride.party,
        wheelchairs=ride.wheelchairs,
        pickup_from_s=earliest_s if promise is None else seconds(promise.pickup_from),
        pickup_to_s=pickup_to_s,
        arrive_by_s=arrive_by_s,
        ride_s_max=rules.ride_s_max(direct_s * factor),
        pinned=ride.pinned,
        travel_time_factor=factor,
    )


def _arrive_by_s(ride: Ride) -> float:
    """The latest arrival. A promise is kept even after the service closes."""
    latest = ride.arrive_before if ride.promise is None else ride.promise.arrive_by
    return math.inf if latest is None else seconds(latest)


def _chains(
    uow: UnitOfWork, departures: Sequence[Departure]
) -> tuple[tuple[Chain, ...], dict[str, tuple[Departure, int]]]:
    """Each departure as timed calls.

    The first call has to be made within the tolerance. If planned driving is slower than the timetable, the
    later calls follow as fast as it allows, so that a careful plan does not refuse a timetable.
    """
    roads, dwell_s = uow.roads(), uow.rules.dwell_s
    tolerance_s = uow.rules.departure_tolerance_s
    every = frozenset(roads.network.resting_places)
    drive = roads.stop_times(every)
    chains: list[Chain] = []
    chained: dict[str, tuple[Departure, int]] = {}
    for departure in departures:
        calls: list[Call] = []
        arrive_s = -np.inf
        for number, call in enumerate(departure.calls):
            call_id = f"{departure.departure_id}#{number}"
            chained[call_id] = departure, number
            place, leave_s = roads.stop_numbers[call.stop_id], seconds(call.leave_at)
            factor = uow.travel_time_factor_at(call.leave_at)
            if calls:
                left_s = max(calls[-1].leave_from_s, arrive_s + dwell_s)
                arrive_s = left_s + factor * float(drive[calls[-1].place, place])
            calls.append(
                Call(
                    place=place,
                    dwell_s=dwell_s,
                    leave_from_s=leave_s,
                    arrive_by_s=max(leave_s - dwell_s, arrive_s) + tolerance_s,
                    fixed=True,
                    call_id=call_id,
                    travel_time_factor=factor,
                )
            )
        chains.append(Chain(departure.departure_id, tuple(calls)))
    return tuple(chains), chained

"""What the present plans mean for those who wait and ride: when they are picked up, and how full it gets."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from server.domain.fleet.vehicles import Vehicle
from server.domain.planning.eta_ranges import (
    ExpectedRange,
    PlannedArrival,
    PlannedPickup,
    PlannedRide,
    arrival_range,
    pickup_range,
    waiting_arrival_range,
)
from server.domain.planning.outlooks import NO_OUTLOOK, RideOutlook
from server.domain.planning.plans import Plan, PlannedVisit
from server.domain.rides.rides import Ride, RideState
from server.domain.service.timetable import Departure
from server.usecases.ports.unit_of_work import UnitOfWork

_WITH_SHUTTLE = frozenset({RideState.ASSIGNED, RideState.BOARDING, RideState.ABOARD})
# From so many vehicles on, all are read at once.
_MANY = 4


@dataclass(frozen=True, slots=True)
class _Fleet:
    """What outlooks are made of: vehicles, plans and people aboard by vehicle id, parties under way by ride
    id."""

    vehicles: Mapping[str, Vehicle]
    plans: Mapping[str, Plan]
    aboard: Mapping[str, int]
    parties: Mapping[str, int]


def outlook_of(uow: UnitOfWork, ride: Ride) -> RideOutlook:
    """A ride that has ended has the name of its shuttle alone; one that never had a shuttle has nothing.

    A shuttle that stands or is out of reach promises no time.
    """
    return outlooks_of(uow, (ride,))[ride.ride_id]


def outlooks_of(uow: UnitOfWork, rides: Sequence[Ride]) -> Mapping[str, RideOutlook]:
    """`outlook_of` by ride id; for many rides the fleet is read once."""
    fleet = _fleet(uow, {ride.vehicle_id for ride in rides if ride.vehicle_id is not None})
    return {ride.ride_id: _outlook(uow, fleet, ride) for ride in rides}


def seats_left_of(uow: UnitOfWork, departure: Departure) -> tuple[int | None, ...]:
    """Free seats when the departure leaves each of its calls; None without a shuttle and after the call."""
    vehicle_id = departure.vehicle_id
    fleet = _fleet(uow, set() if vehicle_id is None else {vehicle_id})
    plan, vehicle = fleet.plans.get(vehicle_id or ""), fleet.vehicles.get(vehicle_id or "")
    if plan is None or vehicle is None:
        return (None,) * len(departure.calls)
    free = _seats_left_by_visit(fleet, plan, vehicle.seats)
    visits = {v.call: v.visit_id for v in plan.visits if v.departure_id == departure.departure_id}
    return tuple(free[visits[number]] if number in visits else None for number in range(len(departure.calls)))


def seats_left_at(uow: UnitOfWork, vehicle: Vehicle, plan: Plan) -> Mapping[str, int]:
    """Free seats when the vehicle leaves each visit of its plan, by visit id."""
    return _seats_left_by_visit(_fleet(uow, {vehicle.vehicle_id}), plan, vehicle.seats)


def people_after(plan: Plan, parties: Mapping[str, int], aboard: int) -> dict[str, int]:
    """How many people are aboard after each visit, by visit id. parties: people by ride id."""
    found: dict[str, int] = {}
    for visit in plan.visits:
        aboard += sum(parties.get(ride_id, 0) for ride_id in visit.board)
        aboard -= sum(parties.get(ride_id, 0) for ride_id in visit.alight)
        found[visit.visit_id] = aboard
    return found


def _fleet(uow: UnitOfWork, vehicle_ids: set[str]) -> _Fleet:
    states = sorted(_WITH_SHUTTLE)
    if len(vehicle_ids) < _MANY:
        found = [vehicle for name in sorted(vehicle_ids) if (vehicle := uow.vehicles.get(name)) is not None]
        plans = [plan for vehicle in found if (plan := uow.plans.get(vehicle.vehicle_id)) is not None]
        rides = [ride for vehicle in found for ride in uow.rides.of_vehicle(vehicle.vehicle_id, states)]
    else:
        found, plans, rides = (
            list(uow.vehicles.all()),
            list(uow.plans.all()),
            list(uow.rides.in_states(states)),
        )
        retired = vehicle_ids - {vehicle.vehicle_id for vehicle in found}
        found += [vehicle for name in sorted(retired) if (vehicle := uow.vehicles.get(name)) is not None]
    aboard = Counter[str]()
    for ride in rides:
        if ride.state is RideState.ABOARD:
            aboard[ride.vehicle_id or ""] += ride.party
    return _Fleet(
        {vehicle.vehicle_id: vehicle for vehicle in found},
        {plan.vehicle_id: plan for plan in plans},
        aboard,
        {ride.ride_id: ride.party for ride in rides},
    )


def _outlook(uow: UnitOfWork, fleet: _Fleet, ride: Ride) -> RideOutlook:
    vehicle = fleet.vehicles.get(ride.vehicle_id or "")
    if vehicle is None:
        return NO_OUTLOOK
    plan = fleet.plans.get(vehicle.vehicle_id) if ride.state in _WITH_SHUTTLE else None
    if plan is None:
        return RideOutlook(vehicle_name=vehicle.name)
    can_tell = vehicle.connected and not vehicle.held
    return RideOutlook(
        pickup=_pickup(uow, plan, ride) if can_tell and ride.state is RideState.ASSIGNED else None,
        arrival=_arrival(uow, plan, ride) if can_tell else None,
        seats_left=_seats_left(fleet, plan, ride, vehicle.seats),
        vehicle_name=vehicle.name,
    )


def _pickup(uow: UnitOfWork, plan: Plan, ride: Ride) -> ExpectedRange | None:
    stops = [visit for visit in plan.visits if visit.kind == "stop"]
    number = next((i for i, visit in enumerate(stops) if ride.ride_id in visit.board), None)
    if number is None or ride.pickup_eta is None or ride.promise is None:
        return None
    return pickup_range(uow.now, PlannedPickup(ride.pickup_eta, ride.promise.pickup_from, number))


def _arrival(uow: UnitOfWork, plan: Plan, ride: Ride) -> ExpectedRange | None:
    stops = [visit for visit in plan.visits if visit.kind == "stop"]
    number = next((i for i, visit in enumerate(stops) if ride.ride_id in visit.alight), None)
    if number is None or ride.arrival_eta is None:
        return None
    if ride.state is RideState.ASSIGNED:
        return _arrival_of_waiting(uow, stops, ride, number)
    if ride.state is not RideState.ABOARD:
        return None
    return arrival_range(uow.now, PlannedArrival(ride.arrival_eta, number))


def _arrival_of_waiting(
    uow: UnitOfWork, stops: Sequence[PlannedVisit], ride: Ride, number: int
) -> ExpectedRange | None:
    """number: of the stop at which it gets off"""
    boards = next((i for i, visit in enumerate(stops) if ride.ride_id in visit.board), None)
    if boards is None or ride.pickup_eta is None or ride.promise is None or ride.arrival_eta is None:
        return None
    pickup = PlannedPickup(ride.pickup_eta, ride.promise.pickup_from, boards)
    return waiting_arrival_range(uow.now, PlannedRide(pickup, ride.arrival_eta, number - boards - 1))


def _seats_left(fleet: _Fleet, plan: Plan, ride: Ride, seats: int) -> int | None:
    """On the fullest part of the ride; None if the plan does not have its end."""
    begins = next((i for i, visit in enumerate(plan.visits) if ride.ride_id in visit.board), 0)
    ends = next((i for i, visit in enumerate(plan.visits) if ride.ride_id in visit.alight), None)
    if ends is None:
        return None
    free = _seats_left_by_visit(fleet, plan, seats)
    shared = plan.visits[begins:ends]
    if not shared:
        return max(0, seats - fleet.aboard.get(plan.vehicle_id, 0))
    return min(free[visit.visit_id] for visit in shared)


def _seats_left_by_visit(fleet: _Fleet, plan: Plan, seats: int) -> dict[str, int]:
    """Free seats when the vehicle leaves each visit, by visit id, as planned."""
    people = people_after(plan, fleet.parties, fleet.aboard.get(plan.vehicle_id, 0))
    return {visit_id: max(0, seats - count) for visit_id, count in people.items()}

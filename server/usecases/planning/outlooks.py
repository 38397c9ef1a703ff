"""What the present plans mean for those who wait and ride: when they are picked up, and how full it gets."""

from collections.abc import Mapping

from server.domain.planning.eta_ranges import PickupRange, PlannedPickup, pickup_range
from server.domain.planning.outlooks import NO_OUTLOOK, RideOutlook
from server.domain.planning.plans import Plan
from server.domain.rides.rides import Ride, RideState
from server.domain.service.timetable import Departure
from server.usecases.ports.unit_of_work import UnitOfWork

_WITH_SHUTTLE = frozenset({RideState.ASSIGNED, RideState.BOARDING, RideState.ABOARD})


def outlook_of(uow: UnitOfWork, ride: Ride) -> RideOutlook:
    """A ride that has ended has the name of its shuttle alone; one that never had a shuttle has nothing.

    A shuttle that stands or is out of reach promises no time.
    """
    vehicle = None if ride.vehicle_id is None else uow.vehicles.get(ride.vehicle_id)
    if vehicle is None:
        return NO_OUTLOOK
    plan = uow.plans.get(vehicle.vehicle_id) if ride.state in _WITH_SHUTTLE else None
    if plan is None:
        return RideOutlook(vehicle_name=vehicle.name)
    can_promise = ride.state is RideState.ASSIGNED and vehicle.connected and not vehicle.held
    return RideOutlook(
        pickup=_pickup(uow, plan, ride) if can_promise else None,
        seats_left=_seats_left(uow, plan, ride, vehicle.seats),
        vehicle_name=vehicle.name,
    )


def outlooks_of(uow: UnitOfWork, rides: tuple[Ride, ...]) -> Mapping[str, RideOutlook]:
    """By ride id."""
    return {ride.ride_id: outlook_of(uow, ride) for ride in rides}


def seats_left_of(uow: UnitOfWork, departure: Departure) -> tuple[int | None, ...]:
    """Free seats when the departure leaves each of its calls; None without a shuttle and after the call."""
    plan = None if departure.vehicle_id is None else uow.plans.get(departure.vehicle_id)
    vehicle = None if departure.vehicle_id is None else uow.vehicles.get(departure.vehicle_id)
    if plan is None or vehicle is None:
        return (None,) * len(departure.calls)
    free = seats_left_by_visit(uow, plan, vehicle.seats)
    visits = {v.call: v.visit_id for v in plan.visits if v.departure_id == departure.departure_id}
    return tuple(free[visits[number]] if number in visits else None for number in range(len(departure.calls)))


def seats_left_by_visit(uow: UnitOfWork, plan: Plan, seats: int) -> dict[str, int]:
    """Free seats when the vehicle leaves each visit, by visit id, as planned."""
    return {
        visit_id: max(0, seats - people)
        for visit_id, people in people_after(plan, _parties(uow, plan), _people_aboard(uow, plan)).items()
    }


def people_after(plan: Plan, parties: Mapping[str, int], aboard: int) -> dict[str, int]:
    """How many people are aboard after each visit, by visit id. parties: people by ride id."""
    found: dict[str, int] = {}
    for visit in plan.visits:
        aboard += sum(parties.get(ride_id, 0) for ride_id in visit.board)
        aboard -= sum(parties.get(ride_id, 0) for ride_id in visit.alight)
        found[visit.visit_id] = aboard
    return found


def _pickup(uow: UnitOfWork, plan: Plan, ride: Ride) -> PickupRange | None:
    stops = [visit for visit in plan.visits if visit.kind == "stop"]
    number = next((i for i, visit in enumerate(stops) if ride.ride_id in visit.board), None)
    if number is None or ride.pickup_eta is None or ride.promise is None:
        return None
    return pickup_range(uow.now, PlannedPickup(ride.pickup_eta, ride.promise.pickup_from, number))


def _seats_left(uow: UnitOfWork, plan: Plan, ride: Ride, seats: int) -> int | None:
    """On the fullest part of the ride; None if the plan does not have its end."""
    begins = next((i for i, visit in enumerate(plan.visits) if ride.ride_id in visit.board), 0)
    ends = next((i for i, visit in enumerate(plan.visits) if ride.ride_id in visit.alight), None)
    if ends is None:
        return None
    free = seats_left_by_visit(uow, plan, seats)
    shared = plan.visits[begins:ends]
    if not shared:
        return max(0, seats - _people_aboard(uow, plan))
    return min(free[visit.visit_id] for visit in shared)


def _parties(uow: UnitOfWork, plan: Plan) -> dict[str, int]:
    rides = (uow.rides.get(ride_id) for ride_id in plan.ride_ids)
    return {ride.ride_id: ride.party for ride in rides if ride is not None}


def _people_aboard(uow: UnitOfWork, plan: Plan) -> int:
    return sum(ride.party for ride in uow.rides.of_vehicle(plan.vehicle_id, [RideState.ABOARD]))

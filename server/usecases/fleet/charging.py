"""Manages batteries: which vehicles go to charge, which drive again, and what happens below the reserve."""

from dataclasses import replace

from server.domain.fleet.battery import is_measured
from server.domain.fleet.vehicles import Vehicle
from server.domain.planning.plans import Plan
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import RideState
from server.usecases.planning import plans
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.incidents import clear_incident, open_incident
from server.usecases.record.server_events import THE_SERVER, record_event

_TAKEN = (RideState.ASSIGNED, RideState.BOARDING, RideState.ABOARD)


def manage_charging(uow: UnitOfWork) -> tuple[str, ...]:
    """Send idle vehicles with little charge to a charger, and take rides from those that cannot make them.

    Returns the vehicles that changed.
    """
    ratios = {
        where.vehicle_id: where.status.battery_ratio
        for where in uow.vehicles.all_whereabouts()
        if where.status is not None and is_measured(where.status.battery_ratio)
    }
    busy = {ride.vehicle_id for ride in uow.rides.in_states(_TAKEN)}
    changed, gave_away = [], False
    for vehicle in uow.vehicles.all():
        ratio = ratios.get(vehicle.vehicle_id)
        if ratio is None or not vehicle.placed:
            continue
        if ratio < uow.rules.battery_reserve_ratio:
            if _relieve(uow, vehicle, ratio):
                changed.append(vehicle.vehicle_id)
                gave_away = True
            continue
        if ratio >= uow.rules.battery_charge_below_ratio:
            clear_incident(uow, IncidentKind.BATTERY_LOW, vehicle.vehicle_id)
        if _update_charging(uow, vehicle, ratio, is_busy=vehicle.vehicle_id in busy):
            changed.append(vehicle.vehicle_id)
    if gave_away:
        plans.assign_waiting(uow)
    _go_to_chargers(uow)
    return tuple(changed)


def _update_charging(uow: UnitOfWork, vehicle: Vehicle, ratio: float, *, is_busy: bool) -> bool:
    """Record that a vehicle goes to charge, or has charged."""
    rules = uow.rules
    charging = vehicle.charging
    if not charging:
        plan = uow.plans.get(vehicle.vehicle_id)
        is_idle = not is_busy and (plan is None or not _has_stops(plan))
        charging = ratio < rules.battery_charge_below_ratio and is_idle
    elif ratio >= rules.battery_full_ratio or (is_busy and ratio >= rules.battery_accept_ratio):
        charging = False
    return _save_charging(
        uow, vehicle, "vehicle.charging" if charging else "vehicle.charged", ratio, charging
    )


def _relieve(uow: UnitOfWork, vehicle: Vehicle, ratio: float) -> bool:
    """Below the reserve: riders aboard reach their stops, and all other work is given away."""
    vehicle_id = vehicle.vehicle_id
    is_news = uow.incidents.open_about(IncidentKind.BATTERY_LOW, vehicle_id) is None
    cause = (
        f"battery at {100.0 * ratio:.0f} %, below the reserve; its riders reach their stops, "
        "other shuttles get the rest"
    )
    open_incident(uow, IncidentKind.BATTERY_LOW, vehicle_id, cause, vehicle_id=vehicle_id)
    _save_charging(uow, vehicle, "vehicle.battery_low", ratio, charging=True)
    waiting = uow.rides.of_vehicle(vehicle_id, [RideState.ASSIGNED])
    if not is_news and not waiting:
        return False
    plans.requeue(uow, vehicle_id, [ride.ride_id for ride in waiting])
    plans.release_departures(uow, vehicle_id)
    plans.try_planning(uow, vehicle_id, plans.replan)
    return True


def _go_to_chargers(uow: UnitOfWork) -> None:
    """Send vehicles that only have to charge, and are not at a charger, to a free one."""
    chargers = {place.place_id for place in uow.network().road_map.charging_places}
    known = {plan.vehicle_id: plan for plan in uow.plans.all()}
    for vehicle in uow.vehicles.all():
        plan = known.get(vehicle.vehicle_id)
        if not vehicle.charging or not vehicle.placed or plan is None or _has_stops(plan):
            continue
        free = chargers - {other.resting_place_id for other in uow.plans.all()}
        if plan.resting_place_id not in chargers and free:
            plans.try_planning(uow, vehicle.vehicle_id, plans.choose_resting_place)


def _has_stops(plan: Plan) -> bool:
    return any(visit.kind == "stop" for visit in plan.visits)


def _save_charging(uow: UnitOfWork, vehicle: Vehicle, name: str, ratio: float, charging: bool) -> bool:
    if vehicle.charging == charging:
        return False
    vehicle_id = vehicle.vehicle_id
    uow.vehicles.save(replace(vehicle, charging=charging))
    record_event(uow, name, vehicle_id, THE_SERVER, f"{100.0 * ratio:.0f} %")
    uow.publish(topics.vehicle(uow.campus_id, vehicle_id))
    return True

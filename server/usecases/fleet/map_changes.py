"""What becomes of the shuttles when another map is put in force, and how each of them learns of it."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

from contract.roads.changes import changed_lanes
from contract.roads.network import RoadNetwork
from contract.wire.bounds import LONG_CHARACTERS_MAX
from contract.wire.maps import MapPublished
from contract.wire.messages import MapChangeFailed
from server.domain.errors import MapInUse
from server.domain.fleet.vehicles import Vehicle
from server.domain.orders.orders import IssuedOrder, OrderState
from server.domain.orders.sections import Occupancy
from server.domain.planning.plans import Plan
from server.domain.record.incidents import IncidentKind
from server.travel.fleet_roads import FleetRoads
from server.usecases.fleet.conditions import with_availability
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.record.incidents import clear_incident, open_incident
from server.usecases.record.server_events import record_event

OLD_AGENT = "old_agent"


@dataclass(frozen=True, slots=True)
class _Shuttle:
    """What of one shuttle rests on the map."""

    vehicle: Vehicle
    plan: Plan | None
    order: IssuedOrder | None
    occupancy: Occupancy | None

    @property
    def is_under_way(self) -> bool:
        return self.plan is not None and bool(self.plan.visits)


def take_to(uow: UnitOfWork, before: FleetRoads, after: FleetRoads) -> None:
    """Prepare all shuttles for another map, just before it is put in force.

    A shuttle whose sections, visits and resting place are the same in both maps keeps them, under way or not.
    Another one that has no visits gives its sections back, and is placed again by its first report once it
    drives by the new map. Raises MapInUse for a shuttle that is under way on what the map changes: it must
    finish first.
    """
    shuttles = [_shuttle(uow, vehicle) for vehicle in uow.vehicles.all()]
    changed = changed_lanes(before.network, after.network)
    kept = []
    for shuttle in shuttles:
        what = _changed_for(shuttle, before.network, after.network, changed)
        if what and shuttle.is_under_way:
            raise MapInUse(
                f"{shuttle.vehicle.vehicle_id} is under way and needs {what}, which this map changes; "
                "publish when it has finished, or close that road first"
            )
        if not what:
            kept.append(shuttle)
    kept = _free_of_conflicts(kept, after)
    names = {shuttle.vehicle.vehicle_id for shuttle in kept}
    for shuttle in shuttles:
        _enter(uow, shuttle, is_kept=shuttle.vehicle.vehicle_id in names)


def announcement(uow: UnitOfWork, vehicle_id: str, announced: str) -> MapPublished | None:
    """The map in force, for a vehicle that drives by another one; None if there is nothing to say.

    announced  the version that this session has told the vehicle last, "" for none: the vehicle may be on its
               way to that one. Raises VehicleUnknown.
    """
    vehicle, active = enrolled_vehicle(uow, vehicle_id), uow.maps.active_version()
    is_known = vehicle.map_version in ("", active) and announced in ("", active)
    if active is None or is_known:
        return None
    stored = uow.maps.get(active)
    assert stored is not None, "the active map is stored"
    return MapPublished(vehicle.epoch, active, _sha256(stored.content), len(stored.content))


@lru_cache(maxsize=4)
def _sha256(content: bytes) -> str:
    """Asked once a second for every vehicle that has not changed over yet."""
    return hashlib.sha256(content).hexdigest()


def change_failed(uow: UnitOfWork, vehicle: Vehicle, event: MapChangeFailed) -> None:
    """The vehicle stays with the map that it has, and gets no rides until it has the one in force."""
    vehicle_id, cause = vehicle.vehicle_id, f"{event.code}: {event.detail}"[:LONG_CHARACTERS_MAX]
    record_event(uow, "vehicle.map_change_failed", vehicle_id, vehicle_id, f"{event.map_version} {cause}")
    if event.map_version != uow.maps.active_version() or vehicle.map_version == event.map_version:
        return  # another map has been published since, or the vehicle has succeeded
    _save_failure(uow, vehicle, event.code, cause)


def note_old_agent(uow: UnitOfWork, vehicle_id: str) -> None:
    """The vehicle drives by another map and its software cannot fetch one. Raises VehicleUnknown."""
    vehicle = enrolled_vehicle(uow, vehicle_id)
    if vehicle.map_failure != OLD_AGENT:
        cause = "its software cannot download maps: update it, or give it the map by hand"
        _save_failure(uow, vehicle, OLD_AGENT, cause)


def _save_failure(uow: UnitOfWork, vehicle: Vehicle, code: str, cause: str) -> None:
    vehicle_id = vehicle.vehicle_id
    open_incident(uow, IncidentKind.MAP_NOT_CHANGED, vehicle_id, cause, vehicle_id=vehicle_id)
    uow.vehicles.save(with_availability(uow, replace(vehicle, map_failure=code)))
    uow.publish(topics.dispatch(uow.campus_id))


def with_reported_map(uow: UnitOfWork, vehicle: Vehicle) -> Vehicle:
    """The vehicle after its hello: if it drives by the map in force, its failure is over."""
    if vehicle.map_version != uow.maps.active_version():
        return vehicle
    clear_incident(uow, IncidentKind.MAP_NOT_CHANGED, vehicle.vehicle_id)
    return replace(vehicle, map_failure="")


def _shuttle(uow: UnitOfWork, vehicle: Vehicle) -> _Shuttle:
    vehicle_id = vehicle.vehicle_id
    found = {one.vehicle_id: one for one in uow.sections.all()}
    order = uow.orders.current(vehicle_id)
    is_over = order is None or order.state is OrderState.DONE
    return _Shuttle(vehicle, uow.plans.get(vehicle_id), None if is_over else order, found.get(vehicle_id))


def _changed_for(shuttle: _Shuttle, before: RoadNetwork, after: RoadNetwork, changed: frozenset[str]) -> str:
    """The first thing that the shuttle needs and the map changes, in words; "" if there is none."""
    plan = shuttle.plan
    if plan is not None and plan.resting_place_id:
        place_id = plan.resting_place_id
        if before.resting_places.get(place_id) != after.resting_places.get(place_id):
            return f"resting place {place_id}"
    for stop_id in () if plan is None else [visit.stop_id for visit in plan.visits if visit.stop_id]:
        old, new = before.stops.get(stop_id), after.stops.get(stop_id)
        if old is None or new is None or (old.lane_id, old.s_m) != (new.lane_id, new.s_m):
            return f"stop {stop_id}"
    return next((f"lane {lane_id}" for lane_id in _lanes(shuttle, before) if lane_id in changed), "")


def _lanes(shuttle: _Shuttle, network: RoadNetwork) -> Iterator[str]:
    """Those that it holds, drives over and goes to. One that the present map lacks is none of its roads."""
    if shuttle.occupancy is not None:
        for section_id in (*shuttle.occupancy.held_ids, *shuttle.occupancy.ahead):
            yield network.sections[section_id].lane_id
    if shuttle.plan is not None:
        yield from (visit.lane_id for visit in shuttle.plan.visits)
    if shuttle.order is not None and shuttle.is_under_way:
        for visit in shuttle.order.payload.visits:
            yield from visit.route


def _free_of_conflicts(kept: list[_Shuttle], after: FleetRoads) -> list[_Shuttle]:
    """Those that can go on in the new map. Its conflicts may be others: then who rests gives way.

    Raises MapInUse if shuttles under way would stand on one piece of road, or block each other.
    """
    moving = [shuttle for shuttle in kept if shuttle.is_under_way]
    if not _are_safe(moving, after):
        names = ", ".join(shuttle.vehicle.vehicle_id for shuttle in moving)
        raise MapInUse(f"{names} could block each other on this map; publish when they have finished")
    return kept if _are_safe(kept, after) else moving


def _are_safe(shuttles: list[_Shuttle], roads: FleetRoads) -> bool:
    controller = roads.reservations()
    taken: set[str] = set()
    for shuttle in shuttles:
        occupancy = shuttle.occupancy
        if occupancy is None:
            continue
        if not taken.isdisjoint(occupancy.held_ids):
            return False
        for section_id in occupancy.held_ids:
            taken |= roads.network.shadow(section_id)
        controller.restore(occupancy.vehicle_id, occupancy.held_ids, occupancy.ahead, occupancy.goal)
    return controller.is_safe()


def _enter(uow: UnitOfWork, shuttle: _Shuttle, *, is_kept: bool) -> None:
    vehicle = shuttle.vehicle
    clear_incident(uow, IncidentKind.MAP_NOT_CHANGED, vehicle.vehicle_id)
    after = replace(vehicle, map_failure="", placed=vehicle.placed and is_kept)
    if not is_kept and shuttle.occupancy is not None:
        uow.sections.remove(vehicle.vehicle_id)
    if after != vehicle:
        uow.vehicles.save(with_availability(uow, after))
    uow.publish(topics.vehicle_outbox(uow.campus_id, vehicle.vehicle_id))

"""Chooses the resting place of a plan: the nearest one that is not reserved for another vehicle."""

import math

from contract.roads.model import RestingPlace
from contract.roads.travel_times import Place
from server.domain.errors import NoRestingPlaceFree
from server.domain.planning.plans import Plan, PlannedVisit, RestReason
from server.travel.fleet_roads import FleetRoads
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.roads.road_positions import ARRIVED_M, RoadPosition
from server.usecases.roads.section_reservations import SectionReservations


def resting_place_for(
    uow: UnitOfWork,
    plan: Plan,
    last: Place,
    onward: PlannedVisit | None,
    reservations: SectionReservations,
    *,
    charges: bool = False,
) -> tuple[RestingPlace, float]:
    """The place with the shortest way, among those not reserved for other vehicles; and that way in seconds.

    The way goes from `last` to the place, and on to the next stop if there is one. Free places come
    before occupied ones, and chargers before all others for a vehicle that `charges`.
    Raises NoRestingPlaceFree.
    """
    network = uow.network()
    chargers = {place.place_id for place in network.road_map.charging_places}
    reserved = {other.resting_place_id for other in uow.plans.all() if other.vehicle_id != plan.vehicle_id}
    occupied = reservations.held_by_others(plan.vehicle_id)
    best: tuple[tuple[bool, bool, float, str], RestingPlace] | None = None
    for place in network.road_map.resting_places:
        if place.place_id in reserved:
            continue
        time_s = _way_round_s(uow.roads(), last, place, onward)
        if math.isinf(time_s):
            continue
        section_id = network.section_at(place.lane_id, place.s_m).section_id
        needed = charges and place.place_id not in chargers
        key = (needed, section_id in occupied, time_s, place.place_id)
        if best is None or key < best[0]:
            best = key, place
    if best is None:
        raise NoRestingPlaceFree(
            f"every resting place that {plan.vehicle_id} can reach belongs to another shuttle"
        )
    return best[1], best[0][2]


def can_rest(uow: UnitOfWork, plan: Plan, here: RoadPosition) -> bool:
    """The vehicle can reach a resting place that is not reserved for another one."""
    reserved = {other.resting_place_id for other in uow.plans.all() if other.vehicle_id != plan.vehicle_id}
    return any(
        place.place_id not in reserved
        and math.isfinite(uow.roads().time_to_rest((here.lane_id, here.s_m), place))
        for place in uow.network().road_map.resting_places
    )


def _way_round_s(roads: FleetRoads, last: Place, place: RestingPlace, onward: PlannedVisit | None) -> float:
    there_s = roads.time_to_rest(last, place)
    if onward is None or math.isinf(there_s):
        return there_s
    return there_s + float(roads.times_from_rest(place)[roads.stop_numbers[onward.stop_id]])


def rest_visit(uow: UnitOfWork, lane_id: str, s_m: float, why: RestReason = "") -> PlannedVisit:
    return PlannedVisit(uow.ids.new_id("visit"), "rest", "", lane_id, s_m, dwell_s=0.0, why=why)


def rests_at(uow: UnitOfWork, plan: Plan, here: Place) -> RestingPlace | None:
    """The resting place at which the vehicle stands, unless it is reserved for another one."""
    lane_id, s_m = here
    reserved = {other.resting_place_id for other in uow.plans.all() if other.vehicle_id != plan.vehicle_id}
    for place in uow.network().road_map.resting_places:
        is_here = place.lane_id == lane_id and abs(place.s_m - s_m) <= ARRIVED_M
        if is_here and place.place_id not in reserved:
            return place
    return None

"""Which resting place a vehicle's plan ends at: one that nobody else has, the nearest of those."""

import math

from contract.roads.model import RestingPlace
from contract.roads.travel_times import Place
from server.domain.errors import NoRestingPlaceFree
from server.domain.plans import Plan, PlannedVisit
from server.usecases.ground import ARRIVED_M
from server.usecases.ports import UnitOfWork
from server.usecases.section_desk import SectionDesk


def resting_place_for(uow: UnitOfWork, plan: Plan, last: Place, desk: SectionDesk) -> RestingPlace:
    """The nearest place from `last` that is reserved for nobody else; free ones before occupied ones.

    Raises NoRestingPlaceFree.
    """
    roads = uow.roads()
    reserved = {other.resting_place_id for other in uow.plans.all() if other.vehicle_id != plan.vehicle_id}
    occupied = desk.held_by_others(plan.vehicle_id)
    best: tuple[tuple[bool, float, str], RestingPlace] | None = None
    for place in roads.network.road_map.resting_places:
        if place.place_id in reserved:
            continue
        time_s = roads.time_to_rest(last, place)
        if math.isinf(time_s):
            continue
        section_id = roads.network.section_at(place.lane_id, place.s_m).section_id
        key = (section_id in occupied, time_s, place.place_id)
        if best is None or key < best[0]:
            best = key, place
    if best is None:
        raise NoRestingPlaceFree(
            f"every resting place that {plan.vehicle_id} can reach belongs to another shuttle"
        )
    return best[1]


def rest_visit(uow: UnitOfWork, place: RestingPlace) -> PlannedVisit:
    return PlannedVisit(uow.ids.new_id("visit"), "rest", "", place.lane_id, place.s_m, dwell_s=0.0)


def rests_at(plan: Plan, place: RestingPlace, here: Place) -> bool:
    """The vehicle, with nothing left to do, stands at its resting place."""
    lane_id, s_m = here
    return (
        plan.resting_place_id == place.place_id
        and lane_id == place.lane_id
        and abs(s_m - place.s_m) <= ARRIVED_M
    )

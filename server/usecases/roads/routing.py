"""The route of a vehicle from its position, over its visits, to its resting place."""

from collections.abc import Sequence
from dataclasses import dataclass

from contract.roads.routing import route_sections
from server.domain.planning.plans import PlannedVisit
from server.travel.fleet_roads import FleetRoads
from server.travel.road_access import Own
from server.usecases.roads.road_positions import ARRIVED_M, RoadPosition, ahead_of
from server.usecases.roads.section_reservations import SectionReservations


@dataclass(frozen=True, slots=True)
class DrivingRoute:
    """legs: the lanes to each visit, from where the one before is; sections: from the oldest held one on."""

    legs: tuple[tuple[str, ...], ...]
    sections: tuple[str, ...]


def way_through(
    roads: FleetRoads,
    held: Sequence[str],
    start: RoadPosition,
    visits: Sequence[PlannedVisit],
    blocked: frozenset[str],
    *,
    stopping_m: float,
    heading_for: str,
) -> DrivingRoute | None:
    """The way from `start` over all visits, or None where there is none.

    Granted sections are driven to their end: a vehicle cannot turn off them. A visit on them is served in
    passing if it lies at least stopping_m ahead; `heading_for` names the visit that the vehicle drives to or
    stands at already, which needs no such distance. The last visit, where it rests, ends the way.
    """
    way = _RouteBuilder(roads, held, start, blocked)
    for number, visit in enumerate(visits):
        tolerance_m = 0.0
        if number == 0:
            tolerance_m = ARRIVED_M if visit.visit_id == heading_for else -stopping_m
        if not way.extend(visit, tolerance_m, must_end=number == len(visits) - 1):
            return None
    return way.finished()


class _RouteBuilder:
    def __init__(
        self, roads: FleetRoads, held: Sequence[str], start: RoadPosition, blocked: frozenset[str]
    ) -> None:
        self._roads = roads
        self._network = roads.network
        self._held = list(held)
        self._sections = list(held)
        self._blocked = blocked
        self._shut = roads.access.closed_for(held[-1])
        self._at: RoadPosition | None = start
        self._place = (start.lane_id, start.s_m)
        self._legs: list[tuple[str, ...]] = []

    def extend(self, visit: PlannedVisit, tolerance_m: float, *, must_end: bool) -> bool:
        """Extend the route to the visit. tolerance_m: how far behind it may be; negative: how far ahead."""
        if self._at is not None:
            found = self._on_held(visit, self._at, tolerance_m, must_end)
            if found is not None:
                self._legs.append(self._lanes(self._at.index, found.index + 1))
                self._at, self._place = found, (visit.lane_id, visit.s_m)
                return True
        return self._drive_on(visit)

    def finished(self) -> DrivingRoute:
        return DrivingRoute(tuple(self._legs), tuple(self._sections))

    def _on_held(
        self, visit: PlannedVisit, here: RoadPosition, tolerance_m: float, must_end: bool
    ) -> RoadPosition | None:
        least = here
        if tolerance_m < 0.0:
            least = ahead_of(self._network, self._held, here, -tolerance_m)
        last = len(self._held) - 1
        for index in range(least.index, len(self._held)):
            section = self._network.sections[self._held[index]]
            if section.lane_id != visit.lane_id or (must_end and index != last):
                continue
            if not section.s_from_m - 0.01 <= visit.s_m <= section.s_to_m + 0.01:
                continue
            behind_m = least.s_m - visit.s_m if index == least.index else 0.0
            if behind_m <= max(tolerance_m, 0.01):
                return RoadPosition(index, visit.lane_id, visit.s_m)
        return None

    def _drive_on(self, visit: PlannedVisit) -> bool:
        lanes: list[str] = []
        origin = self._place
        if self._at is not None:
            end = self._network.sections[self._held[-1]]
            lanes = list(self._lanes(self._at.index, len(self._held)))
            origin = (end.lane_id, end.s_to_m)
        route = self._roads.route(origin, (visit.lane_id, visit.s_m), self._blocked)
        if route is None:
            return False
        joined = lanes + list(
            route.lane_ids[1:] if lanes and lanes[-1] == route.lane_ids[0] else route.lane_ids
        )
        sections = route_sections(self._network, route)
        if self._shut and not self._shut.isdisjoint(sections):
            # A route may begin in any section, also in a closed one in mid-lane.
            return False
        self._legs.append(tuple(joined))
        for section_id in sections:
            if self._sections[-1] != section_id:
                self._sections.append(section_id)
        self._at, self._place = None, (visit.lane_id, visit.s_m)
        return True

    def _lanes(self, first: int, end: int) -> tuple[str, ...]:
        """The lanes of the granted sections from index first up to index end, which is excluded."""
        lanes: list[str] = []
        for section_id in self._held[first:end]:
            lane_id = self._network.sections[section_id].lane_id
            if not lanes or lanes[-1] != lane_id:
                lanes.append(lane_id)
        return tuple(lanes)


def blocked_for(roads: FleetRoads, own: Own, held: Sequence[str], ahead: Sequence[str]) -> frozenset[str]:
    """What a vehicle may not drive through: others' resting places, except on its present route, and closed
    road, except to leave it."""
    rests = roads.every_road.access.kept_clear(own).difference(held, ahead)
    return rests | roads.access.closed_for(held[-1]) if roads.closed else rests


def leads_through_closed(roads: FleetRoads, reservations: SectionReservations, vehicle_id: str) -> bool:
    """The vehicle's present route goes over closed road that it is not just leaving."""
    if not roads.closed:
        return False
    occupancy = reservations.occupancy(vehicle_id)
    return not roads.access.closed_for(occupancy.held_ids[-1]).isdisjoint(occupancy.ahead)

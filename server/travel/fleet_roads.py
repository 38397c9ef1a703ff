"""The active map as the fleet uses it: travel times, and ways that keep clear of others' resting places.

A shuttle drives only where it could drive if every resting place but its own were taken. Such a way can be
driven to its end whatever the others do (docs/contract/roads.md). Travel times are those of such ways, on
roads that are not closed.
"""

import math
from collections.abc import Sequence

import numpy as np

from contract.geometry import Array, BoolArray
from contract.roads.model import RestingPlace
from contract.roads.network import RoadNetwork
from contract.roads.reservation import Reservations
from contract.roads.routing import Route, find_route
from contract.roads.times_to_places import TimesToPlaces
from contract.roads.travel_times import Place, travel_time_matrix
from server.dispatch.answer import PromiseRules
from server.dispatch.problem import Walk
from server.domain.rules import FleetRules
from server.travel.cached_results import CachedResults
from server.travel.road_access import Own, RoadAccess
from server.travel.walking import walks_between_stops

# Each set of closed sections that vehicles meet has its own table, a few kilobytes.
_CLOSURES_KEPT = 2000
# Sets of roads closed by operators, each with tables of its own.
_CLOSED_VIEWS_KEPT = 16
_ROUTES_KEPT = 20_000


class FleetRoads:
    """One map version. Everything that is worked out is kept: a version never changes.

    speed_cap_mps  what a shuttle drives at most; slack: planned over free-flow travel time
    closed  sections that operators have closed; every_road: the same map with none closed
    access  the sections that a vehicle may not enter
    results  computed by callers from this map and their own objects
    """

    def __init__(
        self,
        network: RoadNetwork,
        speed_cap_mps: float,
        slack: float,
        closed: frozenset[str] = frozenset(),
        every_road: "FleetRoads | None" = None,
    ) -> None:
        self.network = network
        self.closed = closed
        self.every_road = every_road or self
        self.stop_ids = tuple(stop.stop_id for stop in network.road_map.stops)
        self.stop_numbers = {stop_id: i for i, stop_id in enumerate(self.stop_ids)}
        self.access = RoadAccess(network, closed)
        self.results = CachedResults()
        self.stop_places: list[Place] = [(stop.lane_id, stop.s_m) for stop in network.road_map.stops]
        self.speed_cap_mps = speed_cap_mps
        self.slack = slack
        self._stop_times: dict[Own, Array] = {}
        self._walks: tuple[tuple[Walk, ...], ...] | None = None
        self._to_stops: dict[frozenset[str], TimesToPlaces] = {}
        self._to_rest: dict[tuple[Place, str], float] = {}
        self._from_rest: dict[str, Array] = {}
        self._routes: dict[tuple[Place, Place, frozenset[str]], Route | None] = {}
        self._to_charger_s: float | None = None
        self._empty: Reservations = (
            Reservations(network.road_map.sections) if every_road is None else every_road._empty
        )
        self._views: dict[frozenset[str], FleetRoads] = {}
        self._served: BoolArray | None = None
        self._way_home_s: float | None = None

    def closed_to(self, closed: frozenset[str]) -> "FleetRoads":
        """This map with these sections closed, and no others."""
        if not closed:
            return self.every_road
        views = self.every_road._views
        view = views.get(closed)
        if view is None:
            view = FleetRoads(self.network, self.speed_cap_mps, self.slack, closed, self.every_road)
            if len(views) >= _CLOSED_VIEWS_KEPT:
                views.clear()
            views[closed] = view
        return view

    def reservations(self) -> Reservations:
        """A controller for this map without any vehicle."""
        return self._empty.emptied()

    def direct_s(self, from_stop: str, to_stop: str) -> float:
        """Planned seconds from stop to stop on an empty campus; infinite where no road leads there.

        Where closures cut the stops off from each other the time is that of the open road.
        """
        times = self._stop_times_with(frozenset(self.network.resting_places))
        direct_s = float(times[self.stop_numbers[from_stop], self.stop_numbers[to_stop]])
        if math.isinf(direct_s) and self.closed:
            return self.every_road.direct_s(from_stop, to_stop)
        return direct_s

    def is_cut_off(self, from_stop: str, to_stop: str) -> bool:
        """Closed roads make a ride from the one stop to the other impossible."""
        if not self.closed:
            return False
        pickup, dropoff = self.stop_numbers[from_stop], self.stop_numbers[to_stop]
        served = self._served_stops()
        times = self._stop_times_with(frozenset(self.network.resting_places))
        return not (served[pickup] and served[dropoff] and math.isfinite(times[pickup, dropoff]))

    def serves(self, stop_id: str) -> bool:
        """The stop is not on closed road, and a shuttle can drive on from it."""
        return not self.closed or bool(self._served_stops()[self.stop_numbers[stop_id]])

    def stop_times(self, own: Own) -> Array:
        """(n, n) planned seconds between all stops, in map order, for the owner of these resting places.

        Where its way would lead through another one's resting place the time of that way is given, unless
        closures are behind that.
        """
        times = self._stop_times_with(own)
        if np.isfinite(times).all():
            return times
        through = self._stop_times_with(frozenset(self.network.resting_places))
        if self.closed:
            through = np.where(np.isfinite(self.every_road._stop_times_with(own)), np.inf, through)
        return np.where(np.isfinite(times), times, through)

    def promise_rules(self, rules: FleetRules) -> PromiseRules:
        """The room that promises leave, and the stops within walking distance of each stop."""
        if self._walks is None:
            if self.closed:
                self._walks = self.every_road.promise_rules(rules).walks
            else:
                self._walks = walks_between_stops(self.network, rules.walk_m_max, rules.walk_mps)
        return PromiseRules(
            rules.pickup_early_s,
            rules.pickup_slack_s,
            rules.arrival_slack_s,
            rules.arrival_slack_ratio,
            rules.later_s_max,
            self._walks,
            rules.pickup_slack_ratio,
            rules.uncertain_s_max,
        )

    def times_to_stops(self, place: Place, own: Own, opened: frozenset[str]) -> Array:
        """(n,) planned seconds from a place on the road to every stop.

        opened  sections that the vehicle may drive through all the same: those of its present route
        """
        rests = self.every_road.access.kept_clear(own) - opened
        times = self._from_place(place, rests | self.closed)
        if not np.isfinite(times).all():
            through = self._from_place(place, self.closed)
            if self.closed:
                cut_off = np.isfinite(self.every_road._from_place(place, rests)) | ~self._served_stops()
                through = np.where(cut_off, np.inf, through)
            times = np.where(np.isfinite(times), times, through)
        planned: Array = times * self.slack
        return planned

    def without_closed_stops(self, row: Array, planned: Sequence[str]) -> Array:
        """(n,) times of which those to stops on closed road are left out, save to these planned ones."""
        known = np.isin(self.stop_ids, planned) if planned else np.zeros(len(self.stop_ids), np.bool_)
        return np.where(self._served_stops() | known, row, np.inf)

    def time_to_rest(self, place: Place, rest: RestingPlace) -> float:
        """Planned seconds from a place to a resting place; infinite where the others are in the way."""
        key = (place, rest.place_id)
        if key not in self._to_rest:
            closed = self.access.closed_from(place, self.access.kept_clear(frozenset({rest.place_id})))
            there = TimesToPlaces(self.network, [(rest.lane_id, rest.s_m)], self.speed_cap_mps, closed)
            self._to_rest[key] = self.slack * float(there.from_place(place)[0])
        return self._to_rest[key]

    def way_home_s(self) -> float:
        """Planned seconds from the stop that is farthest from any resting place to the nearest one."""
        if self._way_home_s is None:
            rests = self.network.road_map.resting_places
            nearest = (
                min((self.time_to_rest(place, rest) for rest in rests), default=0.0)
                for place in self.stop_places
            )
            self._way_home_s = max((s for s in nearest if math.isfinite(s)), default=0.0)
        return self._way_home_s

    def times_from_rest(self, rest: RestingPlace) -> Array:
        """(n,) planned seconds from a resting place to every stop, for the vehicle that rests there."""
        if rest.place_id not in self._from_rest:
            self._from_rest[rest.place_id] = self.times_to_stops(
                (rest.lane_id, rest.s_m), frozenset({rest.place_id}), frozenset()
            )
        return self._from_rest[rest.place_id]

    def to_charger_s(self) -> float:
        """Planned seconds from the stop that is farthest from a charger to the nearest one."""
        if self._to_charger_s is None:
            chargers = self.network.road_map.charging_places
            ways_s = (min(self.time_to_rest(stop, place) for place in chargers) for stop in self.stop_places)
            self._to_charger_s = max((way_s for way_s in ways_s if math.isfinite(way_s)), default=0.0)
        return self._to_charger_s

    def route(self, origin: Place, destination: Place, blocked: frozenset[str]) -> Route | None:
        """The fastest route. Most begin where a section ends or at a stop, so routes are kept."""
        key = origin, destination, blocked
        if key not in self._routes:
            if len(self._routes) >= _ROUTES_KEPT:
                self._routes.clear()
            self._routes[key] = find_route(
                self.network, *origin, *destination, blocked, speed_cap_mps=self.speed_cap_mps
            )
        return self._routes[key]

    def _from_place(self, place: Place, blocked: frozenset[str]) -> Array:
        """(n,) free-flow seconds to every stop; the section of the place itself is open."""
        closed = self.access.closed_from(place, blocked)
        times = self._to_stops.get(closed)
        if times is None:
            if len(self._to_stops) >= _CLOSURES_KEPT:
                self._to_stops.clear()
            times = TimesToPlaces(self.network, self.stop_places, self.speed_cap_mps, closed)
            self._to_stops[closed] = times
        if not self.closed:
            return times.from_place(place)
        return np.where(self._served_stops(), times.from_place(place), np.inf)

    def _served_stops(self) -> BoolArray:
        """(n,) stops that are not on closed road, and from which a resting place can be reached as on the
        open road."""
        if self._served is None:
            rests = self.network.road_map.resting_places
            self._served = np.array(
                [
                    self.network.section_at(*place).section_id not in self.closed
                    and (
                        any(math.isfinite(self.time_to_rest(place, rest)) for rest in rests)
                        or not any(math.isfinite(self.every_road.time_to_rest(place, rest)) for rest in rests)
                    )
                    for place in self.stop_places
                ]
            )
        return self._served

    def _stop_times_with(self, own: Own) -> Array:
        if own not in self._stop_times:
            blocked = self.access.kept_clear(own)
            times, _ = travel_time_matrix(self.network, self.stop_places, self.speed_cap_mps, blocked)
            if self.closed:
                self._allow_for_closures(times, blocked)
            self._stop_times[own] = times * self.slack
        return self._stop_times[own]

    def _allow_for_closures(self, times: Array, blocked: frozenset[str]) -> None:
        """No vehicle drives to a stop that closures cut off; from a stop on closed road a way leads off."""
        for number, place in enumerate(self.stop_places):
            if self.network.section_at(*place).section_id in self.closed:
                times[number] = self._from_place(place, blocked)
        times[:, ~self._served_stops()] = np.inf
        np.fill_diagonal(times, 0.0)

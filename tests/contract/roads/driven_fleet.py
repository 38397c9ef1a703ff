"""A fleet at the level of sections: vehicles that ask for grants, drive on and let go of what is behind."""

import random
from dataclasses import dataclass, field

from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.reservation import Grant, Reservations
from contract.roads.routing import find_route, route_sections

_MOST_HELD = 3


@dataclass(slots=True)
class DrivenFleet:
    """Every vehicle starts at a resting place and knows the place that is reserved for its end."""

    road_map: RoadMap
    count: int
    network: RoadNetwork = field(init=False)
    control: Reservations = field(init=False)
    place_of: dict[str, str] = field(default_factory=dict)
    missions: dict[str, int] = field(default_factory=dict)
    fences: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.network = RoadNetwork(self.road_map)
        self.control = Reservations(self.road_map.sections)
        for k, place in enumerate(self.road_map.resting_places[: self.count]):
            vehicle_id = f"v{k}"
            section = self.network.section_at(place.lane_id, place.s_m).section_id
            self.control.place(vehicle_id, (section,))
            self.place_of[vehicle_id] = place.place_id
            self.missions[vehicle_id] = 0

    def is_idle(self, vehicle_id: str) -> bool:
        return not self.control.ahead(vehicle_id) and len(self.control.held(vehicle_id)) == 1

    def send(self, vehicle_id: str, stop_number: int, place_number: int) -> bool:
        """A mission over a stop to a free resting place; the promise says that it is never refused."""
        network, here = self.network, self.network.resting_places[self.place_of[vehicle_id]]
        taken = {p for v, p in self.place_of.items() if v != vehicle_id}
        free = [p for p in self.road_map.resting_places if p.place_id not in taken]
        there = free[place_number % len(free)]
        stop = self.road_map.stops[stop_number % len(self.road_map.stops)]
        clear = network.kept_clear({here.place_id, there.place_id})
        out = find_route(network, here.lane_id, here.s_m, stop.lane_id, stop.s_m, clear)
        on = find_route(network, stop.lane_id, stop.s_m, there.lane_id, there.s_m, clear)
        assert out is not None, (here, stop)
        assert on is not None, (stop, there)
        adopted = self.control.adopt(vehicle_id, route_sections(network, out, on))
        if adopted:
            self.place_of[vehicle_id] = there.place_id
            self.missions[vehicle_id] += 1
        return adopted

    def step(self, vehicle_id: str, limit: int) -> bool:
        """One turn of a vehicle: ask on, then drive to the end of what it holds. True when it moved."""
        granted: tuple[Grant, ...] = ()
        if len(self.control.held(vehicle_id)) < _MOST_HELD:
            granted = self.control.grant(vehicle_id, limit)
        self.fences += [grant.fence for grant in granted]
        released = False
        while len(self.control.held(vehicle_id)) > 1:
            released |= self.control.release(vehicle_id, self.control.held(vehicle_id)[0])
        self.assert_apart()
        return bool(granted) or released

    def assert_apart(self) -> None:
        """No vehicle holds a section that another one's holdings exclude."""
        held = {vehicle_id: self.control.held(vehicle_id) for vehicle_id in self.control.vehicle_ids}
        for one, sections in held.items():
            shadow = frozenset().union(*(self.network.shadow(section) for section in sections))
            for other, others in held.items():
                assert one == other or not shadow & set(others), (one, other)

    def finish(self, rng: random.Random) -> int:
        """Drive until all missions are done, in a random order of turns; the number of rounds it took."""
        rounds = 0
        while busy := [v for v in self.control.vehicle_ids if not self.is_idle(v)]:
            rng.shuffle(busy)
            moved = [self.step(vehicle_id, rng.randint(1, 4)) for vehicle_id in busy]
            assert any(moved), ("stuck", {v: self.control.blocked_by(v) for v in busy})
            rounds += 1
        return rounds

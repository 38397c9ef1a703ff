"""One shuttle alone on a campus, without a server, for benchmarks: a tour of stops, all sections granted."""

from pathlib import Path

import msgspec
import numpy as np

from campusloop.virtual.conductor import STEP_NS
from campusloop.virtual.granted_order import granted_order, start_messages
from campusloop.virtual.vehicle import VirtualVehicle, VirtualVehicleSetup
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route, route_line
from contract.wire.messages import Order, Visit, VisitKind
from simulator.riders import NoPhones
from simulator.sensors.scene_lidars import SceneOptions
from simulator.start_places import start_poses
from simulator.traffic.population import TrafficParams
from simulator.world import SimWorld, WorldOptions
from vehicle_agent.config import LidarMount, Profile

VEHICLE_ID = "shuttle-1"
START_NS = 1_000_000_000


def tour(road_map: RoadMap, stops: int, seed: int) -> Order:
    """An order from the first resting place over random stops and back, with all its sections."""
    network = RoadNetwork(road_map)
    rest = road_map.resting_places[0]
    chosen = np.random.default_rng(seed).permutation(len(road_map.stops))[:stops]
    places = [(stop.stop_id, stop.lane_id, stop.s_m) for stop in (road_map.stops[i] for i in chosen)]
    places.append(("", rest.lane_id, rest.s_m))
    lane_id, s_m = rest.lane_id, rest.s_m
    visits: list[Visit] = []
    sections: list[str] = []
    for number, (stop_id, to_lane, to_s_m) in enumerate(places):
        route = find_route(network, lane_id, s_m, to_lane, to_s_m)
        assert route is not None, "every stop of a sound map can be reached"
        kind: VisitKind = "stop" if stop_id else "rest"
        visits.append(Visit(f"visit-{number}", kind, stop_id, to_lane, to_s_m, route.lane_ids, dwell_s=5.0))
        for section_id, _, _ in route_line(network, route).sections:
            if not sections or sections[-1] != section_id:
                sections.append(section_id)
        lane_id, s_m = to_lane, to_s_m
    return granted_order("tour", road_map.map_version, tuple(visits), sections)


class SoloDrive:
    """The world and its one shuttle; `step` is 20 ms of both."""

    def __init__(
        self,
        road_map: RoadMap,
        folder: Path,
        seed: int,
        *,
        lidar: bool = True,
        stops: int = 4,
        traffic: TrafficParams | None = None,
        start_ns: int = START_NS,
        profile: Profile | None = None,
        scene: SceneOptions | None = None,
        point_map: Path | None = None,
    ) -> None:
        """profile: the campus shuttle by default; scene, point_map: as for a campus (`CampusOptions`)."""
        profile = profile or Profile()
        if not lidar:
            profile = msgspec.structs.replace(profile, lidar=LidarMount(rate_hz=0.0))
        poses = start_poses(road_map, (VEHICLE_ID,))
        options = WorldOptions(traffic=traffic, lidar=lidar, scene=scene)
        self.world = SimWorld(road_map, {VEHICLE_ID: profile}, poses, seed, NoPhones(), options)
        setup = VirtualVehicleSetup(VEHICLE_ID, profile, road_map, folder, 0, point_map=point_map)
        self.vehicle = VirtualVehicle(setup, self.world, lambda: None)
        self.now_ns = start_ns
        self.vehicle.boot(start_ns)
        self._order = tour(road_map, stops, seed)

    def set_off(self) -> None:
        """Step for a second, until the vehicle is localized; then send the order and the resume."""
        for _ in range(50):
            self.step()
        for message in start_messages(self._order, self.now_ns):
            self.vehicle.put_link_message(self.now_ns, message)

    def step(self, now_ns: int | None = None) -> None:
        """now_ns: the wall clock's stamp for this step, when it is not virtual."""
        self.now_ns = self.now_ns if now_ns is None else now_ns
        self.vehicle.step(self.now_ns)
        self.world.step(self.now_ns)
        self.now_ns += STEP_NS

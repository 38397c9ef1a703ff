"""Another shuttle of a scene: the whole onboard loop of the same stack, on a road of its own."""

import math
from dataclasses import dataclass

from campusloop.scenes.contact_metrics import ContactMetrics, contact_metrics
from campusloop.scenes.path_map import LANE_ID
from campusloop.scenes.trace import SceneTrace
from campusloop.virtual.granted_order import granted_order, rest_at, start_messages
from campusloop.virtual.wiring import WiredVehicle
from contract.geometry import Pose2, pose_at
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from simulator.world import SimWorld
from vehicle_agent.config import Profile
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.signals import Outputs
from vehicle_agent.stacks.choice import build_car

_BEFORE_END_M = 0.5
# Nearer than this to the end of its road, a shuttle has arrived.
_ARRIVED_M = 2.0


@dataclass(frozen=True, slots=True)
class OtherRoad:
    """road_map: of one lane (`path_map`), to whose end the shuttle drives."""

    road_map: RoadMap
    start_s_m: float
    start_mps: float

    @property
    def start(self) -> Pose2:
        return Pose2(*RoadNetwork(self.road_map).pose(LANE_ID, self.start_s_m))


@dataclass(frozen=True, slots=True)
class OtherRun:
    """arrived: at the end of its road."""

    metrics: ContactMetrics
    arrived: bool


class OtherShuttle:
    """Call `send_order`, then `step` before each step of the world, and `record` after it."""

    def __init__(self, vehicle_id: str, road: OtherRoad, profile: Profile, world: SimWorld) -> None:
        self._id, self._road, self._profile, self._world = vehicle_id, road, profile, world
        self._line = RoadNetwork(road.road_map).lines[LANE_ID]
        car = build_car(profile, road.road_map)
        self._wired = WiredVehicle(vehicle_id, profile, road.road_map, world)
        self._wired.boot(VehicleComputer(car, initial_state(car)))
        self._outputs: Outputs | None = None
        self._trace = SceneTrace()
        world.follow(vehicle_id, self._line.points)

    @property
    def is_engaged(self) -> bool:
        return self._outputs is not None and self._outputs.flow.motion.enabled

    def send_order(self, now_ns: int) -> None:
        """To drive to the end of its road."""
        road_map = self._road.road_map
        sections = [section.section_id for section in RoadNetwork(road_map).sections_of(LANE_ID)]
        visits = rest_at((LANE_ID,), self._line.length_m - _BEFORE_END_M)
        order = granted_order("scene", road_map.map_version, visits, sections)
        for message in start_messages(order, now_ns):
            self._wired.inbox.put(now_ns, "link", message)

    def set_off(self) -> None:
        """Place the shuttle where its drive begins, at its speed."""
        self._world.place(self._id, self._road.start, self._road.start_mps)

    def step(self, now_ns: int) -> None:
        self._outputs = self._wired.step(now_ns)

    def record(self, t_s: float) -> None:
        self._trace.add(t_s, self._world.truth(self._id), self._world.road_users_of(self._id))

    @property
    def has_arrived(self) -> bool:
        """It is at the end of its road."""
        end = pose_at(self._line.points, self._line.s, self._line.length_m - _BEFORE_END_M)
        place = self._world.truth(self._id).pose_map
        return math.hypot(place.x_m - end[0], place.y_m - end[1]) < _ARRIVED_M

    def result(self) -> OtherRun:
        rows = self._trace.array()
        metrics = contact_metrics(rows, self._trace.agents, self._profile.body)
        return OtherRun(metrics, self.has_arrived)

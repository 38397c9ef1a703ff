"""One shuttle with its real tick on the simulated vehicle, and a server that grants what it is asked to."""

import math
from collections.abc import Callable

from contract.geometry import Pose2
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route, route_sections
from contract.wire.messages import (
    Command,
    Grants,
    Order,
    OrderAccepted,
    OrderRejected,
    RiderTask,
    SectionGrant,
    SectionReleased,
    VehicleEvent,
    Visit,
)
from simulator.world import SimWorld, WorldOptions
from vehicle_agent.config import Profile
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.onboard.tick import tick
from vehicle_agent.perception.height_map import percept_from_scan
from vehicle_agent.runtime.inbox import Inbox, inputs_from
from vehicle_agent.signals import InboxBody, LinkState, Outputs
from vehicle_agent.stacks.choice import SIGN_READING_STACKS, build_car, build_planner
from vehicle_agent.stacks.rooms import height_map, sign_finder

TICK_NS = 20_000_000
SERVER_OFFSET_NS = 1_700_000_000_000_000_000


class SilentPhone:
    """Nobody taps."""

    def __init__(self, vehicle_id: str) -> None:
        self._vehicle_id = vehicle_id

    def vehicle_of(self, ride_id: str) -> str:
        return self._vehicle_id

    def tap(self, ride_id: str, kind: str) -> None:
        raise AssertionError("nobody taps here")


class DrivenShuttle:
    """Steps world and tick together; `events`, `answers` and `outputs` are what the vehicle has said.

    aside_m  stands this far to the left of the start at first
    """

    def __init__(
        self,
        road_map: RoadMap,
        start: tuple[str, float],
        profile: Profile,
        options: WorldOptions,
        seed: int = 1,
        *,
        aside_m: float = 0.0,
    ) -> None:
        self.network = RoadNetwork(road_map)
        self.name = "s1"
        x_m, y_m, yaw_rad = self.network.pose(*start)
        pose = Pose2(x_m - aside_m * math.sin(yaw_rad), y_m + aside_m * math.cos(yaw_rad), yaw_rad)
        self.world = SimWorld(
            road_map, {self.name: profile}, {self.name: pose}, seed, SilentPhone(self.name), options
        )
        self.car = build_car(profile, road_map)
        self.planner = build_planner(profile, road_map)
        self.state = initial_state(self.car)
        self.now_ns = TICK_NS
        self.events: list[tuple[int, VehicleEvent]] = []
        self.answers: list[OrderAccepted | OrderRejected] = []
        self.outputs: Outputs | None = None
        self.order: Order | None = None
        self.granted: list[SectionGrant] = []
        self.inbox = Inbox()
        self.params = height_map(profile)
        self.signs = sign_finder(profile) if profile.stack in SIGN_READING_STACKS else None
        self._followed = 0
        self._pending: list[InboxBody] = [LinkState(TICK_NS, True, 1, SERVER_OFFSET_NS)]

    def say(self, body: InboxBody) -> None:
        """Put something into the next tick's inbox."""
        self._pending.append(body)

    def resume(self) -> None:
        self.say(Command(1, f"resume-{self.now_ns}", "resume"))

    def visit(
        self, name: str, lane_id: str, s_m: float, previous: tuple[str, float], **fields: object
    ) -> Visit:
        route = find_route(self.network, previous[0], previous[1], lane_id, s_m)
        assert route is not None
        return Visit(
            visit_id=name,
            kind=fields.pop("kind", "stop"),  # type: ignore[arg-type]
            stop_id=name,
            lane_id=lane_id,
            s_m=s_m,
            route=route.lane_ids,
            name=name,
            name_en=name,
            **fields,  # type: ignore[arg-type]
        )

    def order_for(self, visits: tuple[Visit, ...], start: tuple[str, float], revision: int = 1) -> Order:
        """An order with every section on its way granted."""
        sections: list[str] = []
        here = start
        for visit in visits:
            route = find_route(self.network, *here, visit.lane_id, visit.s_m)
            assert route is not None
            for section_id in route_sections(self.network, route):
                if not sections or sections[-1] != section_id:
                    sections.append(section_id)
            here = (visit.lane_id, visit.s_m)
        last = self.network.sections_of(here[0])
        sections += [s.section_id for s in last if s.s_from_m > here[1]]
        self.granted = [SectionGrant(section_id, i + 1) for i, section_id in enumerate(sections)]
        expires_ns = self.now_ns + SERVER_OFFSET_NS + 60_000_000_000
        self.order = Order(
            1, "o1", revision, self.network.map_version, visits, tuple(self.granted), expires_ns
        )
        return self.order

    def step(self) -> Outputs:
        """20 ms."""
        for frame in self.world.frames_to_vehicle(self.name):
            self.inbox.put(self.now_ns, "can", frame)
        for item in self.world.sensor_items(self.name, self.now_ns):
            self.inbox.put(self.now_ns, "sensors", item)
        for percept in self.world.tracked(self.name, self.now_ns):
            self.inbox.put(self.now_ns, "tracker", percept)
        scan = self.world.scan(self.name, self.now_ns)
        if scan is not None:
            self.inbox.put(self.now_ns, "lidar", percept_from_scan(scan[0], self.now_ns, self.params))
            if self.signs is not None:
                self.inbox.put(self.now_ns, "lidar", self.signs.percept(scan[0], scan[1], self.now_ns))
        for body in self._pending:
            self.inbox.put(self.now_ns, "test", body)
        self._pending.clear()
        self.state, outputs = tick(self.state, inputs_from(self.inbox.drain(), self.now_ns), self.car)
        if self.planner is not None:
            self._pending += [self.planner(job) for job in outputs.jobs]
        route = self.state.mission.route
        if route is not None and route.line_id != self._followed:
            self.world.follow(self.name, route.line.points[self.state.mission.segment :])
            self._followed = route.line_id
        self.world.frames_from_vehicle(self.name, outputs.frames)
        self.world.show(self.name, outputs.hmi, self.now_ns)
        self.world.step(self.now_ns)
        self.now_ns += TICK_NS
        self.events += [(self.now_ns, event) for event in outputs.events]
        self.answers += outputs.answers
        self.outputs = outputs
        for event in outputs.events:
            if isinstance(event, SectionReleased):
                self.granted = [g for g in self.granted if g.fence != event.fence]
                self.say(Grants(1, "o1", tuple(self.granted)))
        return outputs

    def run(self, seconds: float, until: Callable[["DrivenShuttle"], bool] | None = None) -> bool:
        """Drive on; True when `until` came true."""
        for _ in range(round(seconds * 50)):
            self.step()
            if until is not None and until(self):
                return True
        return False


def rider(ride_id: str, party: int = 1, code: str = "1234") -> RiderTask:
    return RiderTask(ride_id, party, code)

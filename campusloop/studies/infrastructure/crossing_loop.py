"""A loop with one crossing, carts with the real planning and control, and people who cross.

It is the setting of the time-gain experiment (NUS, section V-A, Fig. 11). Simplifications: no CAN, guard,
localization or mission; poses are true; scans detect everyone without occlusion; people are points that cross
at a constant speed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import msgspec
import numpy as np

from contract.geometry import Array, Pose2, pose_at, project
from contract.roads.load import with_version
from contract.roads.model import Lane, ObservationArea, Origin, RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.routing import Route, route_line
from simulator.infrastructure import CameraParams, CrossingCamera
from simulator.vehicle.plant import Plant, plant_params
from vehicle_agent.config import Profile
from vehicle_agent.control.waypoint.waypoint_control import WaypointControl, WaypointControlState
from vehicle_agent.planning.cost_map.cost_map_planning import CostMapPlanning, CostMapPlanningState
from vehicle_agent.planning.cost_map.crossings import CrossingRule
from vehicle_agent.planning.cost_map.safe_speeds import SafeSpeeds
from vehicle_agent.planning.waypoint.gap import GapRule
from vehicle_agent.planning.waypoint.waypoints import WaypointRules
from vehicle_agent.signals import Ego, FleetVehicle, PedestrianPresence, Task, VehicleMotion, World
from vehicle_agent.stacks.nus import planning, pursuit_control

DT_S = 0.1
STEP_NS = round(DT_S * 1e9)
STRAIGHT_M, RADIUS_M, WIDTH_M = 50.0, 10.0, 3.0
CROSSING_M, DEPTH_M, PAVEMENT_M = 30.0, 4.0, 2.0
OVERLAP_M = 40.0
WALK_MPS = 1.3
SCAN_NEAR_M, SCAN_STEPS, IDLE_SCAN_STEPS = 25.0, 2, 20
PRESENCE_AGE_NS = 2_500_000_000


def loop_map() -> RoadMap:
    """Two straights and two half circles, anticlockwise, one crossing on the south side."""
    turn = np.linspace(-math.pi / 2, math.pi / 2, 40)
    arc = np.column_stack((RADIUS_M * np.cos(turn), RADIUS_M + RADIUS_M * np.sin(turn)))
    x = np.linspace(0.0, STRAIGHT_M, 60)
    shapes = {
        "south": np.column_stack((x, np.zeros(60))),
        "east": arc + np.array([STRAIGHT_M, 0.0]),
        "north": np.column_stack((x[::-1], np.full(60, 2.0 * RADIUS_M))),
        "west": np.column_stack((-arc[:, 0], 2.0 * RADIUS_M - arc[:, 1])),
    }
    names = list(shapes)
    lanes = tuple(
        Lane(
            name,
            "road" if name in ("south", "north") else "turn",
            tuple((float(px), float(py)) for px, py in shape),
            WIDTH_M,
            3.0,
            False,
            (names[(k + 1) % 4],),
        )
        for k, (name, shape) in enumerate(shapes.items())
    )
    low, high = CROSSING_M - 0.5 * DEPTH_M, CROSSING_M + 0.5 * DEPTH_M
    half = 0.5 * WIDTH_M + PAVEMENT_M
    outline = ((low, -half), (high, -half), (high, half), (low, half))
    area = ObservationArea("crossing", "crossing", outline, (("south", low - 0.5),))
    raw = RoadMap("loop", "loop", Origin(1.3, 103.8), lanes, (), (), (), observation_areas=(area,))
    return with_version(raw)


@dataclass(slots=True)
class People:
    """Poisson arrivals at either kerb; each person waits for a gap, then crosses at 1.3 m/s and leaves.

    People do not step in front of a moving cart that could not stop comfortably. They cross in front of a
    standing cart.
    """

    rate_1ps: float
    rng: np.random.Generator
    places: Array = field(default_factory=lambda: np.empty((0, 2)))
    ways: Array = field(default_factory=lambda: np.empty(0))
    next_s: float = 0.0

    def __post_init__(self) -> None:
        self.next_s = self.rng.exponential(1.0 / self.rate_1ps)

    def step(self, now_s: float, fronts_m: Array, rears_m: Array, speeds_mps: Array) -> None:
        """fronts_m, rears_m (n,) along the straight; carts elsewhere are far from the crossing."""
        while self.next_s <= now_s:
            way = 1.0 if self.rng.random() < 0.5 else -1.0
            x_m = CROSSING_M + self.rng.uniform(-0.4, 0.4) * DEPTH_M
            kerb_m = 0.5 * WIDTH_M + 0.6
            self.places = np.vstack((self.places, [x_m, -way * kerb_m]))
            self.ways = np.append(self.ways, way)
            self.next_s += self.rng.exponential(1.0 / self.rate_1ps)
        if len(self.ways) == 0:
            return
        stopping_m = speeds_mps * 1.0 + speeds_mps**2 / (2.0 * 0.8) + 1.0
        near_m = CROSSING_M - 0.5 * DEPTH_M
        blocks = (rears_m < near_m + DEPTH_M) & (
            fronts_m + np.where(speeds_mps > 0.3, stopping_m, 0.2) > near_m
        )
        on_road = np.abs(self.places[:, 1]) < 0.5 * WIDTH_M + 0.3
        walking = on_road | (not np.any(blocks))
        self.places[walking, 1] += self.ways[walking] * WALK_MPS * DT_S
        gone = self.ways * self.places[:, 1] > 0.5 * WIDTH_M + PAVEMENT_M
        self.places, self.ways = self.places[~gone], self.ways[~gone]


class Cart:
    """One cart's planning and control, and the distance it has driven (`driven_m`)."""

    def __init__(self, room: CostMapPlanning, control: WaypointControl, start_m: float) -> None:
        self.room, self.control = room, control
        self.plan: CostMapPlanningState = room.initial()
        self.control_state: WaypointControlState = control.initial()
        self.start_m, self.driven_m = start_m, 0.0
        self.at_m, self.laps = start_m, 0
        self.seen_ns = 0


class CrossingLoop:
    """All carts stepped together every 0.1 s on the simulated plant.

    infrastructure  a camera sends its reports to the carts near the crossing; without one every cart stops
    """

    def __init__(
        self,
        profile: Profile,
        vehicles: int,
        speed_mps: float,
        rate_1ps: float,
        infrastructure: bool,
        seed: int,
    ) -> None:
        self.road_map = loop_map()
        self.network = RoadNetwork(self.road_map)
        route = Route(("south", "east", "north", "west", "south"), 0.0, OVERLAP_M, 0.0, 0.0)
        self.line = route_line(self.network, route)
        self.lap_m = float(self.line.s[-1]) - OVERLAP_M
        body = profile.body
        self._profile = profile
        room = _room(profile, self.road_map, speed_mps, infrastructure)
        # Evenly spaced; the first one is past the crossing and the last one well before it.
        apart_m = min(self.lap_m / vehicles, (self.lap_m - 14.0) / max(vehicles - 1, 1))
        starts = [(CROSSING_M + 6.0 + k * apart_m) % self.lap_m for k in range(vehicles)]
        control = _slower(pursuit_control(profile))
        self.carts = [Cart(room, control, s) for s in starts]
        poses = tuple(Pose2(*pose_at(self.line.points, self.line.s, s)) for s in starts)
        self.plant = Plant((plant_params(profile),) * vehicles, poses)
        self.people = People(rate_1ps, np.random.default_rng([seed, 1]))
        area = self.road_map.observation_areas[0]
        rng = np.random.default_rng([seed, 2])
        self.camera = CrossingCamera(area, CameraParams(), rng) if infrastructure else None
        self.presence: PedestrianPresence | None = None
        self.now_ns = STEP_NS
        self.contacts = 0
        self._reach_m = (body.front_overhang_m, body.rear_overhang_m, 0.5 * body.width_m)

    def run(self, laps: int, time_max_s: float) -> list[list[float]]:
        """For each cart the time at the end of each lap; fewer laps if the time is over."""
        times: list[list[float]] = [[] for _ in self.carts]
        while self.now_ns * 1e-9 < time_max_s and any(len(t) < laps for t in times):
            self.step()
            for cart, done in zip(self.carts, times, strict=True):
                if len(done) < laps and cart.driven_m >= (len(done) + 1) * self.lap_m:
                    done.append(self.now_ns * 1e-9)
        return times

    def step(self) -> None:
        """Step everything by 0.1 s."""
        views = [self.plant.view(i) for i in range(len(self.carts))]
        self._take_presence()
        fleet = [FleetVehicle(self.now_ns, f"c{i}", v.pose_map, v.speed_mps) for i, v in enumerate(views)]
        for i, cart in enumerate(self.carts):
            ego = Ego(
                self.now_ns, views[i].pose_map, views[i].speed_mps, views[i].accel_mps2,
                views[i].yaw_rate_radps, views[i].steer_rad, 0.02, self.now_ns, True,
            )  # fmt: skip
            ahead = fleet[(i + 1) % len(fleet)]
            others = (ahead,) if len(fleet) > 1 else ()
            self._drive(i, cart, ego, others)
        self.plant.step(DT_S)
        self._walk()
        self.now_ns += STEP_NS

    def _take_presence(self) -> None:
        if self.camera is None:
            return
        for report in self.camera.step(self.now_ns, self.people.places):
            seen_ns = self.now_ns - round(report.age_s * 1e9)
            self.presence = PedestrianPresence(seen_ns, report.area_id, report.count)

    def _drive(self, i: int, cart: Cart, ego: Ego, others: Sequence[FleetVehicle]) -> None:
        task = self._task(cart, ego)
        to_go_m = (CROSSING_M - cart.at_m) % self.lap_m
        is_near = to_go_m < SCAN_NEAR_M or self.lap_m - to_go_m < 5.0
        tick = self.now_ns // STEP_NS + i
        if tick % (SCAN_STEPS if is_near else IDLE_SCAN_STEPS) == 0:
            cart.seen_ns = self.now_ns
        fresh = self.presence is not None and self.now_ns - self.presence.stamp_ns <= PRESENCE_AGE_NS
        presence = (self.presence,) if fresh and self.presence is not None else ()
        world = World(self.now_ns, cart.seen_ns, self.people.places, tuple(others), presence, False)
        path, cart.plan = cart.room.step(cart.plan, ego, world, task)
        motion = VehicleMotion(
            self.now_ns,
            ego.speed_mps,
            ego.steer_rad,
            0.0,
            float(self.plant.commands[i, 3]),
            True,
            False,
            True,
            1.0,
        )
        command, cart.control_state = cart.control.step(cart.control_state, ego, path, motion)
        rate = self._profile.limits.steer_rate_radps_max
        self.plant.commands[i, :] = (
            command.steer_rad, rate, command.throttle_ratio, command.brake_ratio, 1.0, 0.0,
        )  # fmt: skip

    def _task(self, cart: Cart, ego: Ego) -> Task:
        """Follow the loop without end: the next lap's line begins where the last one ended."""
        line, pose = self.line, ego.pose_map
        low = int(np.searchsorted(line.s, max(cart.at_m - 3.0, 0.0)))
        high = int(np.searchsorted(line.s, cart.at_m + 6.0)) + 1
        at_m, aside_m, _ = project(line.points, line.s, pose.x_m, pose.y_m, low, high)
        cart.driven_m += float(at_m) - cart.at_m
        cart.at_m = float(at_m)
        if cart.at_m >= self.lap_m + 5.0:
            cart.at_m -= self.lap_m
            cart.laps += 1
        return Task(
            "drive", line, cart.laps + 1, cart.at_m, float(aside_m), float(line.s[-1]) + 100.0, "", 0.0,
            "", 0, "", "", "", False, (), "", None,
        )  # fmt: skip

    def _walk(self) -> None:
        front, back, half = self._reach_m
        at = np.array([cart.at_m for cart in self.carts])
        at = np.where(at > self.lap_m, at - self.lap_m, at)
        speeds = self.plant.state[:, 3]
        self.people.step((self.now_ns + STEP_NS) * 1e-9, at + front, at - back, speeds)
        for i in range(len(self.carts)):
            x, y = self.plant.state[i, 0], self.plant.state[i, 1]
            ahead, aside = self.people.places[:, 0] - x, np.abs(self.people.places[:, 1] - y)
            touched = (ahead > -back) & (ahead < front + 0.25) & (aside < half + 0.25)
            self.contacts += int(np.any(touched) and abs(y) < 1.0 and speeds[i] > 0.3)


def _room(profile: Profile, road_map: RoadMap, speed_mps: float, infrastructure: bool) -> CostMapPlanning:
    body = profile.body
    gap = GapRule(
        body.front_overhang_m, body.rear_overhang_m, 0.5 * body.width_m, standstill_m=2.0, time_gap_s=1.5
    )
    return msgspec.structs.replace(
        planning(profile, road_map, CrossingRule("untold" if infrastructure else "always", clear_looks=3)),
        waypoints=WaypointRules(speed_mps, profile.limits.lateral_accel_mps2_max),
        speeds=SafeSpeeds(speed_mps),
        gap=gap,
        look_every=10,
    )


def _slower(control: WaypointControl) -> WaypointControl:
    """The same control with this loop's step."""
    return msgspec.structs.replace(
        control,
        steering=msgspec.structs.replace(control.steering, dt_s=DT_S),
        twist=msgspec.structs.replace(control.twist, dt_s=DT_S),
        dt_s=DT_S,
    )

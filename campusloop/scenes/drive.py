"""One scene driven from start to goal by the whole onboard loop: CAN, gate, by-wire, plant and all."""

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Protocol

import msgspec
import numpy as np

from campusloop.scenes.judge import Verdict, judge
from campusloop.scenes.path_map import LANE_ID
from campusloop.scenes.trace import SceneTrace
from contract.geometry import Pose2
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.wire.messages import Command, Order, SectionGrant, Visit
from simulator.traffic.actors import Actors
from simulator.world import SimWorld, WorldOptions
from vehicle_agent.config import Profile
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.perception.height_map import percept_from_scan
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.gate import gate_of
from vehicle_agent.runtime.inbox import Inbox
from vehicle_agent.signals import LinkState, ObstaclePercept, Outputs, PlanAnswer
from vehicle_agent.stacks.choice import Planner, build_car, build_planner
from vehicle_agent.stacks.gem import height_map

STEP_NS = 20_000_000
VEHICLE_ID = "shuttle"
# As in `campusloop.virtual_vehicle`: what the workers take.
PERCEPT_DELAY_NS = 2 * STEP_NS
PLAN_DELAY_NS = 2 * STEP_NS
_START_NS = 1_000_000_000
_FAR_FUTURE_NS = 10**18
_SET_OFF_STEPS_MAX = 500


class SceneError(Exception):
    """A scene that cannot be driven; the message says why."""


class HeldActors(Actors, Protocol):
    """Actors whose clock can be stopped until the vehicle sets off."""

    hold: bool


@dataclass(frozen=True, slots=True)
class Scene:
    """road_map: of one lane (`path_map`); places on it are the rear axle's.

    start_s_m, start_mps  where the run begins, already rolling
    goal_s_m              where it ends; the vehicle is ordered to the lane's end, beyond it
    limit_s               the run is given up after this time
    """

    name: str
    road_map: RoadMap
    profile: Profile
    start_s_m: float
    start_mps: float
    goal_s_m: float
    limit_s: float
    seed: int
    actors: HeldActors | None = None
    options: WorldOptions = field(default_factory=lambda: WorldOptions(traffic=None))


@dataclass(frozen=True, slots=True)
class SceneRun:
    """time_s to the goal, or None when it was not reached; plan_ms: CPU of each motion plan."""

    name: str
    time_s: float | None
    driven_m: float
    trace: SceneTrace
    verdict: Verdict
    plan_cpu_ms: tuple[float, ...]
    tick_cpu_s: float
    limited_by: tuple[tuple[str, int], ...]


class SceneDrive:
    """Steps world and vehicle computer together; `run` drives the scene to its end."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        profile = scene.profile
        self._network = RoadNetwork(scene.road_map)
        self._start = Pose2(*self._network.pose(LANE_ID, scene.start_s_m))
        options = replace(scene.options, actors=scene.actors)
        self.world = SimWorld(
            scene.road_map, {VEHICLE_ID: profile}, {VEHICLE_ID: self._start}, scene.seed, _NoPhone(), options
        )
        car = build_car(profile, scene.road_map)
        self.computer = VehicleComputer(car, initial_state(car))
        self._planner: Planner | None = build_planner(profile, scene.road_map)
        self.gate, self._inbox = gate_of(profile), Inbox()
        self._height_map = height_map(profile)
        self._percepts: deque[tuple[int, ObstaclePercept]] = deque()
        self._plans: deque[tuple[int, PlanAnswer]] = deque()
        self.now_ns = _START_NS
        self.outputs: Outputs | None = None
        self._trace = SceneTrace()
        self._plan_cpu_ms: list[float] = []
        self._tick_cpu_s = 0.0
        self._limited: dict[str, int] = {}

    def run(self, watch: Callable[["SceneDrive"], None] = lambda _drive: None) -> SceneRun:
        """To the goal or the time limit; `watch` is called after every step."""
        self._set_off()
        scene, begin_ns = self.scene, self.now_ns
        length_m = scene.goal_s_m - scene.start_s_m
        while self.now_ns - begin_ns < scene.limit_s * 1e9:
            self.step()
            assert self.outputs is not None
            limited_by = self.outputs.flow.path.limited_by
            self._limited[limited_by] = self._limited.get(limited_by, 0) + 1
            truth = self.world.truth(VEHICLE_ID)
            self._trace.add((self.now_ns - begin_ns) * 1e-9, truth, self.world.bodies())
            watch(self)
            if self._driven_m() >= length_m:
                break
        rows = self._trace.array()
        reached = self._driven_m() >= length_m
        return SceneRun(
            scene.name,
            float(rows[-1, 0]) if reached else None,
            self._driven_m(),
            self._trace,
            judge(rows, self._trace.agents, scene.profile.body),
            tuple(self._plan_cpu_ms),
            self._tick_cpu_s,
            tuple(sorted(self._limited.items(), key=lambda item: -item[1])),
        )

    def _driven_m(self) -> float:
        """Along the lane from the start, by the truth."""
        pose = self.world.truth(VEHICLE_ID).pose_map
        found = self._network.locate(pose.x_m, pose.y_m, pose.yaw_rad)
        return 0.0 if found is None else found[1] - self.scene.start_s_m

    def _set_off(self) -> None:
        """By-wire is asked for at rest, with nobody around; then the run begins, rolling."""
        actors = self.scene.actors
        if actors is not None:
            actors.hold = True
        for _ in range(25):
            self.step()
        self._tell_order()
        for _ in range(_SET_OFF_STEPS_MAX):
            self.step()
            if self.outputs is not None and self.outputs.flow.motion.enabled:
                break
        else:
            raise SceneError(f"{self.scene.name}: by-wire was not given")
        self.world.place(VEHICLE_ID, self._start, self.scene.start_mps)
        if actors is not None:
            actors.hold = False

    def _tell_order(self) -> None:
        end_m = self._network.lines[LANE_ID].length_m - 0.5
        visit = Visit("end", "rest", "", LANE_ID, end_m, (LANE_ID,))
        sections = self._network.sections_of(LANE_ID)
        grants = tuple(SectionGrant(section.section_id, k) for k, section in enumerate(sections, start=1))
        version = self.scene.road_map.map_version
        self._inbox.put(self.now_ns, "link", LinkState(self.now_ns, True, 1, 0))
        self._inbox.put(self.now_ns, "link", Order(1, "scene", 1, version, (visit,), grants, _FAR_FUTURE_NS))
        self._inbox.put(self.now_ns, "link", Command(1, "go", "resume"))

    def step(self) -> None:
        """20 ms of the vehicle computer and of the world."""
        now_ns, world = self.now_ns, self.world
        arrived = world.frames_to_vehicle(VEHICLE_ID)
        reports = tuple(msgspec.structs.replace(frame, stamp_ns=now_ns) for frame in arrived)
        self.gate.hear(reports, now_ns)
        for frame in reports:
            self._inbox.put(now_ns, "can", frame)
        for item in world.sensor_items(VEHICLE_ID, now_ns):
            self._inbox.put(now_ns, "sensors", item)
        for percept in world.tracked(VEHICLE_ID, now_ns):
            self._inbox.put(now_ns, "tracker", percept)
            self.gate.see(percept)
        scan = world.scan(VEHICLE_ID, now_ns)
        if scan is not None:
            cells = percept_from_scan(np.ascontiguousarray(scan[0]), now_ns, self._height_map)
            self._percepts.append((now_ns + PERCEPT_DELAY_NS, cells))
        while self._percepts and self._percepts[0][0] <= now_ns:
            _, seen = self._percepts.popleft()
            self._inbox.put(now_ns, "worker", seen)
            self.gate.see(seen)
        while self._plans and self._plans[0][0] <= now_ns:
            self._inbox.put(now_ns, "planner", self._plans.popleft()[1])
        begun_s = time.process_time()
        outputs = self.outputs = self.computer.run_tick(self._inbox.drain(), now_ns)
        self._tick_cpu_s += time.process_time() - begun_s
        self._plan(outputs)
        self.gate.take(outputs.frames, now_ns)
        world.frames_from_vehicle(VEHICLE_ID, self.gate.step(now_ns))
        for told in self.gate.word(now_ns):
            self._inbox.put(now_ns, "can", told)
        world.show(VEHICLE_ID, outputs.says, now_ns)
        world.step(now_ns)
        self.now_ns += STEP_NS

    def _plan(self, outputs: Outputs) -> None:
        for job in outputs.jobs:
            assert self._planner is not None, "only a stack with a planner makes jobs"
            begun_s = time.process_time()
            answer = self._planner(job)
            self._plan_cpu_ms.append(1e3 * (time.process_time() - begun_s))
            self._plans.append((self.now_ns + PLAN_DELAY_NS, answer))


class _NoPhone:
    """Nobody has booked anything."""

    def vehicle_of(self, ride_id: str) -> str:
        return ""

    def tap(self, ride_id: str, kind: str) -> None:
        raise AssertionError("there are no riders in a scene")

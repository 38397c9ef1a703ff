"""One scene driven from start to goal by the whole onboard loop: CAN, gate, by-wire, plant and all."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

import msgspec
import numpy as np

from campusloop.scenes.faults import Camera, FaultyInputs, InputFault, camera_feeds
from campusloop.scenes.judge import Verdict, judge
from campusloop.scenes.path_map import LANE_ID
from campusloop.scenes.trace import SceneTrace
from campusloop.virtual.conductor import STEP_NS
from campusloop.virtual.granted_order import go_words, granted_order, rest_at
from campusloop.virtual.wiring import WiredVehicle
from contract.geometry import Pose2, pose_at, project
from contract.roads.load import encode_map
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.routing import ReferenceLine, Route, route_line
from contract.runlog.records import RunHeader
from contract.wire.messages import Command
from simulator.riders import NoPhones
from simulator.traffic.actors import Actors
from simulator.world import SimWorld, WorldOptions
from vehicle_agent.config import Profile
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.processes.agent import SOFTWARE
from vehicle_agent.runtime.recording.recorder import Recorder
from vehicle_agent.runtime.recording.runlog_files import RunLogFiles
from vehicle_agent.signals import LinkMessage, Outputs
from vehicle_agent.stacks.choice import build_car

VEHICLE_ID = "shuttle"
_START_NS = 1_000_000_000
_FAR_FUTURE_NS = 10**18
_SET_OFF_STEPS_MAX = 500
# As long as names may be on the wire.
_NAME_LENGTH = 64


class SceneError(Exception):
    """A scene that cannot be driven; the message says why."""


class HeldActors(Actors, Protocol):
    """Actors whose clock can be stopped until the vehicle sets off."""

    hold: bool


@dataclass(frozen=True, slots=True)
class Scene:
    """road_map: of one lane (`path_map`), or a campus with a `route`; places are the rear axle's.

    start_s_m, start_mps  where the run begins, already rolling: on the lane, or along the route
    goal_s_m              where it ends; the vehicle is ordered to the lane's (the route's) end, beyond it
    limit_s               the run is given up after this time
    route                 on a campus; places are then counted from its start
    faults, cameras       what is wrong with the vehicle's inputs; who watches the map's observation areas
    resumes_s             when an operator says that the vehicle may go on
    stop_id               the stop at the route's end, if it ends at one
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
    route: Route | None = None
    faults: tuple[InputFault, ...] = ()
    cameras: tuple[Camera, ...] = ()
    resumes_s: tuple[float, ...] = ()
    stop_id: str = ""


@dataclass(frozen=True, slots=True)
class SceneRun:
    """time_s to the goal, or None when it was not reached; plan_ms: CPU of each motion plan.

    told   everything the vehicle said of itself: modes, and codes of faults
    way_m  along the road at each row of the trace
    """

    name: str
    time_s: float | None
    driven_m: float
    trace: SceneTrace
    verdict: Verdict
    plan_cpu_ms: tuple[float, ...]
    tick_cpu_s: float
    limited_by: tuple[tuple[str, int], ...]
    told: tuple[str, ...] = ()
    way_m: tuple[float, ...] = ()


class SceneDrive:
    """Steps world and vehicle computer together; `run` drives the scene to its end."""

    def __init__(self, scene: Scene, runs: Path | None = None) -> None:
        """runs: where the run log goes, into a folder named after stack and scene; None: none is kept."""
        self.scene = scene
        profile = scene.profile
        self._network = RoadNetwork(scene.road_map)
        self._way = _way(self._network, scene)
        self._segment = int(np.searchsorted(self._way.s, scene.start_s_m))
        self._start = Pose2(*pose_at(self._way.points, self._way.s, scene.start_s_m))
        options = replace(scene.options, actors=scene.actors)
        self.world = SimWorld(
            scene.road_map, {VEHICLE_ID: profile}, {VEHICLE_ID: self._start}, scene.seed, NoPhones(), options
        )
        car = build_car(profile, scene.road_map)
        self._log: RunLogFiles | None = None
        recorder = None
        if runs is not None:
            self._log = RunLogFiles(runs, msgspec.msgpack.encode(profile), encode_map(scene.road_map))
            recorder = Recorder(_header(scene), profile.body, scene.road_map.observation_areas)
        self.computer = VehicleComputer(car, initial_state(car), recorder)
        self.wired = WiredVehicle(VEHICLE_ID, profile, scene.road_map, self.world)
        self.wired.boot(self.computer)
        self.now_ns = _START_NS
        self.outputs: Outputs | None = None
        self._trace = SceneTrace()
        self._tick_cpu_s = 0.0
        self._limited: dict[str, int] = {}
        self._told: dict[str, None] = {}
        self._way_m: list[float] = []
        self._begin_ns = _FAR_FUTURE_NS
        self._faults = FaultyInputs(scene.faults, scene.road_map.origin)
        self._cameras = camera_feeds(scene.cameras, scene.road_map)
        self._resumes = list(scene.resumes_s)
        if scene.route is not None:
            self.world.follow(VEHICLE_ID, self._way.points)

    def run(self, watch: Callable[["SceneDrive"], None] = lambda _drive: None) -> SceneRun:
        """To the goal or the time limit; `watch` is called after every step."""
        self._set_off()
        scene, begin_ns = self.scene, self.now_ns
        self._begin_ns = begin_ns
        while self.now_ns - begin_ns < scene.limit_s * 1e9:
            self.step()
            assert self.outputs is not None
            self._told.setdefault(self.outputs.flow.guard_status.mode)
            for fault in self.outputs.flow.guard_status.faults:
                self._told.setdefault(fault.code)
            limited_by = self.outputs.flow.path.limited_by
            self._limited[limited_by] = self._limited.get(limited_by, 0) + 1
            truth = self.world.truth(VEHICLE_ID)
            self._trace.add((self.now_ns - begin_ns) * 1e-9, truth, self.world.bodies())
            self._way_m.append(scene.start_s_m + self._driven_m())
            watch(self)
            if self._way_m[-1] >= scene.goal_s_m:
                break
        if self._log is not None:
            self._log.close()
        rows = self._trace.array()
        reached = self._way_m[-1] >= scene.goal_s_m
        return SceneRun(
            scene.name,
            float(rows[-1, 0]) if reached else None,
            self._driven_m(),
            self._trace,
            judge(rows, self._trace.agents, scene.profile.body),
            tuple(self.wired.plan_cpu_ms),
            self._tick_cpu_s,
            tuple(sorted(self._limited.items(), key=lambda item: -item[1])),
            tuple(self._told),
            tuple(self._way_m),
        )

    def _driven_m(self) -> float:
        """Along the way from the start, by the truth; never over to a piece of it that comes near."""
        pose, way, segment = self.world.truth(VEHICLE_ID).pose_map, self._way, self._segment
        s_m, _, self._segment = project(way.points, way.s, pose.x_m, pose.y_m, segment - 3, segment + 6)
        return s_m - self.scene.start_s_m

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
        route = self.scene.route
        end_m = route.end_s_m if route is not None else self._network.lines[LANE_ID].length_m - 0.5
        visits = rest_at(self._way.lane_ids, end_m, self.scene.stop_id)
        sections = [section_id for section_id, _, _ in self._way.sections]
        order = granted_order("scene", self.scene.road_map.map_version, visits, sections)
        for word in go_words(order, self.now_ns):
            self._hear(word)

    def step(self) -> None:
        """20 ms of the vehicle computer and of the world."""
        now_ns, faults = self.now_ns, self._faults
        now_s = (now_ns - self._begin_ns) * 1e-9
        for camera in self._cameras if now_s >= 0.0 else ():
            word = camera.word(now_s, now_ns, self.world.bodies())
            if word is not None:
                self._hear(word)
        while self._resumes and self._resumes[0] <= now_s:
            number = len(self.scene.resumes_s) - len(self._resumes)
            self._resumes.pop(0)
            self._hear(Command(1, f"resume-{number}", "resume"))
        self.outputs = self.wired.step(
            now_ns, lambda body: faults.passed(body, now_s), round(1e9 * faults.plan_delay_s(now_s))
        )
        self._tick_cpu_s += self.wired.tick_cpu_s
        if self._log is not None:
            self._log.write(self.computer.entries)
        self.world.step(now_ns)
        self.now_ns += STEP_NS

    def _hear(self, word: LinkMessage) -> None:
        self.wired.inbox.put(self.now_ns, "link", word)


def _way(network: RoadNetwork, scene: Scene) -> ReferenceLine:
    """What is driven: the only lane, or the route."""
    route = scene.route
    if route is None:
        length_m = network.lines[LANE_ID].length_m
        route = Route((LANE_ID,), 0.0, length_m, length_m, 0.0)
    return route_line(network, route)


def _header(scene: Scene) -> RunHeader:
    """The run log's: one boot of one vehicle, named so that logs of many scenes can lie side by side."""
    road_map, stack = scene.road_map, scene.profile.stack
    boot_id = re.sub(r"[^A-Za-z0-9._-]+", "-", f"{stack}-{scene.name}")[:_NAME_LENGTH]
    return RunHeader(VEHICLE_ID, boot_id, 0, road_map.campus_id, road_map.map_version, stack, SOFTWARE, 0, 0)

"""One scene driven from start to goal by the whole onboard loop, with CAN, gate, by-wire and plant."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

import msgspec
import numpy as np

from campusloop.scenes.contact_metrics import ContactMetrics, contact_metrics
from campusloop.scenes.faults import Camera, FaultyInputs, InputFault, camera_feeds
from campusloop.scenes.other_shuttle import OtherRoad, OtherRun, OtherShuttle
from campusloop.scenes.path_map import LANE_ID
from campusloop.scenes.trace import SceneTrace
from campusloop.virtual.conductor import STEP_NS
from campusloop.virtual.granted_order import granted_order, rest_at, start_messages
from campusloop.virtual.wiring import WiredVehicle
from contract.geometry import Pose2, pose_at, project
from contract.roads.load import encode_map
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.routing import ReferenceLine, Route, route_line
from contract.runlog.records import RunHeader
from contract.wire.messages import Command
from simulator.riders import NoPhones
from simulator.sensors.scene_lidars import open_square
from simulator.traffic.actors import Actors
from simulator.world import SimWorld, WorldOptions
from vehicle_agent.config import Profile
from vehicle_agent.onboard.car import Car, initial_state
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.processes.agent import SOFTWARE
from vehicle_agent.runtime.recording.recorder import Recorder
from vehicle_agent.runtime.recording.runlog_files import RunLogFiles
from vehicle_agent.signals import LinkMessage, Outputs
from vehicle_agent.stacks.choice import Planner, build_car, worker_tracks

VEHICLE_ID = "shuttle"
_START_NS = 1_000_000_000
_FAR_FUTURE_NS = 10**18
_SET_OFF_STEPS_MAX = 500
# The longest name that the wire allows.
_NAME_LENGTH = 64


class SceneError(Exception):
    """The scene cannot be driven; the message says why."""


class PausableActors(Actors, Protocol):
    """Actors whose clock stands still while `hold` is set, until the vehicle starts."""

    hold: bool


@dataclass(frozen=True, slots=True)
class Scene:
    """road_map: of one lane (`path_map`), or a campus with a `route`; places are the rear axle's.

    start_s_m, start_mps  position and speed at the start of the run, along the lane or route
    goal_s_m              where the run ends; the vehicle's order leads to the end of the lane or route
    limit_s               the run is ended after this time
    route                 on a campus; positions are then measured from its start
    faults, cameras       faults of the vehicle's inputs; cameras over the map's observation areas
    resumes_s             when an operator resumes the vehicle
    stop_id               the stop at the route's end, if it ends at one
    others                roads of other shuttles, each of the same profile
    """

    name: str
    road_map: RoadMap
    profile: Profile
    start_s_m: float
    start_mps: float
    goal_s_m: float
    limit_s: float
    seed: int
    actors: PausableActors | None = None
    options: WorldOptions = field(default_factory=lambda: WorldOptions(traffic=None))
    route: Route | None = None
    faults: tuple[InputFault, ...] = ()
    cameras: tuple[Camera, ...] = ()
    resumes_s: tuple[float, ...] = ()
    stop_id: str = ""
    others: tuple[OtherRoad, ...] = ()

    def with_plant(self, plant_seed: int | None) -> "Scene":
        """The scene with the vehicle's dynamics drawn from a seed; None: nominal ones."""
        return replace(self, options=replace(self.options, plant_seed=plant_seed))


@dataclass(frozen=True, slots=True)
class SceneRun:
    """The result of a drive, which ends at the goal, or when the last shuttle is at the end of its road.

    time_s       to the goal, or None if it was not reached
    plan_cpu_ms  CPU time of each motion plan
    limited_by   (what limited the planned speed, number of ticks), the most frequent first
    reported     guard modes and fault codes that occurred
    way_m        distance along the road at each row of the trace
    others       the other shuttles, in the order of their roads
    """

    name: str
    time_s: float | None
    driven_m: float
    trace: SceneTrace
    metrics: ContactMetrics
    plan_cpu_ms: tuple[float, ...]
    tick_cpu_s: float
    limited_by: tuple[tuple[str, int], ...]
    reported: tuple[str, ...] = ()
    way_m: tuple[float, ...] = ()
    others: tuple[OtherRun, ...] = ()


class SceneDrive:
    """Steps world and vehicle computer together; `run` drives the scene to its end."""

    def __init__(
        self,
        scene: Scene,
        runs: Path | None = None,
        planner: Planner | None = None,
        adapt: Callable[[Car], Car] = lambda car: car,
    ) -> None:
        """runs: folder of the run log, in a folder named after stack and scene; None for no log.

        For studies of single rooms: planner replaces the stack's, adapt changes its rooms.
        """
        self.scene = scene
        profile = scene.profile
        self._network = RoadNetwork(scene.road_map)
        self._way = _way(self._network, scene)
        self._segment = int(np.searchsorted(self._way.s, scene.start_s_m))
        self._start = Pose2(*pose_at(self._way.points, self._way.s, scene.start_s_m))
        options = replace(scene.options, actors=scene.actors)
        if worker_tracks(profile) and options.scene is None:
            # A shuttle that finds people by itself has to have people to look at, not posts and boxes.
            options = replace(options, scene=open_square(scene.seed))
        roads = {f"{VEHICLE_ID}-{k}": road for k, road in enumerate(scene.others, start=2)}
        starts = {VEHICLE_ID: self._start} | {name: road.start for name, road in roads.items()}
        self.world = SimWorld(
            scene.road_map, dict.fromkeys(starts, profile), starts, scene.seed, NoPhones(), options
        )
        self._others = [OtherShuttle(name, road, profile, self.world) for name, road in roads.items()]
        car = adapt(build_car(profile, scene.road_map))
        self._log: RunLogFiles | None = None
        recorder = None
        if runs is not None:
            self._log = RunLogFiles(runs, msgspec.msgpack.encode(profile), encode_map(scene.road_map))
            recorder = Recorder(
                _header(scene), profile.body, scene.road_map.observation_areas, profile.perception
            )
        self.computer = VehicleComputer(car, initial_state(car), recorder, tracks_by=profile.perception)
        self.wired = WiredVehicle(VEHICLE_ID, profile, scene.road_map, self.world)
        if planner is not None:
            self.wired.planner = planner
        self.wired.boot(self.computer)
        self.now_ns = _START_NS
        self.outputs: Outputs | None = None
        self._trace = SceneTrace()
        self._tick_cpu_s = 0.0
        self._limited: dict[str, int] = {}
        self._reported: dict[str, None] = {}
        self._way_m: list[float] = []
        self._begin_ns = _FAR_FUTURE_NS
        self._faults = FaultyInputs(scene.faults, scene.road_map.origin)
        self._cameras = camera_feeds(scene.cameras, scene.road_map)
        self._resumes = list(scene.resumes_s)
        if scene.route is not None:
            self.world.follow(VEHICLE_ID, self._way.points)

    def run(self, watch: Callable[["SceneDrive"], None] = lambda _drive: None) -> SceneRun:
        """Drive to the goal or the time limit; `watch` is called after every step."""
        self._set_off()
        scene, begin_ns = self.scene, self.now_ns
        self._begin_ns, reached_s = begin_ns, None
        while self.now_ns - begin_ns < scene.limit_s * 1e9:
            self.step()
            assert self.outputs is not None
            self._reported.setdefault(self.outputs.flow.guard_status.mode)
            for fault in self.outputs.flow.guard_status.faults:
                self._reported.setdefault(fault.code)
            limited_by = self.outputs.flow.path.limited_by
            self._limited[limited_by] = self._limited.get(limited_by, 0) + 1
            truth = self.world.truth(VEHICLE_ID)
            t_s = (self.now_ns - begin_ns) * 1e-9
            self._trace.add(t_s, truth, self.world.road_users_of(VEHICLE_ID))
            for other in self._others:
                other.record(t_s)
            self._way_m.append(scene.start_s_m + self._driven_m())
            watch(self)
            if reached_s is None and self._way_m[-1] >= scene.goal_s_m:
                reached_s = t_s
            if reached_s is not None and all(other.has_arrived for other in self._others):
                break
        if self._log is not None:
            self._log.close()
        rows = self._trace.array()
        return SceneRun(
            scene.name,
            reached_s,
            self._driven_m(),
            self._trace,
            contact_metrics(rows, self._trace.agents, scene.profile.body),
            tuple(self.wired.plan_cpu_ms),
            self._tick_cpu_s,
            tuple(sorted(self._limited.items(), key=lambda item: -item[1])),
            tuple(self._reported),
            tuple(self._way_m),
            tuple(other.result() for other in self._others),
        )

    def _driven_m(self) -> float:
        """True distance along the path from the start; never jumps to another part of the path near by."""
        pose, way, segment = self.world.truth(VEHICLE_ID).pose_map, self._way, self._segment
        s_m, _, self._segment = project(way.points, way.s, pose.x_m, pose.y_m, segment - 3, segment + 6)
        return s_m - self.scene.start_s_m

    def _set_off(self) -> None:
        """Engage by-wire at rest while the actors are held; then place the vehicle at the start speed."""
        actors = self.scene.actors
        if actors is not None:
            actors.hold = True
        for _ in range(25):
            self.step()
        self._send_order()
        for other in self._others:
            other.send_order(self.now_ns)
        for _ in range(_SET_OFF_STEPS_MAX):
            self.step()
            is_engaged = self.outputs is not None and self.outputs.flow.motion.enabled
            if is_engaged and all(other.is_engaged for other in self._others):
                break
        else:
            raise SceneError(f"{self.scene.name}: by-wire was not engaged")
        self.world.place(VEHICLE_ID, self._start, self.scene.start_mps)
        for other in self._others:
            other.set_off()
        if actors is not None:
            actors.hold = False

    def _send_order(self) -> None:
        route = self.scene.route
        end_m = route.end_s_m if route is not None else self._network.lines[LANE_ID].length_m - 0.5
        visits = rest_at(self._way.lane_ids, end_m, self.scene.stop_id)
        sections = [section_id for section_id, _, _ in self._way.sections]
        order = granted_order("scene", self.scene.road_map.map_version, visits, sections)
        for message in start_messages(order, self.now_ns):
            self._put_link_message(message)

    def step(self) -> None:
        """20 ms of the vehicle computer and of the world."""
        now_ns, faults = self.now_ns, self._faults
        now_s = (now_ns - self._begin_ns) * 1e-9
        for camera in self._cameras if now_s >= 0.0 else ():
            presence = camera.report(now_s, now_ns, self.world.bodies())
            if presence is not None:
                self._put_link_message(presence)
        while self._resumes and self._resumes[0] <= now_s:
            number = len(self.scene.resumes_s) - len(self._resumes)
            self._resumes.pop(0)
            self._put_link_message(Command(1, f"resume-{number}", "resume"))
        self.outputs = self.wired.step(
            now_ns, lambda body: faults.passed(body, now_s), round(1e9 * faults.plan_delay_s(now_s))
        )
        self._tick_cpu_s += self.wired.tick_cpu_s
        if self._log is not None:
            self._log.write(self.computer.entries)
        for other in self._others:
            other.step(now_ns)
        self.world.step(now_ns)
        self.now_ns += STEP_NS

    def _put_link_message(self, message: LinkMessage) -> None:
        self.wired.inbox.put(self.now_ns, "link", message)


def _way(network: RoadNetwork, scene: Scene) -> ReferenceLine:
    """The line to drive: the only lane, or the route."""
    route = scene.route
    if route is None:
        length_m = network.lines[LANE_ID].length_m
        route = Route((LANE_ID,), 0.0, length_m, length_m, 0.0)
    return route_line(network, route)


def _header(scene: Scene) -> RunHeader:
    """The run log's header: one boot of one vehicle, named after stack and scene."""
    road_map, stack = scene.road_map, scene.profile.stack
    boot_id = re.sub(r"[^A-Za-z0-9._-]+", "-", f"{stack}-{scene.name}")[:_NAME_LENGTH]
    return RunHeader(VEHICLE_ID, boot_id, 0, road_map.campus_id, road_map.map_version, stack, SOFTWARE, 0, 0)

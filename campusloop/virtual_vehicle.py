"""One vehicle in virtual time: the same computer, gate and desk as on a real one, wired to the simulator."""

import time
from collections import deque
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from campusloop.conductor import STEP_NS
from campusloop.room_timing import RoomTimes
from campusloop.virtual_link import Dial, VirtualLink
from contract.roads.load import encode_map
from contract.roads.model import RoadMap
from contract.runlog.records import RunHeader
from contract.wire.messages import VehicleEvent
from simulator.world import SimWorld
from vehicle_agent.config import Profile
from vehicle_agent.link.desk import Desk
from vehicle_agent.link.keys import load_or_make_key, signature_text
from vehicle_agent.link.session import Identity
from vehicle_agent.mission.memory import holding
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.perception.height_map import HeightMap, percept_from_scan
from vehicle_agent.runtime.agent import SOFTWARE, mission_memory
from vehicle_agent.runtime.agent_files import AgentFolder
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.gate import gate_of
from vehicle_agent.runtime.inbox import Inbox
from vehicle_agent.runtime.recorder import Recorder
from vehicle_agent.runtime.runlog_files import RunLogFiles
from vehicle_agent.runtime.tick_process import TickNewsWriter
from vehicle_agent.signals import LinkWord, ObstaclePercept, Outputs, PlanAnswer, PlanJob, Task
from vehicle_agent.stacks.choice import build_car, build_planner
from vehicle_agent.stacks.gem import height_map

# What the worker takes for one scan, with the trip to it and back.
PERCEPT_DELAY_NS = 2 * STEP_NS
# What the motion planner takes for one job, with the trip to it and back.
PLAN_DELAY_NS = 2 * STEP_NS


@dataclass(frozen=True, slots=True)
class VirtualVehicleSetup:
    """folder: the vehicle's disk. utc_offset_ns: UTC minus the virtual clock."""

    vehicle_id: str
    profile: Profile
    road_map: RoadMap
    folder: Path
    utc_offset_ns: int


class VirtualVehicle:
    """boot by boot: `boot` starts a computer, `crash` takes it away, the disk stays.

    happened: every event with the time of its tick; times: CPU of every room; plan_ms: of each motion plan.
    outputs: of the last tick; gate: since the last boot.
    """

    def __init__(self, setup: VirtualVehicleSetup, world: SimWorld, dial: Dial) -> None:
        self.setup = setup
        self._world = world
        self._dial = dial
        self._key = load_or_make_key(setup.folder / "key.pem")
        self._boots = 0
        self._map_json = encode_map(setup.road_map)
        self._profile_bytes = msgspec.msgpack.encode(setup.profile)
        self._height_map: HeightMap = height_map(setup.profile)
        self._planner = build_planner(setup.profile, setup.road_map)
        self._percepts: deque[tuple[int, ObstaclePercept]] = deque()
        self._plans: deque[tuple[int, PlanAnswer]] = deque()
        self.computer: VehicleComputer | None = None
        self._line_id = -1
        self.times = RoomTimes()
        self.happened: list[tuple[int, VehicleEvent]] = []
        self.plan_ms: list[float] = []
        self.outputs: Outputs | None = None

    def boot(self, now_ns: int) -> None:
        """A new boot: mission memory from disk, everything else from scratch."""
        self._boots += 1
        setup = self.setup
        boot_id = f"boot-{self._boots:06d}"
        identity = Identity(
            setup.vehicle_id,
            boot_id,
            SOFTWARE,
            setup.profile.stack,
            setup.road_map.map_version,
            setup.profile.body.seats,
            setup.profile.body.wheelchair_places,
        )
        memory = mission_memory(AgentFolder(setup.folder))
        desk = Desk(
            setup.folder / "outbox",
            identity,
            lambda text: signature_text(self._key, text),
            holding(memory),
            sync=False,
        )
        car = self.times.timed(build_car(setup.profile, setup.road_map))
        state = msgspec.structs.replace(initial_state(car), mission=car.mission.initial(memory))
        header = RunHeader(
            setup.vehicle_id,
            boot_id,
            0,
            setup.road_map.campus_id,
            setup.road_map.map_version,
            setup.profile.stack,
            SOFTWARE,
            setup.utc_offset_ns,
            0,
        )
        self.computer = VehicleComputer(
            car,
            state,
            Recorder(header, setup.profile.body, setup.road_map.observation_areas),
            setup.utc_offset_ns,
        )
        self.run_log = RunLogFiles(setup.folder / "runs", self._profile_bytes, self._map_json)
        self._desk, self._inbox, self._news = desk, Inbox(), TickNewsWriter()
        self.gate = gate_of(setup.profile)
        self.link = VirtualLink(desk, self._dial)

    def crash(self) -> None:
        """SIGKILL of everything onboard: nothing is finished, nothing is said."""
        self.link.drop()
        self.computer = None
        self._percepts.clear()
        self._plans.clear()

    def tell(self, now_ns: int, word: LinkWord) -> None:
        """Put a word into the inbox as if the link had brought it (for drives without a server)."""
        self._inbox.put(now_ns, "link", word)

    def step(self, now_ns: int) -> None:
        """Sensors, inbox drain, tick, gate: what happens at this vehicle in one 20 ms step."""
        reports = self._world.frames_to_vehicle(self.setup.vehicle_id)
        items = self._world.sensor_items(self.setup.vehicle_id, now_ns)
        tracked = self._world.tracked(self.setup.vehicle_id, now_ns)
        self._look_around(now_ns)
        if self.computer is None:
            return
        reports = tuple(msgspec.structs.replace(frame, stamp_ns=now_ns) for frame in reports)
        self.gate.hear(reports, now_ns)
        for frame in reports:
            self._inbox.put(now_ns, "can", frame)
        for item in (*items, *tracked):
            self._inbox.put(now_ns, "sensors", item)
        for percept in tracked:
            self.gate.see(percept)
        while self._percepts and self._percepts[0][0] <= now_ns:
            _, cells = self._percepts.popleft()
            self._inbox.put(now_ns, "worker", cells)
            self.gate.see(cells)
        while self._plans and self._plans[0][0] <= now_ns:
            self._inbox.put(now_ns, "planner", self._plans.popleft()[1])
        for word in self._desk.take_words():
            self._inbox.put(now_ns, "link", word)
        begun_ns = time.perf_counter_ns()
        outputs = self.computer.run_tick(self._inbox.drain(), now_ns)
        self.times.whole.append(time.perf_counter_ns() - begun_ns)
        self.outputs = outputs
        self._plan(outputs.jobs, now_ns)
        self.gate.take(outputs.frames, now_ns)
        self._world.frames_from_vehicle(self.setup.vehicle_id, self.gate.step(now_ns))
        for told in self.gate.word(now_ns):
            self._inbox.put(now_ns, "can", told)
        self._world.show(self.setup.vehicle_id, outputs.says, now_ns)
        self._show_way(outputs.flow.task, self.computer.state.mission.segment)
        self.happened.extend((now_ns, event) for event in outputs.events)
        news = self._news.news(outputs, self.computer.state.mission.memory, now_ns)
        if news is not None:
            self._desk.tick_news(news, now_ns)
        self.run_log.write(self.computer.entries)
        self.link.step(now_ns)

    def _plan(self, jobs: tuple[PlanJob, ...], now_ns: int) -> None:
        for job in jobs:
            assert self._planner is not None, "only a stack with a planner makes jobs"
            begun_s = time.process_time()
            self._plans.append((now_ns + PLAN_DELAY_NS, self._planner(job)))
            self.plan_ms.append(1e3 * (time.process_time() - begun_s))

    def _show_way(self, task: Task, segment: int) -> None:
        """People see where a shuttle means to go; the score needs to know it at forks.

        segment: of the line's points that the vehicle is at
        """
        if task.line is not None and task.line_id != self._line_id:
            self._line_id = task.line_id
            self._world.follow(self.setup.vehicle_id, task.line.points[segment:])

    def _look_around(self, now_ns: int) -> None:
        scan = self._world.scan(self.setup.vehicle_id, now_ns)
        if scan is not None and self.computer is not None:
            points = np.ascontiguousarray(scan[0])
            percept = percept_from_scan(points, now_ns, self._height_map)
            self._percepts.append((now_ns + PERCEPT_DELAY_NS, percept))

    def shut_down(self) -> None:
        """An orderly end: the open segment is finished."""
        self.run_log.close()
        self._desk.close()

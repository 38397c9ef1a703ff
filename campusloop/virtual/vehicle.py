"""One vehicle in virtual time: the computer, gate and link bridge of a real one, wired to the simulator."""

import math
from dataclasses import dataclass
from pathlib import Path

import msgspec

from campusloop.virtual.link import Dial, VirtualLink
from campusloop.virtual.room_timing import RoomTimes
from campusloop.virtual.wiring import WiredVehicle
from contract.roads.load import encode_map
from contract.roads.model import RoadMap
from contract.runlog.records import RunHeader
from contract.tracing import Spans
from contract.wire.messages import VehicleEvent
from simulator.world import SimWorld
from vehicle_agent.config import Profile
from vehicle_agent.link.bridge import LinkBridge
from vehicle_agent.link.keys import load_or_create_key, signature_text
from vehicle_agent.link.session import Identity
from vehicle_agent.mission.memory import MissionMemory, order_progress
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.runtime.code_mask import CodeMask
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.order_tracing import GateTracing, LinkTracing, TickTracing
from vehicle_agent.runtime.processes.agent import SOFTWARE, mission_memory
from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.runtime.processes.tick_process import TickUpdateWriter
from vehicle_agent.runtime.recording.recorder import Recorder
from vehicle_agent.runtime.recording.runlog_files import RunLogFiles
from vehicle_agent.signals import Ego, LinkMessage, Outputs, Task
from vehicle_agent.stacks.choice import build_car, checked_localization_map


@dataclass(frozen=True, slots=True)
class VirtualVehicleSetup:
    """folder: the vehicle's disk. utc_offset_ns: UTC minus the virtual clock.

    spans  of the rides that it serves; None: they are not traced
    point_map  the folder of the map that its scans are compared with; None: GNSS/INS alone
    """

    vehicle_id: str
    profile: Profile
    road_map: RoadMap
    folder: Path
    utc_offset_ns: int
    spans: Spans | None = None
    point_map: Path | None = None


class VirtualVehicle:
    """`boot` starts a computer, `crash` ends it; the disk stays.

    happened: every event with the time of its tick; times: of every room; outputs: of the last tick.
    wired: its computer and gate, and the simulated bus. position_errors_m: of each tick with a valid pose.
    """

    def __init__(self, setup: VirtualVehicleSetup, world: SimWorld, dial: Dial) -> None:
        self.setup = setup
        self._world = world
        self._dial = dial
        self._key = load_or_create_key(setup.folder / "key.pem")
        self._boots = 0
        self._map_json = encode_map(setup.road_map)
        self._profile_bytes = msgspec.msgpack.encode(setup.profile)
        # Not of the vehicle's key, which is another one in every run: a seed repeats the run log.
        mask = CodeMask(setup.vehicle_id.encode())
        point_map = setup.point_map
        self._localization_map = (
            ""
            if point_map is None
            else checked_localization_map(setup.profile, point_map, setup.road_map.origin).map_version
        )
        self.wired = WiredVehicle(setup.vehicle_id, setup.profile, setup.road_map, world, mask, point_map)
        self._line_id = -1
        self.times = RoomTimes()
        self.happened: list[tuple[int, VehicleEvent]] = []
        self.outputs: Outputs | None = None
        self.position_errors_m: list[float] = []
        self._tracing = None if setup.spans is None else _Tracing(setup.spans, setup.vehicle_id)

    def boot(self, now_ns: int) -> None:
        """A new boot: mission memory from disk, everything else in its initial state."""
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
        bridge = LinkBridge(
            setup.folder / "outbox",
            identity,
            lambda text: signature_text(self._key, text),
            order_progress(memory),
            sync=False,
        )
        car = self.times.timed(build_car(setup.profile, setup.road_map, self._localization_map))
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
            localization_map=self._localization_map,
        )
        recorder = Recorder(
            header, setup.profile.body, setup.road_map.observation_areas, setup.profile.perception
        )
        self.wired.boot(
            VehicleComputer(car, state, recorder, setup.utc_offset_ns, tracks_by=setup.profile.perception)
        )
        self.run_log = RunLogFiles(setup.folder / "runs", self._profile_bytes, self._map_json)
        self._bridge, self._update_writer = bridge, TickUpdateWriter()
        self.link = VirtualLink(bridge, self._dial)

    def crash(self) -> None:
        """All onboard processes are killed: nothing is closed and no message is sent."""
        self.link.drop()
        self.wired.crash()

    def put_link_message(self, now_ns: int, message: LinkMessage) -> None:
        """Put a message into the inbox as if it came by the link (for drives without a server)."""
        self.wired.inbox.put(now_ns, "link", message)

    def step(self, now_ns: int) -> None:
        """One 20 ms step of this vehicle: sensors, inbox drain, tick, gate and link."""
        wired = self.wired
        for message in self._bridge.session.take_messages() if wired.computer is not None else ():
            self.put_link_message(now_ns, message)
            if self._tracing is not None:
                self._tracing.link.received(message, now_ns + self.setup.utc_offset_ns)
        outputs = wired.step(now_ns)
        if outputs is None:
            return
        assert wired.computer is not None
        mission = wired.computer.state.mission
        self.times.whole.append(wired.tick_wall_ns)
        self.outputs = outputs
        self._note_position_error(outputs.flow.ego)
        self._show_route(outputs.flow.task, mission.segment)
        self.happened.extend((now_ns, event) for event in outputs.events)
        if self._tracing is not None:
            self._trace(self._tracing, outputs, mission.memory, now_ns + self.setup.utc_offset_ns)
        update = self._update_writer.update(outputs, mission.memory, now_ns, wired.computer.shown)
        if update is not None:
            self._bridge.process_update(update, now_ns)
        self.run_log.write(wired.computer.entries)
        self.link.step(now_ns)

    def _note_position_error(self, ego: Ego) -> None:
        """How far the vehicle is from where it says, while it says that it knows."""
        if ego.valid:
            truth = self._world.truth(self.setup.vehicle_id).pose_map
            self.position_errors_m.append(
                math.hypot(ego.pose_map.x_m - truth.x_m, ego.pose_map.y_m - truth.y_m)
            )

    def _trace(self, tracing: "_Tracing", outputs: Outputs, memory: MissionMemory, utc_ns: int) -> None:
        tracing.link.answered(outputs.answers, utc_ns)
        tracing.gate.commanded(tracing.tick.moved(outputs, memory, utc_ns), utc_ns)
        tracing.gate.sent(self.wired.sent_frames, bool(self.wired.gate.braking), utc_ns)

    def _show_route(self, task: Task, segment: int) -> None:
        """Give the world the vehicle's route: people react to it, and the score needs it at forks.

        segment: the index of the line's segment at the vehicle
        """
        if task.line is not None and task.line_id != self._line_id:
            self._line_id = task.line_id
            self._world.follow(self.setup.vehicle_id, task.line.points[segment:])

    def shut_down(self) -> None:
        """An orderly end: the open segment is closed."""
        self.run_log.close()
        self._bridge.close()


class _Tracing:
    """What the vehicle's processes do for traces of rides."""

    def __init__(self, spans: Spans, vehicle_id: str) -> None:
        self.link = LinkTracing(spans, vehicle_id)
        self.tick = TickTracing(spans, vehicle_id)
        self.gate = GateTracing(spans, vehicle_id)

"""One vehicle's gate and tick as real processes, with a simulation in real time.

There is no server and no link: the rig posts orders to the tick as the link would, and listens on the bus.
"""

import shutil
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import can
import msgspec
import numpy as np

from campusloop.live.simulation import simulate_vehicles
from campusloop.scenes.path_map import LANE_ID, path_map
from campusloop.virtual.granted_order import granted_order, rest_at, start_messages
from contract.roads.load import decode_map, encode_map
from contract.roads.model import RestingPlace, RoadMap
from contract.roads.network import RoadNetwork
from simulator.live.live import scan_ring_path
from simulator.live.ports import ports_of
from vehicle_agent.can.braking import CommandSetError
from vehicle_agent.can.by_wire import braking_of, codec_of
from vehicle_agent.config import Profile, profile_toml
from vehicle_agent.runtime.devices.can_bus import open_bus
from vehicle_agent.runtime.processes.agent import AgentPlace, run_gate, run_tick
from vehicle_agent.runtime.processes.agent_files import AgentFolder, VehicleFile
from vehicle_agent.runtime.processes.mailbox import Deliveries, Delivery, Mailbox
from vehicle_agent.runtime.processes.priority import TICK_PRIORITY, ask_for_real_time
from vehicle_agent.runtime.processes.supervisor import Job, Supervisor
from vehicle_agent.signals import CanFrame, VehicleMotion

VEHICLE_ID = "shuttle-1"
TICK_JOB, GATE_JOB = "tick", "gate"
_START_S_M = 15.0


@dataclass(frozen=True, slots=True)
class BusSample:
    """What was on the bus at stamp_ns: a report (motion), or the brake of a set of commands."""

    stamp_ns: int
    motion: VehicleMotion | None
    brake_ratio: float = 0.0


class ProcessFaultRig:
    """Call `start`, `send_order`, `listen` repeatedly, and `stop`. processes: gives the pids to signal."""

    def __init__(self, profile: Profile, road_map: RoadMap, folder: Path, base_port: int) -> None:
        """folder: of all files; the logs are `folder/NAME.log`."""
        self._profile, self._map, self._folder, self._base_port = profile, road_map, folder, base_port
        self._mail = Path(tempfile.mkdtemp(prefix="campusloop-"))
        self._ports = ports_of(0, base_port)
        self._codec, self._by_wire = codec_of(profile), braking_of(profile)
        self._reports: Any = self._codec.initial()
        self._set: list[CanFrame] = []
        self._orders_sent = 0
        self.processes = Supervisor(self._jobs())
        self._mailbox = Mailbox(self._mail / "vehicle" / "link")
        self._bus = open_bus(self._ports.can_channel)

    def start(self) -> None:
        self.processes.start()

    def stop(self) -> None:
        """Stop all processes."""
        self.processes.stop()
        self._bus.shutdown()
        self._mailbox.close()
        shutil.rmtree(self._mail, ignore_errors=True)

    def send_order(self) -> None:
        """Send the order to drive to the road's end, and an operator's resume."""
        network, now_ns = RoadNetwork(self._map), time.monotonic_ns()
        self._orders_sent += 1
        visits = rest_at((LANE_ID,), network.lines[LANE_ID].length_m - 1.0)
        sections = [section.section_id for section in network.sections_of(LANE_ID)]
        order = granted_order("bare", self._map.map_version, visits, sections, self._orders_sent)
        messages = start_messages(order, now_ns)
        deliveries = Deliveries(tuple(Delivery(now_ns, "link", message) for message in messages))
        self._mailbox.post(self._mail / "vehicle" / "tick", deliveries)

    def listen(self, seconds: float, until: Callable[[BusSample], bool] = lambda _: False) -> list[BusSample]:
        """Everything on the bus for that time or until a sample fulfils `until`. Restarts ended processes."""
        samples: list[BusSample] = []
        end_s = time.monotonic() + seconds
        while (left_s := end_s - time.monotonic()) > 0.0:
            self.processes.restart_ended()
            self._mailbox.take()
            message = self._bus.recv(timeout=min(left_s, 0.05))
            if message is None:
                continue
            sample = self._decode(message)
            if sample is not None:
                samples.append(sample)
                if until(sample):
                    break
        return samples

    def _decode(self, message: can.Message) -> BusSample | None:
        """A report, or a complete set of commands; stamped when the system received it."""
        stamp_ns = time.monotonic_ns() - max(0, round((time.time() - message.timestamp) * 1e9))
        frame = CanFrame(stamp_ns, message.arbitration_id, bytes(message.data))
        command_ids = self._by_wire.command_ids()
        if message.arbitration_id not in command_ids:
            motion, self._reports = self._codec.decode(self._reports, (frame,), stamp_ns)
            return BusSample(stamp_ns, motion)
        self._set = [*self._set[1 - len(command_ids) :], frame]
        for first in range(len(self._set)):
            try:
                command = self._by_wire.commanded(tuple(self._set[first:]))
            except CommandSetError:
                # The set is not complete, or begins with frames of the set before.
                continue
            first_ns, self._set = self._set[first].stamp_ns, []
            return BusSample(first_ns, None, command.brake_ratio)
        return None

    def _jobs(self) -> list[Job]:
        folder = self._folder
        folder.mkdir(parents=True, exist_ok=True)
        map_path, profile_path = folder / "map.json", folder / "profile.toml"
        map_path.write_bytes(encode_map(self._map))
        profile_path.write_text(profile_toml(self._profile))
        ports = self._ports
        vehicle = VehicleFile(
            vehicle_id=VEHICLE_ID,
            server_url="http://127.0.0.1",
            can_channel=ports.can_channel,
            values_port=ports.values_port,
            scans_port=ports.scans_port,
            hmi_port=ports.hmi_port,
            scan_ring=str(scan_ring_path(folder, VEHICLE_ID)),
        )
        AgentFolder(folder / "vehicle").prepare(vehicle, map_path, profile_path)
        place = AgentPlace((folder / "vehicle").resolve(), self._mail / "vehicle")
        world = (map_path, profile_path, self._base_port, folder)
        return [
            Job("simulator", _hardware, world, log_file=folder / "simulator.log"),
            Job(GATE_JOB, run_gate, (place,), log_file=folder / "gate.log"),
            Job(TICK_JOB, run_tick, (place,), log_file=folder / "tick.log"),
        ]


def straight_road(length_m: float, speed_mps: float) -> RoadMap:
    """One lane to the east, with a resting place at its beginning."""
    points = np.column_stack((np.arange(0.0, length_m, 1.0), np.zeros(round(length_m))))
    road_map = path_map("straight", points, width_m=4.0, speed_limit_mps=speed_mps)
    start = RestingPlace("start", LANE_ID, _START_S_M)
    # Encoded and decoded again, so that the version is that of the changed map.
    return decode_map(
        encode_map(msgspec.structs.replace(road_map, resting_places=(start, *road_map.resting_places)))
    )


def _hardware(map_path: Path, profile_path: Path, base_port: int, folder: Path) -> None:
    """With real-time priority, because a real by-wire module has a processor of its own."""
    ask_for_real_time("simulator", TICK_PRIORITY)
    simulate_vehicles(
        map_path,
        (VEHICLE_ID,),
        profile_path,
        base_port=base_port,
        folder=folder,
        people=False,
        lidar=False,
    )

"""One shuttle on a winding road, with faults injected into tick, gate, bus, steering and clock.

The chain is the real one (tick outputs -> gate -> bus -> by-wire module -> plant, and back), in virtual time
and without lidar. Each step is 20 ms.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import msgspec
import numpy as np

from campusloop.scenes.path_map import LANE_ID, path_map
from campusloop.virtual.granted_order import granted_order, rest_at, start_messages
from campusloop.virtual.wiring import WiredGate
from contract.geometry import Pose2
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from simulator.riders import NoPhones
from simulator.world import SimWorld, WorldOptions
from vehicle_agent.can.braking import ByWireBraking
from vehicle_agent.can.by_wire import braking_of
from vehicle_agent.can.dbc import FrameError
from vehicle_agent.config import LidarMount, Profile
from vehicle_agent.onboard.car import Car, initial_state
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.signals import CanFrame, MissionMessage
from vehicle_agent.stacks.choice import build_car

STEP_NS = 20_000_000
VEHICLE_ID = "shuttle"
START_NS = 200_000_000_000
START_S_M = 15.0
BRAKES_FROM = 0.3
_SET_OFF_STEPS_MAX = 200
_LENGTH_M, _WAVE_M, _LEAST_RADIUS_M = 160.0, 60.0, 35.0

Sets = list[tuple[CanFrame, ...]]


class FaultedDriveError(Exception):
    """The drive could not start; the message says why."""


@dataclass(frozen=True, slots=True)
class Course:
    """The map, car and speed that all drives of one campaign share."""

    profile: Profile
    road_map: RoadMap
    network: RoadNetwork
    car: Car
    speed_mps: float


def winding_course(profile: Profile, speed_mps: float) -> Course:
    """A sine wave with a minimum radius of 35 m, driven at most at speed_mps, without lidar."""
    limits = msgspec.structs.replace(profile.limits, speed_mps_max=speed_mps)
    no_lidar = LidarMount(rate_hz=0.0)
    # With neither lidar nor tracker no percepts are expected.
    profile = msgspec.structs.replace(profile, limits=limits, lidar=no_lidar, perception="own")
    x = np.arange(0.0, _LENGTH_M, 0.5)
    wave = 2.0 * math.pi / _WAVE_M
    y = np.sin(wave * (x - START_S_M)) / (_LEAST_RADIUS_M * wave**2)
    road_map = path_map("winding", np.column_stack((x, y)), width_m=4.0, speed_limit_mps=speed_mps)
    return Course(profile, road_map, RoadNetwork(road_map), build_car(profile, road_map), speed_mps)


class FaultedDrive:
    """Call `set_off`, then `step` repeatedly; inject faults through the public attributes; `resume`.

    wired           the gate, the tick's inbox and the bus between them and the world
    set_filter      changes this step's command sets (none when the tick is dead) on their way to the gate
    tick_dead, gate_dead  the process does nothing
    tick_jump_ns, gate_jump_ns  how far its clock is ahead of the world's
    crashes         the exceptions that ended the tick; only `boot_tick` starts it again
    brake_ratio     the brake sent on the bus in the last step, 0 without a command
    """

    def __init__(self, course: Course, seed: int) -> None:
        self.course = course
        profile = course.profile
        self._start = Pose2(*course.network.pose(LANE_ID, START_S_M))
        options = WorldOptions(traffic=None, lidar=False)
        poses = {VEHICLE_ID: self._start}
        self.world = SimWorld(course.road_map, {VEHICLE_ID: profile}, poses, seed, NoPhones(), options)
        self.now_ns = START_NS
        self.set_filter: Callable[[Sets], Sets] = lambda sets: sets
        self.tick_dead = self.gate_dead = False
        self.tick_jump_ns = self.gate_jump_ns = 0
        self.crashes: list[str] = []
        self.brake_ratio = 0.0
        self.wired = WiredGate(VEHICLE_ID, profile, self.world)
        self.boot_tick()
        self._by_wire: ByWireBraking = braking_of(profile)
        self._resumes = 0

    def boot_tick(self) -> None:
        """A new tick process, in its initial state."""
        car = self.course.car
        self.computer = VehicleComputer(car, initial_state(car))
        self.wired.restart_inbox()
        self.tick_dead = False

    def restart_gate(self) -> None:
        """A new gate process."""
        self.wired.restart_gate()
        self.gate_dead = False

    def set_off(self) -> None:
        """Engage by-wire at rest; then place the vehicle at the start with the course's speed."""
        for _ in range(15):
            self.step()
        self.resume()
        for _ in range(_SET_OFF_STEPS_MAX):
            self.step()
            if self.computer.state.can.handshake.is_on:
                break
        else:
            raise FaultedDriveError("by-wire was not engaged")
        self.world.place(VEHICLE_ID, self._start, self.course.speed_mps)

    def resume(self) -> None:
        """Send the order and an operator's resume."""
        now_ns = self.now_ns + self.tick_jump_ns
        network, version = self.course.network, self.course.road_map.map_version
        visits = rest_at((LANE_ID,), network.lines[LANE_ID].length_m - 0.5)
        sections = [section.section_id for section in network.sections_of(LANE_ID)]
        self._resumes += 1
        order = granted_order("faults", version, visits, sections, self._resumes)
        for message in start_messages(order, now_ns):
            self.wired.inbox.put(now_ns, "link", message)

    def step(self) -> None:
        world, now_ns = self.world, self.now_ns
        reports = world.frames_to_vehicle(VEHICLE_ID)
        gate_ns, tick_ns = now_ns + self.gate_jump_ns, now_ns + self.tick_jump_ns
        if not self.gate_dead:
            self.wired.take_reports(reports, gate_ns)
        for item in world.sensor_items(VEHICLE_ID, now_ns):
            assert not isinstance(item, MissionMessage), "sensors send nothing for the server"
            moved = msgspec.structs.replace(item, stamp_ns=item.stamp_ns + self.tick_jump_ns)
            self.wired.inbox.put(tick_ns, "sensors", moved)
        sets = [] if self.tick_dead else self._tick(tick_ns)
        self.brake_ratio = 0.0
        if not self.gate_dead:
            self._pass_gate(self.set_filter(sets), gate_ns)
        world.step(now_ns)
        self.now_ns += STEP_NS

    def _tick(self, tick_ns: int) -> Sets:
        """One tick. An exception is a bug; it ends the process and is recorded in `crashes`."""
        try:
            return [self.computer.run_tick(self.wired.inbox.drain(), tick_ns).frames]
        except (ArithmeticError, FrameError, LookupError, TypeError, ValueError) as error:
            self.crashes.append(repr(error))
            self.tick_dead = True
            return []

    def _pass_gate(self, sets: Sets, gate_ns: int) -> None:
        """Frames on the bus have the world's time, whatever the gate's clock."""
        for frames in sets:
            self.wired.gate.take_commands(frames, gate_ns)
        sent = self.wired.send(gate_ns, self.now_ns)
        if sent:
            self.brake_ratio = self._by_wire.commanded(sent).brake_ratio

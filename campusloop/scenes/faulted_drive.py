"""One shuttle on a winding road, whose tick, gate, bus, steering and clock can be made to fail.

The chain is the real one (tick outputs -> gate -> bus -> by-wire module -> plant, and back), in virtual time,
without sensors that have no part in it. Each step is 20 ms.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import msgspec
import numpy as np

from campusloop.scenes.path_map import LANE_ID, path_map
from campusloop.virtual.granted_order import go_words, granted_order, rest_at
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
    """The drive could not begin; the message says why."""


@dataclass(frozen=True, slots=True)
class Course:
    """What drives of one kind of vehicle at one speed have in common."""

    profile: Profile
    road_map: RoadMap
    network: RoadNetwork
    car: Car
    speed_mps: float


def winding_course(profile: Profile, speed_mps: float) -> Course:
    """A sine wave of least radius 35 m, driven at most at speed_mps; nothing is seen by lidar."""
    limits = msgspec.structs.replace(profile.limits, speed_mps_max=speed_mps)
    blind = LidarMount(rate_hz=0.0)
    profile = msgspec.structs.replace(profile, limits=limits, lidar=blind)
    x = np.arange(0.0, _LENGTH_M, 0.5)
    wave = 2.0 * math.pi / _WAVE_M
    y = np.sin(wave * (x - START_S_M)) / (_LEAST_RADIUS_M * wave**2)
    road_map = path_map("winding", np.column_stack((x, y)), width_m=4.0, speed_limit_mps=speed_mps)
    return Course(profile, road_map, RoadNetwork(road_map), build_car(profile, road_map), speed_mps)


class FaultedDrive:
    """`set_off`, `step` on and on, spoil whatever is public, `resume`.

    wired           the gate, the tick's inbox and the bus between them and the world
    mail            makes of this step's set (none when the tick is dead) the sets that the gate gets
    tick_dead, gate_dead  the process does nothing
    tick_jump_ns, gate_jump_ns  how far its clock is ahead of the world's
    crashes         what killed the tick by itself; nobody starts it again but `boot_tick`
    brake_ratio     the brake that was sent on the bus in the last step, 0 when nothing was
    """

    def __init__(self, course: Course, seed: int) -> None:
        self.course = course
        profile = course.profile
        self._start = Pose2(*course.network.pose(LANE_ID, START_S_M))
        options = WorldOptions(traffic=None, lidar=False)
        poses = {VEHICLE_ID: self._start}
        self.world = SimWorld(course.road_map, {VEHICLE_ID: profile}, poses, seed, NoPhones(), options)
        self.now_ns = START_NS
        self.mail: Callable[[Sets], Sets] = lambda sets: sets
        self.tick_dead = self.gate_dead = False
        self.tick_jump_ns = self.gate_jump_ns = 0
        self.crashes: list[str] = []
        self.brake_ratio = 0.0
        self.wired = WiredGate(VEHICLE_ID, profile, self.world)
        self.boot_tick()
        self._by_wire: ByWireBraking = braking_of(profile)
        self._resumes = 0

    def boot_tick(self) -> None:
        """A new tick process: it knows nothing."""
        car = self.course.car
        self.computer = VehicleComputer(car, initial_state(car))
        self.wired.begin_inbox()
        self.tick_dead = False

    def revive_gate(self) -> None:
        """A new gate process."""
        self.wired.begin_gate()
        self.gate_dead = False

    def set_off(self) -> None:
        """By-wire is asked for at rest; then the vehicle is set down rolling at the course's speed."""
        for _ in range(15):
            self.step()
        self.resume()
        for _ in range(_SET_OFF_STEPS_MAX):
            self.step()
            if self.computer.state.can.handshake.is_on:
                break
        else:
            raise FaultedDriveError("by-wire was not given")
        self.world.place(VEHICLE_ID, self._start, self.course.speed_mps)

    def resume(self) -> None:
        """The order, and an operator's word to go."""
        now_ns = self.now_ns + self.tick_jump_ns
        network, version = self.course.network, self.course.road_map.map_version
        visits = rest_at((LANE_ID,), network.lines[LANE_ID].length_m - 0.5)
        sections = [section.section_id for section in network.sections_of(LANE_ID)]
        self._resumes += 1
        for word in go_words(granted_order("faults", version, visits, sections, self._resumes), now_ns):
            self.wired.inbox.put(now_ns, "link", word)

    def step(self) -> None:
        world, now_ns = self.world, self.now_ns
        reports = world.frames_to_vehicle(VEHICLE_ID)
        gate_ns, tick_ns = now_ns + self.gate_jump_ns, now_ns + self.tick_jump_ns
        if not self.gate_dead:
            self.wired.hear(reports, gate_ns)
        for item in world.sensor_items(VEHICLE_ID, now_ns):
            assert not isinstance(item, MissionMessage), "sensors say nothing for the server"
            moved = msgspec.structs.replace(item, stamp_ns=item.stamp_ns + self.tick_jump_ns)
            self.wired.inbox.put(tick_ns, "sensors", moved)
        sets = [] if self.tick_dead else self._tick(tick_ns)
        self.brake_ratio = 0.0
        if not self.gate_dead:
            self._pass_gate(self.mail(sets), gate_ns)
        world.step(now_ns)
        self.now_ns += STEP_NS

    def _tick(self, tick_ns: int) -> Sets:
        """One tick; whatever it raises is a bug, ends its process and is kept in `crashes`."""
        try:
            return [self.computer.run_tick(self.wired.inbox.drain(), tick_ns).frames]
        except (ArithmeticError, FrameError, LookupError, TypeError, ValueError) as error:
            self.crashes.append(repr(error))
            self.tick_dead = True
            return []

    def _pass_gate(self, sets: Sets, gate_ns: int) -> None:
        """The bus is in the world's time, whatever the computer's clocks say."""
        for frames in sets:
            self.wired.gate.take_commands(frames, gate_ns)
        sent = self.wired.send(gate_ns, self.now_ns)
        if sent:
            self.brake_ratio = self._by_wire.commanded(sent).brake_ratio

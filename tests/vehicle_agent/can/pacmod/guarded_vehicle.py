"""A simulated vehicle with module, codec, guard and gate: from a report's bytes to the plant."""

import numpy as np

from contract.geometry import Pose2
from contract.wire.messages import FaultRaised, ModeChanged, VehicleEvent
from simulator.ecus.by_wire import ByWire
from simulator.fleet import STEP_NS, SimFleet
from vehicle_agent.can.by_wire import codec_of
from vehicle_agent.config import Profile
from vehicle_agent.gate.gate import gate_of
from vehicle_agent.signals import (
    NO_SIGNALS,
    NO_TRACKS,
    Ages,
    CanFrame,
    ControlCommand,
    Ego,
    GuardStatus,
    Path,
    Task,
    VehicleMotion,
    World,
)
from vehicle_agent.stacks.rooms import guard

CRUISE = ControlCommand(0.0, 0.25, 0.0, 0.1)


class GuardedVehicle:
    """One shuttle at the origin on a free road, resumed, whose controller asks for a steady throttle.

    signals  that it commands; loses: identifiers of commands that do not reach the module
    """

    def __init__(self) -> None:
        profile = Profile()
        self.fleet = SimFleet({"s1": profile}, {"s1": Pose2(0.0, 0.0, 0.0)})
        module = self.fleet.modules["s1"]
        assert isinstance(module, ByWire)
        self.module = module
        self._can, self._guard, self._gate = codec_of(profile), guard(profile), gate_of(profile)
        self._can_state, self._guard_state = self._can.initial(), self._guard.initial()
        self.now_ns = 1_000_000_000
        self.resumed_ns = 1
        self.events: list[VehicleEvent] = []
        self.motion: VehicleMotion
        self.status: GuardStatus
        self.sent: list[CanFrame] = []
        self.signals = NO_SIGNALS
        self.loses: frozenset[int] = frozenset()

    @property
    def speed_mps(self) -> float:
        return self.fleet.truth("s1").speed_mps

    @property
    def codes(self) -> set[str]:
        return {fault.code for fault in self.motion.faults}

    def raised(self) -> list[tuple[str, bool]]:
        """(code, cleared) of the faults reported to the server, in order."""
        return [(event.fault.code, event.cleared) for event in self.events if isinstance(event, FaultRaised)]

    def modes(self) -> list[str]:
        return [event.mode for event in self.events if isinstance(event, ModeChanged)]

    def resume(self) -> None:
        self.resumed_ns = self.now_ns

    def drive(self, seconds: float) -> None:
        for _ in range(round(seconds * 1e9 / STEP_NS)):
            self._tick()

    def _tick(self) -> None:
        now_ns, truth = self.now_ns, self.fleet.truth("s1")
        frames = self.fleet.frames_to_vehicle("s1")
        self._gate.take_reports(frames, now_ns)
        self.motion, self._can_state = self._can.decode(
            self._can_state, frames + self._gate.report_frames(now_ns), now_ns
        )
        ego = Ego(now_ns, Pose2(0, 0, 0), truth.speed_mps, 0.0, 0.0, 0.0, 0.02, now_ns, True)
        task = Task(
            "drive", None, 1, 0.0, 0.0, 50.0, "l", 0.0, "o", 1, "v", "", "", False, (), "", None,
            resumed_ns=self.resumed_ns,
        )  # fmt: skip
        path = Path(now_ns, np.empty((0, 2)), np.empty(0), 2.0, "waypoint_speed", None, 50.0, False)
        world = World(now_ns, now_ns, np.empty((0, 2)), (), (), False, NO_TRACKS)
        actuation, self.status, self._guard_state = self._guard.step(
            self._guard_state, CRUISE, self.motion, ego, world, task, path, Ages(0, 0, 0, 0)
        )
        self.events += self._guard.events(self._guard_state)
        commands, self._can_state = self._can.encode(self._can_state, actuation, now_ns, self.signals)
        self._gate.take_commands(commands, now_ns)
        self.sent = [f for f in self._gate.step(now_ns) if f.arbitration_id not in self.loses]
        self.fleet.frames_from_vehicle("s1", tuple(self.sent))
        self.fleet.step(now_ns)
        self.now_ns += STEP_NS

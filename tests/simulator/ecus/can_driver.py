"""A driving computer reduced to its CAN room, for tests that close the loop through the bus."""

from contract.geometry import Pose2
from simulator.fleet import STEP_NS, SimFleet
from vehicle_agent.can.by_wire import codec_of
from vehicle_agent.config import Profile
from vehicle_agent.signals import Actuation, CanFrame, VehicleMotion

ROLL = Actuation(True, "drive", 0.0, 0.3, 0.0)
BRAKE = Actuation(True, "drive", 0.0, 0.0, 1.0)
RELEASE = Actuation(False, "drive", 0.0, 0.0, 0.0)


class CanDriver:
    """One vehicle at the origin; `run` ticks the codec and the world together."""

    def __init__(self, profile: Profile | None = None) -> None:
        self.profile = profile or Profile()
        self.fleet = SimFleet({"s1": self.profile}, {"s1": Pose2(0.0, 0.0, 0.0)})
        self.module = self.fleet.modules["s1"]
        self.can = codec_of(self.profile)
        self.state = self.can.initial()
        self.now_ns = 1_000_000_000
        self.motion: VehicleMotion
        self.heard: list[CanFrame] = []

    def run(self, seconds: float, act: Actuation, silent: bool = False) -> None:
        for _ in range(round(seconds * 50)):
            frames = self.fleet.frames_to_vehicle("s1")
            self.heard.extend(frames)
            self.motion, self.state = self.can.decode(self.state, frames, self.now_ns)
            commands, self.state = self.can.encode(self.state, act, self.now_ns)
            if not silent:
                self.fleet.frames_from_vehicle("s1", commands)
            self.fleet.step(self.now_ns)
            self.now_ns += STEP_NS

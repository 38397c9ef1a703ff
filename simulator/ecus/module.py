"""What every by-wire module is to the rest of the simulator."""

from dataclasses import dataclass
from typing import Literal, Protocol

from simulator.ecus.command_watch import CommandWatch
from simulator.ecus.safety_driver import SafetyDriver
from simulator.plant import PlantView
from vehicle_agent.signals import CanFrame

REPORT_PERIOD_NS = 33_333_333

FailAction = Literal["coast", "spring_brake"]


@dataclass(frozen=True, slots=True)
class ActuatorTargets:
    """What the module makes the actuators do; direction is 1, -1 or 0, lock 1 with the park pawl in."""

    steer_rad: float
    steer_rate_radps: float
    throttle_ratio: float
    brake_ratio: float
    direction: float
    lock: float

    def row(self) -> tuple[float, float, float, float, float, float]:
        """In the order of the plant's command columns."""
        return (
            self.steer_rad, self.steer_rate_radps, self.throttle_ratio,
            self.brake_ratio, self.direction, self.lock,
        )  # fmt: skip


class Module(Protocol):
    """One vehicle's by-wire module; what a scenario may do to it are its plain attributes."""

    watch: CommandWatch
    enabled: bool
    overridden: bool
    failed: bool
    injected_fault: bool
    steering_stuck: bool
    stop_pressed: bool
    driver: SafetyDriver

    def receive(self, frame: CanFrame) -> None:
        """One frame from the bus, `stamp_ns` being its arrival."""
        ...

    def supervise(self, now_ns: int, truth: PlantView) -> None:
        """Judge commands, driver and faults as they are now; before `targets`."""
        ...

    def report(self, now_ns: int, truth: PlantView) -> tuple[CanFrame, ...]:
        """Report frames when they are due, else nothing."""
        ...

    def targets(self, truth: PlantView) -> ActuatorTargets:
        """What the actuators shall do until the next step."""
        ...

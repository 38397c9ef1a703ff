"""What every by-wire module is to the rest of the simulator, and what all of them do alike."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Literal

from simulator.ecus.command_watch import CommandWatch
from simulator.ecus.safety_driver import HANDS_OFF, SafetyDriver
from simulator.vehicle.plant import PlantView
from vehicle_agent.config import Profile
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


class Module(ABC):
    """One vehicle's by-wire module; what a scenario may do to it are its plain attributes.

    Commands missing for 100 ms, a fault or the stop button switch it off and leave the vehicle to the fail
    action: `coast` gives it back to the driver (nobody brakes), `spring_brake` stops it.

    start_fault  latched: by-wire was asked for with a pedal down
    """

    def __init__(self, profile: Profile, fail_action: FailAction | None, watch: CommandWatch) -> None:
        """fail_action: the profile's when None."""
        self.profile = profile
        self.watch = watch
        self.enabled = False
        self.overridden = False
        self.failed = False
        self.start_fault = False
        self.injected_fault = False
        self.steering_stuck = False
        self.stop_pressed = False
        self.driver: SafetyDriver = HANDS_OFF
        # The bit that asks for by-wire, as last heard.
        self.asked = False
        self.timed_out = False
        self._fail_action: FailAction = fail_action or profile.fail_action
        self._next_report_ns: int | None = None

    @property
    def faulted(self) -> bool:
        return self.start_fault or self.injected_fault

    @abstractmethod
    def receive(self, frame: CanFrame) -> None:
        """One frame from the bus, `stamp_ns` being its arrival."""

    @abstractmethod
    def supervise(self, now_ns: int, truth: PlantView) -> None:
        """Judge commands, driver and faults as they are now; before `targets`."""

    @abstractmethod
    def commanded(self) -> ActuatorTargets:
        """What the commands ask of the actuators, while enabled."""

    @abstractmethod
    def gear(self) -> tuple[float, float]:
        """(direction, lock) of the drive while the vehicle is left alone."""

    @abstractmethod
    def reports(self, now_ns: int, truth: PlantView) -> tuple[CanFrame, ...]:
        """One round of reports, stamped now."""

    def report(self, now_ns: int, truth: PlantView) -> tuple[CanFrame, ...]:
        """Report frames when they are due, else nothing."""
        if self._next_report_ns is None:
            self._next_report_ns = now_ns
        if now_ns < self._next_report_ns:
            return ()
        self._next_report_ns += REPORT_PERIOD_NS
        return self.reports(now_ns, truth)

    def targets(self, truth: PlantView) -> ActuatorTargets:
        """What the actuators shall do until the next step; a stuck steering motor does nothing."""
        targets = self.commanded() if self.enabled else self._left_alone(truth)
        return replace(targets, steer_rate_radps=0.0) if self.steering_stuck else targets

    def ask(self, wanted: bool) -> bool:
        """Take the bit that asks for by-wire; True when it rises, which alone may enable."""
        rising, self.asked = wanted and not self.asked, wanted
        if not wanted:
            self.enabled = False
        return rising

    def watch_over(self, now_ns: int) -> None:
        """Who takes over, fails or falls silent ends by-wire."""
        self.timed_out = bool(self.watch.late(now_ns))
        if self.driver.takes_over:
            self.overridden = self.overridden or self.enabled
            self.enabled = False
        if self.enabled and (self.timed_out or self.faulted or self.stop_pressed):
            self.enabled = False
            self.failed = True
        if self.timed_out:
            # a bit that comes back must fall and rise again before it enables
            self.asked = True

    def _left_alone(self, truth: PlantView) -> ActuatorTargets:
        driver, (direction, lock) = self.driver, self.gear()
        sprung = self.failed and self._fail_action == "spring_brake"
        return ActuatorTargets(
            truth.steer_rad if driver.steer_rad is None else driver.steer_rad,
            self.profile.limits.steer_rate_radps_max,
            driver.throttle_ratio,
            1.0 if sprung or self.stop_pressed else driver.brake_ratio,
            direction,
            lock,
        )

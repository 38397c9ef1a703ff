"""The interface of by-wire modules, and their common behaviour."""

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
    """The actuators' targets. direction: 1, -1 or 0; lock: 1 with the park pawl engaged."""

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
    """One vehicle's by-wire module; a scenario sets its public attributes.

    Commands missing for 100 ms, a fault or the stop button disable it and trigger the fail action: `coast`
    returns control to the driver and does not brake, `spring_brake` stops the vehicle.

    start_fault  latched: by-wire was requested with a pedal down
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
        # The enable bit as last received.
        self.enable_requested = False
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
        """Check commands, driver and faults; call it before `targets`."""

    @abstractmethod
    def commanded(self) -> ActuatorTargets:
        """The actuator targets of the commands, while enabled."""

    @abstractmethod
    def gear(self) -> tuple[float, float]:
        """(direction, lock) of the drive while by-wire is disabled."""

    @abstractmethod
    def reports(self, now_ns: int, truth: PlantView) -> tuple[CanFrame, ...]:
        """One round of reports, stamped now."""

    def report(self, now_ns: int, truth: PlantView) -> tuple[CanFrame, ...]:
        """Report frames if they are due, otherwise none."""
        if self._next_report_ns is None:
            self._next_report_ns = now_ns
        if now_ns < self._next_report_ns:
            return ()
        self._next_report_ns += REPORT_PERIOD_NS
        return self.reports(now_ns, truth)

    def targets(self, truth: PlantView) -> ActuatorTargets:
        """The actuators' targets until the next step; a stuck steering motor does not move."""
        targets = self.commanded() if self.enabled else self._disabled_targets(truth)
        return replace(targets, steer_rate_radps=0.0) if self.steering_stuck else targets

    def request_enable(self, requested: bool) -> bool:
        """Take the enable bit; True if it rises. Only a rising bit may enable by-wire."""
        rising, self.enable_requested = requested and not self.enable_requested, requested
        if not requested:
            self.enabled = False
        return rising

    def check_inputs(self, now_ns: int) -> None:
        """Disable by-wire at a takeover, a fault, the stop button or missing commands."""
        self.timed_out = self.watch.stops_driving(now_ns)
        if self.driver.takes_over:
            self.overridden = self.overridden or self.enabled
            self.enabled = False
        if self.enabled and (self.timed_out or self.faulted or self.stop_pressed):
            self.enabled = False
            self.failed = True
        if self.timed_out:
            # After a timeout the bit must fall and rise again before it enables.
            self.enable_requested = True

    def _disabled_targets(self, truth: PlantView) -> ActuatorTargets:
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

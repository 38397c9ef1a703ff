"""The by-wire module of one vehicle: commands in by CAN, actuators out, reports back at 30 Hz."""

from dataclasses import replace

from simulator.ecus.command_watch import CommandWatch
from simulator.ecus.module import REPORT_PERIOD_NS, ActuatorTargets, FailAction
from simulator.ecus.report_frames import ModuleStatus, report_frames
from simulator.ecus.safety_driver import HANDS_OFF, SafetyDriver
from simulator.plant import PlantView
from vehicle_agent.can.commands import FRAME_GAP_NS
from vehicle_agent.can.steering_column import front_from_wheel, wheel_from_front
from vehicle_agent.config import Profile
from vehicle_agent.signals import CanFrame

PEDAL_REST_RATIO = 0.0005
SHIFT_SPEED_MPS_MAX = 0.3
PARK, REVERSE, DRIVE, LOW = 0.0, 1.0, 3.0, 4.0


class ByWire:
    """A PACMod3-class module.

    Enabled by a rising supervisory enable bit with both pedals commanded at zero, no override and no fault
    pending; enabling with a pedal down damages the brake servo (a latched fault). Commands missing for
    100 ms, a fault or the stop button switch it off and leave the vehicle to the fail action:
    `coast` gives it back to the driver (nobody brakes), `spring_brake` stops it.
    """

    def __init__(
        self, profile: Profile, fail_action: FailAction | None = None, gap_ns_min: int = FRAME_GAP_NS
    ) -> None:
        self._profile = profile
        self._fail_action: FailAction = fail_action or profile.fail_action
        self.watch = CommandWatch(gap_ns_min)
        self.enabled = False
        self.overridden = False
        self.failed = False
        self.servo_fault = False
        self.injected_fault = False
        self.steering_stuck = False
        self.stop_pressed = False
        self.driver: SafetyDriver = HANDS_OFF
        self._supervisory_enable = False
        self._timed_out = False
        self._next_report_ns: int | None = None
        self._gear = PARK

    @property
    def faulted(self) -> bool:
        return self.servo_fault or self.injected_fault

    def receive(self, frame: CanFrame) -> None:
        """One frame from the bus, `stamp_ns` being its arrival."""
        match self.watch.take(frame):
            case "global_command":
                self._on_global()
            case "supervisory_command":
                self._on_supervisory()
            case _:
                pass

    def supervise(self, now_ns: int, truth: PlantView) -> None:
        """Judge commands, driver and faults as they are now; before `targets`."""
        self._watch_over(now_ns)
        self._shift(truth.speed_mps)

    def report(self, now_ns: int, truth: PlantView) -> tuple[CanFrame, ...]:
        """Report frames when they are due, else nothing."""
        if self._next_report_ns is None:
            self._next_report_ns = now_ns
        if now_ns < self._next_report_ns:
            return ()
        self._next_report_ns += REPORT_PERIOD_NS
        return report_frames(now_ns, self._status(now_ns), truth, self._profile)

    def targets(self, truth: PlantView) -> ActuatorTargets:
        """What the actuators shall do until the next step; a stuck steering motor does nothing."""
        targets = self._wanted(truth)
        return replace(targets, steer_rate_radps=0.0) if self.steering_stuck else targets

    def _wanted(self, truth: PlantView) -> ActuatorTargets:
        watch, driver = self.watch, self.driver
        if self.enabled:
            wheel_rad = watch.value("steering_command", "wheel_angle")
            column = self._profile.steering
            linear_rad = wheel_from_front(column, 0.01) / 0.01
            return ActuatorTargets(
                front_from_wheel(column, wheel_rad),
                watch.value("steering_command", "wheel_rate") / linear_rad,
                self._commanded("accelerator_command"),
                max(self._commanded("brake_command"), driver.brake_ratio),
                _direction(self._gear),
                self._parked,
            )
        sprung = self.failed and self._fail_action == "spring_brake"
        steer_rad = truth.steer_rad if driver.steer_rad is None else driver.steer_rad
        return ActuatorTargets(
            steer_rad,
            self._profile.limits.steer_rate_radps_max,
            driver.throttle_ratio,
            1.0 if sprung or self.stop_pressed else driver.brake_ratio,
            _direction(self._gear),
            self._parked,
        )

    @property
    def _parked(self) -> float:
        return 1.0 if self._gear == PARK else 0.0

    def _commanded(self, command: str) -> float:
        """A pedal's command, 0 unless its own enable bit is set; there is nothing beyond a pedal's end."""
        position = self.watch.value(command, "position") if self.watch.value(command, "enable") else 0.0
        return min(max(position, 0.0), 1.0)

    def _on_global(self) -> None:
        if self.watch.value("global_command", "clear_overrides") and not self.driver.takes_over:
            self.overridden = False
        if self.watch.value("global_command", "clear_faults") and not self.enabled:
            self.servo_fault = False

    def _on_supervisory(self) -> None:
        wanted = bool(self.watch.value("supervisory_command", "enable"))
        rising = wanted and not self._supervisory_enable
        self._supervisory_enable = wanted
        if not wanted:
            self.enabled = False
        elif rising:
            self._try_enable()

    def _try_enable(self) -> None:
        if self.overridden or self.faulted or self.stop_pressed:
            return
        pedals = (
            self.watch.value("accelerator_command", "position"),
            self.watch.value("brake_command", "position"),
        )
        if max(pedals) > PEDAL_REST_RATIO:
            self.servo_fault = True
            return
        self.enabled = True
        self.failed = False

    def _watch_over(self, now_ns: int) -> None:
        self._timed_out = bool(self.watch.late(now_ns))
        if self.driver.takes_over:
            self.overridden = self.overridden or self.enabled
            self.enabled = False
        if self.enabled and (self._timed_out or self.faulted or self.stop_pressed):
            self.enabled = False
            self.failed = True
        if self._timed_out:
            # a heartbeat that comes back must fall and rise again before it enables
            self._supervisory_enable = True

    def _shift(self, speed_mps: float) -> None:
        """Between park, reverse and drive only while standing: the gearbox refuses otherwise."""
        if self.enabled and abs(speed_mps) < SHIFT_SPEED_MPS_MAX:
            self._gear = self.watch.value("shift_command", "gear")

    def _status(self, now_ns: int) -> ModuleStatus:
        return ModuleStatus(
            enabled=self.enabled,
            overridden=self.overridden,
            faulted=self.faulted,
            timed_out=self._timed_out,
            late=self.watch.late(now_ns),
            stop_pressed=self.stop_pressed,
            driver=self.driver,
            gear=self._gear,
            commanded_throttle=self.watch.value("accelerator_command", "position"),
            commanded_brake=self.watch.value("brake_command", "position"),
            commanded_gear=self.watch.value("shift_command", "gear"),
            commanded_wheel_rad=self.watch.value("steering_command", "wheel_angle"),
            errors=self.watch.malformed + self.watch.miscounted + self.watch.crowded,
        )


def _direction(gear: float) -> float:
    if gear in (DRIVE, LOW):
        return 1.0
    return -1.0 if gear == REVERSE else 0.0

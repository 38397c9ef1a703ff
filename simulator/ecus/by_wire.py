"""The by-wire module of one vehicle: it takes commands by CAN, drives the actuators and reports at 30 Hz."""

from dataclasses import replace

from simulator.ecus.command_watch import CommandWatch
from simulator.ecus.injected_flags import COUNTER_STANDS, Flag, checked_flag
from simulator.ecus.module import ActuatorTargets, FailAction, Module
from simulator.ecus.report_frames import ModuleStatus, report_frames
from simulator.vehicle.plant import PlantView
from vehicle_agent.can.pacmod.commands import FRAME_GAP_NS
from vehicle_agent.can.pacmod.watchdog import COMPONENT_COUNTER_STEPS
from vehicle_agent.can.steering_column import front_from_wheel, wheel_from_front
from vehicle_agent.config import Profile
from vehicle_agent.signals import CanFrame

PEDAL_REST_RATIO = 0.0005
SHIFT_SPEED_MPS_MAX = 0.3
PARK, REVERSE, DRIVE, LOW = 0.0, 1.0, 3.0, 4.0


class ByWire(Module):
    """A PACMod3-class module.

    A rising supervisory enable bit enables it if both pedals are commanded at zero and there is no override
    and no fault. Enabling with a pedal down damages the brake servo (a latched fault).

    Any flag of its reports can be injected. A subsystem with an injected `enabled` flag lets go of its
    actuator; the other flags are only reported, as by a module that notices a fault and drives on. Beside the
    flags: `counter` of the component's report stands still, `speed` of the speed report and `front_left` of
    the wheels' are stuck at zero, and `output` of the shift report is the neutral gear.
    """

    def __init__(
        self, profile: Profile, fail_action: FailAction | None = None, gap_ns_min: int = FRAME_GAP_NS
    ) -> None:
        super().__init__(profile, fail_action, CommandWatch(gap_ns_min))
        self._gear = PARK
        self._injected: dict[Flag, int | None] = {}
        self._rounds = 0

    def inject(self, report: str, signal: str, reports: int | None = None) -> None:
        """Report this flag from now on, or in the next `reports` reports only. Raises UnknownFlagError."""
        self._injected[checked_flag(report, signal)] = reports

    def clear_injected(self, report: str, signal: str) -> None:
        """Report the truth about this flag again. Raises UnknownFlagError."""
        self._injected.pop(checked_flag(report, signal), None)

    def receive(self, frame: CanFrame) -> None:
        """One frame from the bus, `stamp_ns` being its arrival."""
        match self.watch.take(frame):
            case "global_command":
                self._on_global()
            case "supervisory_command":
                if self.request_enable(bool(self.watch.value("supervisory_command", "enable"))):
                    self._try_enable()
            case _:
                pass

    def supervise(self, now_ns: int, truth: PlantView) -> None:
        """Check commands, driver and faults; call it before `targets`."""
        self.check_inputs(now_ns)
        # The gearbox shifts between park, reverse and drive only at standstill.
        if self.enabled and abs(truth.speed_mps) < SHIFT_SPEED_MPS_MAX:
            self._gear = self.watch.value("shift_command", "gear")

    def reports(self, now_ns: int, truth: PlantView) -> tuple[CanFrame, ...]:
        frames = report_frames(now_ns, self._status(now_ns), truth, self.profile)
        if COUNTER_STANDS not in self._injected:
            self._rounds += 1
        left = {flag: None if count is None else count - 1 for flag, count in self._injected.items()}
        self._injected = {flag: count for flag, count in left.items() if count != 0}
        return frames

    def targets(self, truth: PlantView) -> ActuatorTargets:
        targets = super().targets(truth)
        return replace(targets, steer_rate_radps=0.0) if self._lets_go("steering_report") else targets

    def _lets_go(self, report: str) -> bool:
        """The subsystem has let go although the module is enabled."""
        return self.enabled and (report, "enabled") in self._injected

    def commanded(self) -> ActuatorTargets:
        watch, column = self.watch, self.profile.steering
        wheel_rad = watch.value("steering_command", "wheel_angle")
        linear_rad = wheel_from_front(column, 0.01) / 0.01
        return ActuatorTargets(
            front_from_wheel(column, wheel_rad),
            watch.value("steering_command", "wheel_rate") / linear_rad,
            0.0 if self._lets_go("accelerator_report") else self._pedal("accelerator_command"),
            max(
                0.0 if self._lets_go("brake_report") else self._pedal("brake_command"),
                self.driver.brake_ratio,
            ),
            *self.gear(),
        )

    def gear(self) -> tuple[float, float]:
        return _direction(self._gear), 1.0 if self._gear == PARK else 0.0

    def _pedal(self, command: str) -> float:
        """A pedal's command within its range, 0 unless its own enable bit is set."""
        position = self.watch.value(command, "position") if self.watch.value(command, "enable") else 0.0
        return min(max(position, 0.0), 1.0)

    def _on_global(self) -> None:
        if self.watch.value("global_command", "clear_overrides") and not self.driver.takes_over:
            self.overridden = False
        if self.watch.value("global_command", "clear_faults") and not self.enabled:
            self.start_fault = False

    def _try_enable(self) -> None:
        if self.overridden or self.faulted or self.stop_pressed:
            return
        pedals = (
            self.watch.value("accelerator_command", "position"),
            self.watch.value("brake_command", "position"),
        )
        if max(pedals) > PEDAL_REST_RATIO:
            self.start_fault = True
            return
        self.enabled = True
        self.failed = False

    def _status(self, now_ns: int) -> ModuleStatus:
        return ModuleStatus(
            enabled=self.enabled,
            overridden=self.overridden,
            faulted=self.faulted,
            timed_out=self.timed_out,
            late=self.watch.late(now_ns),
            stop_pressed=self.stop_pressed,
            driver=self.driver,
            gear=self._gear,
            commanded_throttle=self.watch.value("accelerator_command", "position"),
            commanded_brake=self.watch.value("brake_command", "position"),
            commanded_gear=self.watch.value("shift_command", "gear"),
            commanded_wheel_rad=self.watch.value("steering_command", "wheel_angle"),
            commanded_turn=self.watch.value("turn_command", "turn_signal"),
            commanded_horn=self.watch.value("horn_command", "horn"),
            commanded_headlights=self.watch.value("headlight_command", "headlights"),
            counter=self._rounds % COMPONENT_COUNTER_STEPS,
            errors=self.watch.malformed + self.watch.miscounted + self.watch.crowded,
            injected=frozenset(self._injected),
        )


def _direction(gear: float) -> float:
    if gear in (DRIVE, LOW):
        return 1.0
    return -1.0 if gear == REVERSE else 0.0

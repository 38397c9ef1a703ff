"""A servo drive-by-wire: two servo motors and a throttle voltage, homed after power-on, armed by CAN."""

from dataclasses import replace

from simulator.ecus.command_watch import SERVO_DIALECT, CommandWatch
from simulator.ecus.module import REPORT_PERIOD_NS, ActuatorTargets, FailAction
from simulator.ecus.safety_driver import HANDS_OFF, SafetyDriver
from simulator.plant import PlantView
from vehicle_agent.can.dbc import SERVO, layouts
from vehicle_agent.can.servo_frames import (
    FORWARD,
    NEUTRAL,
    REVERSE,
    SERVO_FRAME_GAP_NS,
    brake_from_travel,
    duty_from_throttle,
    throttle_from_duty,
    travel_from_brake,
)
from vehicle_agent.can.servo_reports import encoder_ratio
from vehicle_agent.can.steering_column import front_from_wheel, wheel_from_front
from vehicle_agent.config import Profile
from vehicle_agent.signals import CanFrame

HOMING_NS = 500_000_000
DIRECTION_SPEED_MPS_MAX = 0.3
REST_RATIO = 0.0005


class ServoModule:
    """Armed by a rising arm bit once homed, with throttle and brake commanded at rest, no override, fault or
    stop button; arming with the throttle open latches a fault, which a reset clears while disarmed.

    Every command must be counted on and its check byte fit. Commands missing for 100 ms, a fault or the stop
    button disarm it; what happens then is the fail action: `coast` gives the vehicle back to the driver,
    `spring_brake` lets the spring press the brake. The direction relay switches below 0.3 m/s.
    """

    def __init__(self, profile: Profile, fail_action: FailAction | None = None) -> None:
        self._profile = profile
        self._fail_action: FailAction = fail_action or profile.fail_action
        self.watch = CommandWatch(SERVO_FRAME_GAP_NS, dialect=SERVO_DIALECT)
        self.enabled = False
        self.overridden = False
        self.failed = False
        self.start_fault = False
        self.injected_fault = False
        self.steering_stuck = False
        self.stop_pressed = False
        self.driver: SafetyDriver = HANDS_OFF
        self._arm = False
        self._timed_out = False
        self._direction = float(NEUTRAL)
        self._homed_ns: int | None = None
        self._homed = False
        self._next_report_ns: int | None = None

    @property
    def faulted(self) -> bool:
        return self.start_fault or self.injected_fault

    def receive(self, frame: CanFrame) -> None:
        """One frame from the bus, `stamp_ns` being its arrival."""
        if self.watch.take(frame) != "drive_command":
            return
        if self.watch.value("drive_command", "reset"):
            self.overridden = self.overridden and self.driver.takes_over
            self.start_fault = self.start_fault and self.enabled
        arm = bool(self.watch.value("drive_command", "arm"))
        rising, self._arm = arm and not self._arm, arm
        if not arm:
            self.enabled = False
        elif rising:
            self._try_arm()

    def _try_arm(self) -> None:
        if not self._homed or self.overridden or self.faulted or self.stop_pressed:
            return
        if self.watch.value("throttle_command", "duty") > REST_RATIO:
            self.start_fault = True
        elif self.watch.value("brake_command", "travel") <= REST_RATIO:
            self.enabled = True
            self.failed = False

    def supervise(self, now_ns: int, truth: PlantView) -> None:
        """Judge commands, driver and faults as they are now; before `targets`."""
        self._homed_ns = now_ns + HOMING_NS if self._homed_ns is None else self._homed_ns
        self._homed = now_ns >= self._homed_ns
        self._timed_out = bool(self.watch.late(now_ns))
        if self.driver.takes_over:
            self.overridden = self.overridden or self.enabled
            self.enabled = False
        if self.enabled and (self._timed_out or self.faulted or self.stop_pressed):
            self.enabled = False
            self.failed = True
        if self._timed_out:
            # an arm bit that comes back must fall and rise again before it arms
            self._arm = True
        if self.enabled and abs(truth.speed_mps) < DIRECTION_SPEED_MPS_MAX:
            self._direction = self.watch.value("drive_command", "direction")

    def targets(self, truth: PlantView) -> ActuatorTargets:
        """What the actuators shall do until the next step; a stuck steering motor does nothing."""
        targets = self._wanted(truth)
        return replace(targets, steer_rate_radps=0.0) if self.steering_stuck else targets

    def _wanted(self, truth: PlantView) -> ActuatorTargets:
        driver, by_wire = self.driver, self._profile.by_wire
        if self.enabled:
            column = self._profile.steering
            return ActuatorTargets(
                front_from_wheel(column, self.watch.value("steering_command", "shaft_angle")),
                self.watch.value("steering_command", "shaft_rate") * 0.01 / wheel_from_front(column, 0.01),
                throttle_from_duty(by_wire, self.watch.value("throttle_command", "duty")),
                max(
                    brake_from_travel(by_wire, self.watch.value("brake_command", "travel")),
                    driver.brake_ratio,
                ),
                self._sign,
                0.0,
            )
        sprung = self.failed and self._fail_action == "spring_brake"
        return ActuatorTargets(
            truth.steer_rad if driver.steer_rad is None else driver.steer_rad,
            self._profile.limits.steer_rate_radps_max,
            driver.throttle_ratio,
            1.0 if sprung or self.stop_pressed else driver.brake_ratio,
            self._sign if self._direction != NEUTRAL else 1.0,
            0.0,
        )

    @property
    def _sign(self) -> float:
        return {FORWARD: 1.0, REVERSE: -1.0}.get(int(self._direction), 0.0)

    def report(self, now_ns: int, truth: PlantView) -> tuple[CanFrame, ...]:
        """Report frames when they are due, else nothing."""
        if self._next_report_ns is None:
            self._next_report_ns = now_ns
        if now_ns < self._next_report_ns:
            return ()
        self._next_report_ns += REPORT_PERIOD_NS
        known = layouts(SERVO)
        return tuple(
            CanFrame(now_ns, known[name].arbitration_id, known[name].pack(values))
            for name, values in self._values(truth).items()
        )

    def _values(self, truth: PlantView) -> dict[str, dict[str, float]]:
        profile, watch = self._profile, self.watch
        body, by_wire = profile.body, profile.by_wire
        ratio = encoder_ratio(truth.steer_rad, body.wheelbase_m, by_wire.track_width_m)
        return {
            "drive_report": {
                "armed": self.enabled,
                "overridden": self.overridden,
                "timed_out": self._timed_out,
                "fault": self.faulted,
                "homed": self._homed,
                "stop_pressed": self.stop_pressed,
                "direction": self._direction,
                "errors": float(watch.malformed + watch.miscounted + watch.crowded),
            },
            "brake_report": {
                "travel": travel_from_brake(by_wire, truth.brake_ratio),
                "commanded": watch.value("brake_command", "travel"),
            },
            "throttle_report": {
                "duty": duty_from_throttle(by_wire, truth.throttle_ratio),
                "commanded": watch.value("throttle_command", "duty"),
            },
            "steering_report": {
                "shaft_angle": wheel_from_front(profile.steering, truth.steer_rad),
                "commanded": watch.value("steering_command", "shaft_angle"),
            },
            "encoder_report": {"front_left": truth.speed_mps * ratio},
            "battery_report": {"charge": truth.battery_ratio},
        }

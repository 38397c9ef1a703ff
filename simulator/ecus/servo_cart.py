"""A servo drive-by-wire: two servo motors and a throttle voltage, homed after power-on, armed by CAN."""

from simulator.ecus.command_watch import SERVO_PROTOCOL, CommandWatch
from simulator.ecus.module import ActuatorTargets, FailAction, Module
from simulator.vehicle.plant import PlantView
from vehicle_agent.can.dbc import SERVO, layouts
from vehicle_agent.can.servo.commands import (
    FORWARD,
    NEUTRAL,
    REVERSE,
    SERVO_FRAME_GAP_NS,
    brake_from_travel,
    duty_from_throttle,
    throttle_from_duty,
    travel_from_brake,
)
from vehicle_agent.can.servo.reports import encoder_ratio
from vehicle_agent.can.steering_column import front_from_wheel, wheel_from_front
from vehicle_agent.config import Profile
from vehicle_agent.signals import CanFrame

HOMING_NS = 500_000_000
DIRECTION_SPEED_MPS_MAX = 0.3
REST_RATIO = 0.0005


class ServoModule(Module):
    """A rising arm bit arms it once it is homed, if throttle and brake are commanded at rest and there is no
    override, fault or stop button. Arming with the throttle open latches a fault, which a reset clears while
    the module is disarmed.

    Every command needs a counter that follows and a valid check byte. The direction relay switches below
    0.3 m/s.
    """

    def __init__(self, profile: Profile, fail_action: FailAction | None = None) -> None:
        super().__init__(profile, fail_action, CommandWatch(SERVO_FRAME_GAP_NS, protocol=SERVO_PROTOCOL))
        self._direction = float(NEUTRAL)
        self._homed_ns: int | None = None
        self._homed = False

    def receive(self, frame: CanFrame) -> None:
        """One frame from the bus, `stamp_ns` being its arrival."""
        if self.watch.take(frame) != "drive_command":
            return
        if self.watch.value("drive_command", "reset"):
            self.overridden = self.overridden and self.driver.takes_over
            self.start_fault = self.start_fault and self.enabled
        if self.request_enable(bool(self.watch.value("drive_command", "arm"))):
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
        """Check commands, driver and faults; call it before `targets`."""
        self._homed_ns = now_ns + HOMING_NS if self._homed_ns is None else self._homed_ns
        self._homed = now_ns >= self._homed_ns
        self.check_inputs(now_ns)
        if self.enabled and abs(truth.speed_mps) < DIRECTION_SPEED_MPS_MAX:
            self._direction = self.watch.value("drive_command", "direction")

    def commanded(self) -> ActuatorTargets:
        watch, by_wire, column = self.watch, self.profile.by_wire, self.profile.steering
        return ActuatorTargets(
            front_from_wheel(column, watch.value("steering_command", "shaft_angle")),
            watch.value("steering_command", "shaft_rate") * 0.01 / wheel_from_front(column, 0.01),
            throttle_from_duty(by_wire, watch.value("throttle_command", "duty")),
            max(brake_from_travel(by_wire, watch.value("brake_command", "travel")), self.driver.brake_ratio),
            self._sign,
            0.0,
        )

    def gear(self) -> tuple[float, float]:
        return self._sign if self._direction != NEUTRAL else 1.0, 0.0

    @property
    def _sign(self) -> float:
        return {FORWARD: 1.0, REVERSE: -1.0}.get(int(self._direction), 0.0)

    def reports(self, now_ns: int, truth: PlantView) -> tuple[CanFrame, ...]:
        known = layouts(SERVO)
        return tuple(
            CanFrame(now_ns, known[name].arbitration_id, known[name].pack(values))
            for name, values in self._values(truth).items()
        )

    def _values(self, truth: PlantView) -> dict[str, dict[str, float]]:
        profile, watch = self.profile, self.watch
        body, by_wire = profile.body, profile.by_wire
        ratio = encoder_ratio(truth.steer_rad, body.wheelbase_m, by_wire.track_width_m)
        return {
            "drive_report": {
                "armed": self.enabled,
                "overridden": self.overridden,
                "timed_out": self.timed_out,
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
            "encoder_report": {"front_left": truth.speed_mps * truth.wheel_ratio * ratio},
            "battery_report": {"charge": truth.battery_ratio},
        }

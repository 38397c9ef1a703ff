"""The can room for a servo drive-by-wire (NUS, section II): frames <-> VehicleMotion / Actuation.

Two servo motors for steering and brake and a PWM voltage for the throttle; a wheel encoder at the left front
wheel. Steering and brake are inferred from the motors' encoders.
"""

import math

import msgspec

from vehicle_agent.can.faults import Severity, since
from vehicle_agent.can.gate_report import GateWord, heard_gate
from vehicle_agent.can.handshake import Handshake, advance
from vehicle_agent.can.servo_frames import (
    SERVO_COUNTER_STEPS,
    ServoEncoder,
    brake_from_travel,
    throttle_from_duty,
)
from vehicle_agent.can.servo_reports import ServoReports, encoder_ratio, heard
from vehicle_agent.can.steering_column import front_from_wheel, wheel_from_front
from vehicle_agent.config import Body, ByWire, Limits, Profile, SteeringColumn
from vehicle_agent.signals import Actuation, CanFrame, Fault, VehicleMotion

REPORT_LOST_NS = 150_000_000
BOOT_GRACE_NS = 1_000_000_000
REFUSALS_MAX = 3
MALFORMED_SHOWN_NS = 1_000_000_000


class ServoState(msgspec.Struct, frozen=True):
    """boot_ns: stamp of the first tick; 0 before it."""

    reports: ServoReports = ServoReports()
    handshake: Handshake = Handshake()
    counter: int = 0
    boot_ns: int = 0
    overridden: bool = False
    faults: tuple[Fault, ...] = ()
    gate: GateWord = GateWord()


class ServoCart(msgspec.Struct, frozen=True):
    """What the codec must know of the vehicle; `steering` is servo shaft over front-wheel angle."""

    steering: SteeringColumn = SteeringColumn()
    by_wire: ByWire = ByWire()
    body: Body = Body()
    limits: Limits = Limits()

    def initial(self) -> ServoState:
        return ServoState()

    def decode(
        self, state: ServoState, frames: tuple[CanFrame, ...], now_ns: int
    ) -> tuple[VehicleMotion, ServoState]:
        """The vehicle's motion after this tick's reports; the speed is the rear axle's."""
        boot_ns = state.boot_ns or now_ns
        reports = heard(state.reports, frames)
        armed = _armed(reports, now_ns)
        overridden = bool(reports.overridden) or (state.overridden and not armed)
        gate = heard_gate(state.gate, frames)
        active = _active(reports, state.handshake, boot_ns, now_ns) + gate.active(now_ns)
        faults = since(active, state.faults, now_ns)
        steer_rad = front_from_wheel(self.steering, reports.shaft_rad)
        ratio = encoder_ratio(steer_rad, self.body.wheelbase_m, self.by_wire.track_width_m)
        motion = VehicleMotion(
            stamp_ns=reports.encoder_ns,
            speed_mps=reports.encoder_mps / ratio,
            steer_rad=steer_rad,
            throttle_ratio=throttle_from_duty(self.by_wire, reports.duty),
            brake_ratio=brake_from_travel(self.by_wire, reports.travel),
            enabled=armed,
            overridden=overridden,
            ready=bool(reports.homed) and not reports.stop_pressed,
            battery_ratio=reports.charge_ratio,
            faults=faults,
        )
        return motion, ServoState(reports, state.handshake, state.counter, boot_ns, overridden, faults, gate)

    def encode(
        self, state: ServoState, act: Actuation, now_ns: int
    ) -> tuple[tuple[CanFrame, ...], ServoState]:
        """All command frames of this tick, from this tick's actuation alone.

        FrameError when a command is not a finite number: frames end and the gate brakes.
        """
        reports = state.reports
        armed = _armed(reports, now_ns)
        # Until the servos have found their end stops nobody is asked: a refusal would look like a fault.
        wanted = act.enable and (bool(reports.homed) or state.handshake.enables)
        shake = advance(state.handshake, wanted, armed, state.overridden, now_ns)
        clear_faults = bool(reports.fault) and not shake.enables
        encoder = ServoEncoder(self.steering, self.by_wire, self._shaft_rate_radps())
        frames = encoder.frames(act, shake, state.counter, clear_faults, now_ns)
        counter = (state.counter + 1) % SERVO_COUNTER_STEPS
        return frames, ServoState(
            reports, shake, counter, state.boot_ns, state.overridden, state.faults, state.gate
        )

    def _shaft_rate_radps(self) -> float:
        lock_rad = math.atan(self.body.wheelbase_m / self.body.turn_radius_m_min)
        return self.limits.steer_rate_radps_max * wheel_from_front(self.steering, lock_rad) / lock_rad


def servo_cart(profile: Profile) -> ServoCart:
    """The can room of a profile."""
    return ServoCart(profile.steering, profile.by_wire, profile.body, profile.limits)


def _armed(reports: ServoReports, now_ns: int) -> bool:
    return bool(reports.armed) and now_ns - reports.drive_ns <= REPORT_LOST_NS


def _active(reports: ServoReports, shake: Handshake, boot_ns: int, now_ns: int) -> list[tuple[str, Severity]]:
    """(code, severity) of everything wrong now, in a fixed order; codes as for other by-wires."""
    driving = shake.phase == "on"
    faults: list[tuple[str, Severity]] = []
    if now_ns - boot_ns > BOOT_GRACE_NS:
        for name, stamp_ns in reports.stamps_ns():
            if now_ns - stamp_ns > REPORT_LOST_NS:
                faults.append((f"can_{name}_report_lost", "stop"))
    if reports.stop_pressed:
        faults.append(("emergency_stop_pressed", "stop"))
    if reports.fault:
        faults.append(("bywire_fault", "stop"))
    if reports.timed_out:
        faults.append(("bywire_timeout", "stop" if driving else "info"))
    if driving and not reports.armed and not reports.overridden:
        faults.append(("bywire_lost", "stop"))
    if shake.refusals >= REFUSALS_MAX:
        faults.append(("bywire_refuses_enable", "stop"))
    if reports.malformed_ns and now_ns - reports.malformed_ns <= MALFORMED_SHOWN_NS:
        faults.append(("can_frame_malformed", "warning"))
    return faults

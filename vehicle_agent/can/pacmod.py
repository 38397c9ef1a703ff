"""The can room for a PACMod3-class by-wire module: frames <-> VehicleMotion / Actuation."""

import math

import msgspec

from vehicle_agent.can.commands import COUNTER_STEPS, CommandEncoder
from vehicle_agent.can.faults import Severity, since
from vehicle_agent.can.gate_report import GateWord, heard_gate
from vehicle_agent.can.handshake import Handshake, advance
from vehicle_agent.can.reports import Reports, heard
from vehicle_agent.can.steering_column import front_from_wheel, wheel_from_front
from vehicle_agent.config import Body, Limits, Profile, SteeringColumn
from vehicle_agent.signals import Actuation, CanFrame, Fault, VehicleMotion

REPORT_LOST_NS = 150_000_000
BOOT_GRACE_NS = 1_000_000_000
REFUSALS_MAX = 3
MALFORMED_SHOWN_NS = 1_000_000_000


class CanState(msgspec.Struct, frozen=True):
    """boot_ns: stamp of the first tick; 0 before it."""

    reports: Reports = Reports()
    handshake: Handshake = Handshake()
    counter: int = 0
    boot_ns: int = 0
    overridden: bool = False
    faults: tuple[Fault, ...] = ()
    gate: GateWord = GateWord()


class Pacmod(msgspec.Struct, frozen=True):
    """What the codec must know of the vehicle."""

    steering: SteeringColumn = SteeringColumn()
    body: Body = Body()
    limits: Limits = Limits()

    def initial(self) -> CanState:
        return CanState()

    def decode(
        self, state: CanState, frames: tuple[CanFrame, ...], now_ns: int
    ) -> tuple[VehicleMotion, CanState]:
        """The vehicle's motion after this tick's reports, front-wheel angle and SI units."""
        boot_ns = state.boot_ns or now_ns
        reports = heard(state.reports, frames)
        enabled = bool(reports.enabled) and now_ns - reports.global_ns <= REPORT_LOST_NS
        overridden = bool(reports.override_active) or (state.overridden and not enabled)
        gate = heard_gate(state.gate, frames)
        active = _active(reports, state.handshake, boot_ns, now_ns) + gate.active(now_ns)
        faults = since(active, state.faults, now_ns)
        motion = VehicleMotion(
            stamp_ns=reports.speed_ns,
            speed_mps=reports.speed_mps,
            steer_rad=front_from_wheel(self.steering, reports.wheel_rad),
            throttle_ratio=reports.throttle_ratio,
            brake_ratio=reports.brake_ratio,
            enabled=enabled,
            overridden=overridden,
            ready=bool(reports.ready) and not reports.disable_all,
            battery_ratio=reports.charge_ratio,
            faults=faults,
        )
        return motion, CanState(reports, state.handshake, state.counter, boot_ns, overridden, faults, gate)

    def encode(self, state: CanState, act: Actuation, now_ns: int) -> tuple[tuple[CanFrame, ...], CanState]:
        """All command frames of this tick, from this tick's actuation alone.

        FrameError when a command is not a finite number: frames end and the gate brakes.
        """
        reports = state.reports
        enabled = bool(reports.enabled) and now_ns - reports.global_ns <= REPORT_LOST_NS
        shake = advance(state.handshake, act.enable, enabled, state.overridden, now_ns)
        # A latched module fault may be cleared only while by-wire is off; the guard keeps its own latch.
        clear_faults = bool(reports.fault_active) and not shake.enables
        encoder = CommandEncoder(self.steering, self._wheel_rate_radps())
        frames = encoder.frames(act, shake, state.counter, clear_faults, now_ns)
        counter = (state.counter + 1) % COUNTER_STEPS
        return frames, CanState(
            reports, shake, counter, state.boot_ns, state.overridden, state.faults, state.gate
        )

    def _wheel_rate_radps(self) -> float:
        lock_rad = math.atan(self.body.wheelbase_m / self.body.turn_radius_m_min)
        return self.limits.steer_rate_radps_max * wheel_from_front(self.steering, lock_rad) / lock_rad


def pacmod(profile: Profile) -> Pacmod:
    """The can room of a profile."""
    return Pacmod(profile.steering, profile.body, profile.limits)


def _active(reports: Reports, shake: Handshake, boot_ns: int, now_ns: int) -> list[tuple[str, Severity]]:
    """(code, severity) of everything wrong now, in a fixed order."""
    driving = shake.phase == "on"
    faults: list[tuple[str, Severity]] = []
    if now_ns - boot_ns > BOOT_GRACE_NS:
        for name, stamp_ns in reports.stamps_ns():
            if now_ns - stamp_ns > REPORT_LOST_NS:
                faults.append((f"can_{name}_report_lost", "stop"))
    if reports.stop_pressed:
        faults.append(("emergency_stop_pressed", "stop"))
    if reports.fault_active or reports.config_fault or reports.disable_all:
        faults.append(("bywire_fault", "stop"))
    if reports.computer_timeout or reports.subsystem_timeout:
        faults.append(("bywire_timeout", "stop" if driving else "info"))
    if driving and not reports.enabled and not reports.override_active:
        faults.append(("bywire_lost", "stop"))
    if shake.refusals >= REFUSALS_MAX:
        faults.append(("bywire_refuses_enable", "stop"))
    if reports.malformed_ns and now_ns - reports.malformed_ns <= MALFORMED_SHOWN_NS:
        faults.append(("can_frame_malformed", "warning"))
    return faults

"""The can room for a PACMod3-class by-wire module: frames <-> VehicleMotion / Actuation."""

import msgspec

from vehicle_agent.can.handshake import advance
from vehicle_agent.can.module_state import CodecState, ModuleStatus, with_faults
from vehicle_agent.can.pacmod.commands import COUNTER_STEPS, HEADLIGHT_CODE, TURN_CODE, CommandEncoder
from vehicle_agent.can.pacmod.consistency import Consistency, check_consistency
from vehicle_agent.can.pacmod.reports import Reports, take_reports
from vehicle_agent.can.steering_column import front_from_wheel, wheel_rate_radps
from vehicle_agent.config import Body, ByWire, Limits, Profile, SteeringColumn
from vehicle_agent.signals import (
    NO_SIGNALS,
    Actuation,
    CanFrame,
    Gear,
    Headlights,
    ReportedGear,
    TurnSignal,
    VehicleMotion,
    VehicleSignals,
)

# In the order of the module's codes.
GEARS: tuple[ReportedGear, ...] = ("park", "reverse", "neutral", "drive", "low")
TURN_SIGNALS: tuple[TurnSignal, ...] = tuple(TURN_CODE)
HEADLIGHTS: tuple[Headlights, ...] = tuple(HEADLIGHT_CODE)


class CanState(CodecState, frozen=True):
    """See `CodecState`. gear: of the newest commands."""

    reports: Reports = Reports()
    consistency: Consistency = Consistency()
    gear: Gear = "park"


class Pacmod(msgspec.Struct, frozen=True):
    """The vehicle's parameters for the codec."""

    steering: SteeringColumn = SteeringColumn()
    body: Body = Body()
    limits: Limits = Limits()
    wheel_radius_m: float = ByWire().wheel_radius_m

    def initial(self) -> CanState:
        return CanState()

    def decode(
        self, state: CanState, frames: tuple[CanFrame, ...], now_ns: int
    ) -> tuple[VehicleMotion, CanState]:
        """The vehicle's motion after this tick's reports."""
        reports = take_reports(state.reports, frames)
        gear = GEARS[int(reports.gear)] if reports.shift_ns else None
        commanded = state.gear if state.handshake.is_on else None
        consistency = check_consistency(
            state.consistency, reports, gear, commanded, self.wheel_radius_m, now_ns
        )
        status = _module_status(reports, consistency, now_ns)
        state = msgspec.structs.replace(state, reports=reports, consistency=consistency)
        state = with_faults(state, status, frames, now_ns)
        motion = VehicleMotion(
            stamp_ns=reports.speed_ns,
            speed_mps=reports.speed_mps,
            steer_rad=front_from_wheel(self.steering, reports.wheel_rad),
            throttle_ratio=reports.throttle_ratio,
            brake_ratio=reports.brake_ratio,
            enabled=status.has_vehicle(now_ns),
            overridden=state.overridden,
            ready=bool(reports.ready) and not reports.disable_all,
            battery_ratio=reports.charge_ratio,
            faults=state.faults,
            yaw_rate_radps=reports.yaw_rate_radps if reports.yaw_valid else None,
            wheels_radps=_wheels(reports),
            gear=gear,
            turn_signal=TURN_SIGNALS[int(reports.turn_signal)] if reports.turn_ns else None,
            horn=bool(reports.horn) if reports.horn_ns else None,
            headlights=HEADLIGHTS[int(reports.headlights)] if reports.headlight_ns else None,
        )
        return motion, state

    def encode(
        self, state: CanState, actuation: Actuation, now_ns: int, signals: VehicleSignals = NO_SIGNALS
    ) -> tuple[tuple[CanFrame, ...], CanState]:
        """All command frames of this tick, from this tick's actuation and signals alone.

        FrameError for a command that is not finite: frames end and the gate brakes.
        """
        status = _module_status(state.reports, state.consistency, now_ns)
        # Driving begins with all subsystems. It ends as soon as the brake is gone; without the steering, the
        # accelerator or the gear by-wire still brakes. It does not begin with a fault, nor before the module
        # has reported that it has none.
        has_vehicle = status.has_vehicle(now_ns)
        enabled = has_vehicle and (state.handshake.is_on or state.reports.subsystems.drives)
        may_begin = state.handshake.phase != "off" or (state.reports.global_ns > 0 and not status.refuses)
        requested = actuation.enable and may_begin
        handshake = advance(state.handshake, requested, enabled, state.overridden, now_ns)
        # A latched module fault is cleared only while by-wire is off; the guard has a latch of its own.
        clear_faults = status.has_fault and not handshake.enables
        encoder = CommandEncoder(self.steering, wheel_rate_radps(self.steering, self.body, self.limits))
        frames = encoder.frames(actuation, handshake, state.counter, clear_faults, now_ns, signals)
        counter = (state.counter + 1) % COUNTER_STEPS
        return frames, msgspec.structs.replace(
            state, handshake=handshake, counter=counter, gear=actuation.gear
        )


def pacmod(profile: Profile) -> Pacmod:
    """The can room of a profile."""
    return Pacmod(profile.steering, profile.body, profile.limits, profile.by_wire.wheel_radius_m)


def _module_status(reports: Reports, consistency: Consistency, now_ns: int) -> ModuleStatus:
    enabled = bool(reports.enabled)
    # The subsystems' own words first; the watchdog repeats some of them.
    found = dict(reports.watchdog.faults(now_ns))
    found |= dict(reports.subsystems.faults(enabled)) | dict(consistency.faults(now_ns))
    return ModuleStatus(
        enabled=bool(reports.enabled) and reports.subsystems.brakes,
        enabled_ns=reports.global_ns,
        overridden=bool(reports.override_active) or reports.subsystems.overridden,
        stop_pressed=bool(reports.stop_pressed),
        faulted=reports.faulted,
        timed_out=reports.timed_out,
        stamps_ns=reports.stamps_ns(),
        malformed_ns=reports.malformed_ns,
        stop_button_faulted=bool(reports.stop_button_fault),
        in_part=bool(reports.enabled) and reports.subsystems.lacks_control(reports.global_ns),
        subsystem_faults=tuple(found.items()),
    )


def _wheels(reports: Reports) -> tuple[float, float, float, float] | None:
    if not reports.wheel_ns:
        return None
    front = (reports.front_left_radps, reports.front_right_radps)
    return (*front, reports.rear_left_radps, reports.rear_right_radps)

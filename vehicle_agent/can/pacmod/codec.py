"""The can room for a PACMod3-class by-wire module: frames <-> VehicleMotion / Actuation."""

import msgspec

from vehicle_agent.can.handshake import advance
from vehicle_agent.can.module_state import CodecState, ModuleStatus, with_faults
from vehicle_agent.can.pacmod.commands import COUNTER_STEPS, CommandEncoder
from vehicle_agent.can.pacmod.reports import Reports, take_reports
from vehicle_agent.can.steering_column import front_from_wheel, wheel_rate_radps
from vehicle_agent.config import Body, Limits, Profile, SteeringColumn
from vehicle_agent.signals import Actuation, CanFrame, VehicleMotion


class CanState(CodecState, frozen=True):
    """See `CodecState`."""

    reports: Reports = Reports()


class Pacmod(msgspec.Struct, frozen=True):
    """The vehicle's parameters for the codec."""

    steering: SteeringColumn = SteeringColumn()
    body: Body = Body()
    limits: Limits = Limits()

    def initial(self) -> CanState:
        return CanState()

    def decode(
        self, state: CanState, frames: tuple[CanFrame, ...], now_ns: int
    ) -> tuple[VehicleMotion, CanState]:
        """The vehicle's motion after this tick's reports."""
        reports = take_reports(state.reports, frames)
        status = _module_status(reports)
        state = with_faults(msgspec.structs.replace(state, reports=reports), status, frames, now_ns)
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
        )
        return motion, state

    def encode(
        self, state: CanState, actuation: Actuation, now_ns: int
    ) -> tuple[tuple[CanFrame, ...], CanState]:
        """All command frames of this tick, from this tick's actuation alone.

        FrameError for a command that is not finite: frames end and the gate brakes.
        """
        has_vehicle = _module_status(state.reports).has_vehicle(now_ns)
        handshake = advance(state.handshake, actuation.enable, has_vehicle, state.overridden, now_ns)
        # A latched module fault is cleared only while by-wire is off; the guard has a latch of its own.
        clear_faults = bool(state.reports.fault_active) and not handshake.enables
        encoder = CommandEncoder(self.steering, wheel_rate_radps(self.steering, self.body, self.limits))
        frames = encoder.frames(actuation, handshake, state.counter, clear_faults, now_ns)
        counter = (state.counter + 1) % COUNTER_STEPS
        return frames, msgspec.structs.replace(state, handshake=handshake, counter=counter)


def pacmod(profile: Profile) -> Pacmod:
    """The can room of a profile."""
    return Pacmod(profile.steering, profile.body, profile.limits)


def _module_status(reports: Reports) -> ModuleStatus:
    return ModuleStatus(
        enabled=bool(reports.enabled),
        enabled_ns=reports.global_ns,
        overridden=bool(reports.override_active),
        stop_pressed=bool(reports.stop_pressed),
        faulted=bool(reports.fault_active or reports.config_fault or reports.disable_all),
        timed_out=bool(reports.computer_timeout or reports.subsystem_timeout),
        stamps_ns=reports.stamps_ns(),
        malformed_ns=reports.malformed_ns,
    )

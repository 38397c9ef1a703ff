"""The can room for a servo drive-by-wire (NUS, section II): frames <-> VehicleMotion / Actuation.

Servo motors on steering and brake, a PWM voltage for the throttle, a wheel encoder at the left front wheel.
Steering and brake are computed from the motors' encoders.
"""

import msgspec

from vehicle_agent.can.handshake import advance
from vehicle_agent.can.module_state import CodecState, ModuleStatus, with_faults
from vehicle_agent.can.servo.commands import (
    SERVO_COUNTER_STEPS,
    ServoEncoder,
    brake_from_travel,
    throttle_from_duty,
)
from vehicle_agent.can.servo.reports import ServoReports, encoder_ratio, take_reports
from vehicle_agent.can.steering_column import front_from_wheel, wheel_rate_radps
from vehicle_agent.config import Body, ByWire, Limits, Profile, SteeringColumn
from vehicle_agent.signals import NO_SIGNALS, Actuation, CanFrame, VehicleMotion, VehicleSignals


class ServoState(CodecState, frozen=True):
    """See `CodecState`."""

    reports: ServoReports = ServoReports()


class ServoCart(msgspec.Struct, frozen=True):
    """The vehicle's parameters for the codec; `steering` is servo shaft over front-wheel angle."""

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
        reports = take_reports(state.reports, frames)
        status = _module_status(reports)
        state = with_faults(msgspec.structs.replace(state, reports=reports), status, frames, now_ns)
        steer_rad = front_from_wheel(self.steering, reports.shaft_rad)
        ratio = encoder_ratio(steer_rad, self.body.wheelbase_m, self.by_wire.track_width_m)
        motion = VehicleMotion(
            stamp_ns=reports.encoder_ns,
            speed_mps=reports.encoder_mps / ratio,
            steer_rad=steer_rad,
            throttle_ratio=throttle_from_duty(self.by_wire, reports.duty),
            brake_ratio=brake_from_travel(self.by_wire, reports.travel),
            enabled=status.has_vehicle(now_ns),
            overridden=state.overridden,
            ready=bool(reports.homed) and not reports.stop_pressed,
            battery_ratio=reports.charge_ratio,
            faults=state.faults,
        )
        return motion, state

    def encode(
        self, state: ServoState, actuation: Actuation, now_ns: int, signals: VehicleSignals = NO_SIGNALS
    ) -> tuple[tuple[CanFrame, ...], ServoState]:
        """All command frames of this tick, from this tick's actuation alone; the cart has no signals by wire.

        FrameError for a command that is not finite: frames end and the gate brakes.
        """
        reports = state.reports
        # No request before the servos have found their end stops: a refusal would look like a fault.
        requested = actuation.enable and (bool(reports.homed) or state.handshake.enables)
        has_vehicle = _module_status(reports).has_vehicle(now_ns)
        handshake = advance(state.handshake, requested, has_vehicle, state.overridden, now_ns)
        clear_faults = bool(reports.fault) and not handshake.enables
        shaft_rate_radps = wheel_rate_radps(self.steering, self.body, self.limits)
        encoder = ServoEncoder(self.steering, self.by_wire, shaft_rate_radps)
        frames = encoder.frames(actuation, handshake, state.counter, clear_faults, now_ns)
        counter = (state.counter + 1) % SERVO_COUNTER_STEPS
        return frames, msgspec.structs.replace(state, handshake=handshake, counter=counter)


def servo_cart(profile: Profile) -> ServoCart:
    """The can room of a profile."""
    return ServoCart(profile.steering, profile.by_wire, profile.body, profile.limits)


def _module_status(reports: ServoReports) -> ModuleStatus:
    return ModuleStatus(
        enabled=bool(reports.armed),
        enabled_ns=reports.drive_ns,
        overridden=bool(reports.overridden),
        stop_pressed=bool(reports.stop_pressed),
        faulted=bool(reports.fault),
        timed_out=bool(reports.timed_out),
        stamps_ns=reports.stamps_ns(),
        malformed_ns=reports.malformed_ns,
    )

"""The can room for a servo drive-by-wire (NUS, section II): frames <-> VehicleMotion / Actuation.

Two servo motors for steering and brake and a PWM voltage for the throttle; a wheel encoder at the left front
wheel. Steering and brake are inferred from the motors' encoders.
"""

import msgspec

from vehicle_agent.can.handshake import advance
from vehicle_agent.can.module_state import CodecState, ModuleStatus, watched
from vehicle_agent.can.servo.commands import (
    SERVO_COUNTER_STEPS,
    ServoEncoder,
    brake_from_travel,
    throttle_from_duty,
)
from vehicle_agent.can.servo.reports import ServoReports, encoder_ratio, heard
from vehicle_agent.can.steering_column import front_from_wheel, wheel_rate_radps
from vehicle_agent.config import Body, ByWire, Limits, Profile, SteeringColumn
from vehicle_agent.signals import Actuation, CanFrame, VehicleMotion


class ServoState(CodecState, frozen=True):
    """See `CodecState`."""

    reports: ServoReports = ServoReports()


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
        reports = heard(state.reports, frames)
        word = _word(reports)
        state = watched(msgspec.structs.replace(state, reports=reports), word, frames, now_ns)
        steer_rad = front_from_wheel(self.steering, reports.shaft_rad)
        ratio = encoder_ratio(steer_rad, self.body.wheelbase_m, self.by_wire.track_width_m)
        motion = VehicleMotion(
            stamp_ns=reports.encoder_ns,
            speed_mps=reports.encoder_mps / ratio,
            steer_rad=steer_rad,
            throttle_ratio=throttle_from_duty(self.by_wire, reports.duty),
            brake_ratio=brake_from_travel(self.by_wire, reports.travel),
            enabled=word.has_vehicle(now_ns),
            overridden=state.overridden,
            ready=bool(reports.homed) and not reports.stop_pressed,
            battery_ratio=reports.charge_ratio,
            faults=state.faults,
        )
        return motion, state

    def encode(
        self, state: ServoState, act: Actuation, now_ns: int
    ) -> tuple[tuple[CanFrame, ...], ServoState]:
        """All command frames of this tick, from this tick's actuation alone.

        FrameError when a command is not a finite number: frames end and the gate brakes.
        """
        reports = state.reports
        # Until the servos have found their end stops nobody is asked: a refusal would look like a fault.
        wanted = act.enable and (bool(reports.homed) or state.handshake.enables)
        has_vehicle = _word(reports).has_vehicle(now_ns)
        shake = advance(state.handshake, wanted, has_vehicle, state.overridden, now_ns)
        clear_faults = bool(reports.fault) and not shake.enables
        shaft_rate_radps = wheel_rate_radps(self.steering, self.body, self.limits)
        encoder = ServoEncoder(self.steering, self.by_wire, shaft_rate_radps)
        frames = encoder.frames(act, shake, state.counter, clear_faults, now_ns)
        counter = (state.counter + 1) % SERVO_COUNTER_STEPS
        return frames, msgspec.structs.replace(state, handshake=shake, counter=counter)


def servo_cart(profile: Profile) -> ServoCart:
    """The can room of a profile."""
    return ServoCart(profile.steering, profile.by_wire, profile.body, profile.limits)


def _word(reports: ServoReports) -> ModuleStatus:
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

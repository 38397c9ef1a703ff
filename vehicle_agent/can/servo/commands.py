"""The four command frames of a tick for a servo drive-by-wire, each counted and checked."""

import msgspec

from vehicle_agent.can.dbc import SERVO, FrameError, MessageLayout, layouts
from vehicle_agent.can.handshake import Handshake
from vehicle_agent.can.steering_column import wheel_from_front
from vehicle_agent.config import ByWire, SteeringColumn
from vehicle_agent.signals import Actuation, CanFrame, Gear

SERVO_FRAME_GAP_NS = 500_000
SERVO_COUNTER_STEPS = 256
SERVO_COMMANDS = ("drive_command", "brake_command", "throttle_command", "steering_command")
NEUTRAL, FORWARD, REVERSE = 0, 1, 2
DIRECTION_CODE: dict[Gear, int] = {"park": NEUTRAL, "neutral": NEUTRAL, "drive": FORWARD, "reverse": REVERSE}
_POLYNOMIAL = 0x1D


def _crc_step(crc: int) -> int:
    for _ in range(8):
        crc = ((crc << 1) ^ _POLYNOMIAL) & 0xFF if crc & 0x80 else crc << 1
    return crc


_TABLE = tuple(_crc_step(byte) for byte in range(256))


def crc8(data: bytes) -> int:
    """CRC-8 SAE J1850: polynomial 0x1D, start and final xor 0xFF."""
    crc = 0xFF
    for byte in data:
        crc = _TABLE[crc ^ byte]
    return crc ^ 0xFF


def checked_frame(layout: MessageLayout, values: dict[str, float], stamp_ns: int) -> CanFrame:
    """The frame with its check byte, which is the last one."""
    body = layout.pack(values)[:-1]
    check = crc8(bytes([layout.arbitration_id & 0xFF]) + body)
    return CanFrame(stamp_ns, layout.arbitration_id, body + bytes([check]))


def unpack_checked(layout: MessageLayout, data: bytes) -> dict[str, float]:
    """A command's values. FrameError for a wrong length or a wrong check byte."""
    values = layout.unpack(data)
    if values["check"] != crc8(bytes([layout.arbitration_id & 0xFF]) + data[:-1]):
        raise FrameError(f"{layout.name}: the check byte does not fit")
    return values


class ServoEncoder(msgspec.Struct, frozen=True):
    """shaft_rate_radps: how fast the steering servo may turn."""

    steering: SteeringColumn
    by_wire: ByWire
    shaft_rate_radps: float

    def frames(
        self, actuation: Actuation, handshake: Handshake, counter: int, clear_faults: bool, now_ns: int
    ) -> tuple[CanFrame, ...]:
        """Frames in sending order, `SERVO_FRAME_GAP_NS` apart; no brake and throttle until by-wire is on.

        FrameError for a command that is not finite.
        """
        is_on = handshake.is_on
        values: tuple[dict[str, float], ...] = (
            {
                "arm": handshake.enables,
                "reset": handshake.clears or clear_faults,
                "direction": DIRECTION_CODE[actuation.gear],
            },
            {"travel": travel_from_brake(self.by_wire, actuation.brake_ratio) if is_on else 0.0},
            {"duty": duty_from_throttle(self.by_wire, actuation.throttle_ratio) if is_on else 0.0},
            {
                "shaft_angle": wheel_from_front(self.steering, actuation.steer_rad),
                "shaft_rate": self.shaft_rate_radps,
            },
        )
        known = layouts(SERVO)
        return tuple(
            checked_frame(known[name], {**values[i], "counter": counter}, now_ns + i * SERVO_FRAME_GAP_NS)
            for i, name in enumerate(SERVO_COMMANDS)
        )


def duty_from_throttle(by_wire: ByWire, throttle_ratio: float) -> float:
    """PWM duty for a throttle of 0..1; 0 for none, otherwise above the dead band."""
    if throttle_ratio <= 0.0:
        return 0.0
    span = by_wire.throttle_duty_max - by_wire.throttle_duty_min
    return by_wire.throttle_duty_min + throttle_ratio * span


def throttle_from_duty(by_wire: ByWire, duty: float) -> float:
    """The inverse of `duty_from_throttle`, 0..1."""
    span = by_wire.throttle_duty_max - by_wire.throttle_duty_min
    return min(max((duty - by_wire.throttle_duty_min) / span, 0.0), 1.0)


def travel_from_brake(by_wire: ByWire, brake_ratio: float) -> float:
    """Servo travel for a brake of 0..1; 0 for none, otherwise beyond the free travel."""
    if brake_ratio <= 0.0:
        return 0.0
    return by_wire.brake_travel_free + brake_ratio * (1.0 - by_wire.brake_travel_free)


def brake_from_travel(by_wire: ByWire, travel: float) -> float:
    """The inverse of `travel_from_brake`, 0..1."""
    return min(max((travel - by_wire.brake_travel_free) / (1.0 - by_wire.brake_travel_free), 0.0), 1.0)

"""The nine command frames of a tick."""

import msgspec

from vehicle_agent.can.dbc import layouts
from vehicle_agent.can.handshake import Handshake
from vehicle_agent.can.steering_column import wheel_from_front
from vehicle_agent.config import SteeringColumn
from vehicle_agent.signals import (
    NO_SIGNALS,
    Actuation,
    CanFrame,
    Gear,
    Headlights,
    TurnSignal,
    VehicleSignals,
)

FRAME_GAP_NS = 500_000
COUNTER_STEPS = 16
GEAR_CODE: dict[Gear, int] = {"park": 0, "reverse": 1, "neutral": 2, "drive": 3}
TURN_CODE: dict[TurnSignal, int] = {"right": 0, "none": 1, "left": 2, "hazard": 3}
HEADLIGHT_CODE: dict[Headlights, int] = {"off": 0, "low": 1, "high": 2}
COMMANDS = (
    "global_command",
    "supervisory_command",
    "accelerator_command",
    "brake_command",
    "shift_command",
    "steering_command",
    "turn_command",
    "horn_command",
    "headlight_command",
)
# Commands without which by-wire ends; the others are for people outside.
DRIVING_COMMANDS = COMMANDS[:6]


class CommandEncoder(msgspec.Struct, frozen=True):
    """wheel_rate_radps: how fast the module may turn the steering wheel."""

    steering: SteeringColumn
    wheel_rate_radps: float

    def frames(
        self,
        actuation: Actuation,
        handshake: Handshake,
        counter: int,
        clear_faults: bool,
        now_ns: int,
        signals: VehicleSignals = NO_SIGNALS,
    ) -> tuple[CanFrame, ...]:
        """Frames in sending order; `stamp_ns` is each frame's sending time, `FRAME_GAP_NS` apart.

        Pedals are zero until by-wire is on. FrameError for a command that is not finite.
        """
        count = {"counter": counter, "complement": COUNTER_STEPS - 1 - counter}
        enable = {"enable": handshake.enables}
        is_on = handshake.is_on
        values: tuple[dict[str, float], ...] = (
            {"clear_faults": clear_faults, "clear_overrides": handshake.clears, **count},
            {**enable, **count},
            {**enable, "position": actuation.throttle_ratio if is_on else 0.0},
            {**enable, "position": actuation.brake_ratio if is_on else 0.0},
            {**enable, "gear": GEAR_CODE[actuation.gear]},
            {
                **enable,
                "wheel_angle": wheel_from_front(self.steering, actuation.steer_rad),
                "wheel_rate": self.wheel_rate_radps,
            },
            {**enable, "turn_signal": TURN_CODE[signals.turn]},
            {**enable, "horn": signals.horn and is_on},
            {**enable, "headlights": HEADLIGHT_CODE[signals.headlights]},
        )
        known = layouts()
        return tuple(
            CanFrame(now_ns + i * FRAME_GAP_NS, known[name].arbitration_id, known[name].pack(values[i]))
            for i, name in enumerate(COMMANDS)
        )

"""The gate's interface to a servo drive-by-wire: checks of a command set, and braking frames."""

import msgspec

from vehicle_agent.can.braking import CommandedActuation, CommandSetError, unpacked_set
from vehicle_agent.can.dbc import SERVO, layouts
from vehicle_agent.can.servo.commands import (
    SERVO_COMMANDS,
    SERVO_COUNTER_STEPS,
    SERVO_FRAME_GAP_NS,
    brake_from_travel,
    checked_frame,
    throttle_from_duty,
    travel_from_brake,
    unpack_checked,
)
from vehicle_agent.can.steering_column import front_from_wheel
from vehicle_agent.config import ByWire, SteeringColumn
from vehicle_agent.signals import CanFrame


class ServoBraking(msgspec.Struct, frozen=True):
    """See `vehicle_agent.can.braking.ByWireBraking`."""

    steering: SteeringColumn = SteeringColumn()
    by_wire: ByWire = ByWire()
    frame_gap_ns: int = SERVO_FRAME_GAP_NS
    counter_steps: int = SERVO_COUNTER_STEPS

    def command_ids(self) -> frozenset[int]:
        return frozenset(layouts(SERVO)[name].arbitration_id for name in SERVO_COMMANDS)

    def commanded(self, frames: tuple[CanFrame, ...]) -> CommandedActuation:
        values = unpacked_set(frames, SERVO_COMMANDS, layouts(SERVO), unpack_checked)
        counters = {int(value["counter"]) for value in values.values()}
        if len(counters) != 1:
            raise CommandSetError("the frames' counters differ")
        if values["throttle_command"]["duty"] > 0.0 and values["brake_command"]["travel"] > 0.0:
            raise CommandSetError("throttle and brake pressed together")
        return CommandedActuation(
            counters.pop(),
            bool(values["drive_command"]["arm"]),
            front_from_wheel(self.steering, values["steering_command"]["shaft_angle"]),
            throttle_from_duty(self.by_wire, values["throttle_command"]["duty"]),
            brake_from_travel(self.by_wire, values["brake_command"]["travel"]),
        )

    def braking_frames(
        self, last: tuple[CanFrame, ...], steps: int, now_ns: int, brake_ratio: float
    ) -> tuple[CanFrame, ...]:
        known = layouts(SERVO)
        armed = bool(known["drive_command"].unpack(last[0].data)["arm"])
        frames = []
        for i, (name, frame) in enumerate(zip(SERVO_COMMANDS, last, strict=True)):
            values = known[name].unpack(frame.data)
            values["counter"] = (int(values["counter"]) + steps) % SERVO_COUNTER_STEPS
            if name == "drive_command":
                values["reset"] = 0.0
            if name == "throttle_command":
                values["duty"] = 0.0
            if name == "brake_command":
                values["travel"] = travel_from_brake(self.by_wire, brake_ratio) if armed else 0.0
            frames.append(checked_frame(known[name], values, now_ns + i * SERVO_FRAME_GAP_NS))
        return tuple(frames)

"""The gate's interface to a PACMod3-class module: checks of a command set, and braking frames."""

import msgspec

from vehicle_agent.can.braking import CommandedActuation, CommandSetError, Values, unpacked_set
from vehicle_agent.can.dbc import MessageLayout, layouts
from vehicle_agent.can.pacmod.commands import COMMANDS, COUNTER_STEPS, FRAME_GAP_NS, TURN_CODE
from vehicle_agent.can.steering_column import front_from_wheel
from vehicle_agent.config import SteeringColumn
from vehicle_agent.signals import CanFrame


class PacmodBraking(msgspec.Struct, frozen=True):
    """See `vehicle_agent.can.braking.ByWireBraking`."""

    steering: SteeringColumn = SteeringColumn()
    frame_gap_ns: int = FRAME_GAP_NS
    counter_steps: int = COUNTER_STEPS

    def command_ids(self) -> frozenset[int]:
        return frozenset(layouts()[name].arbitration_id for name in COMMANDS)

    def commanded(self, frames: tuple[CanFrame, ...]) -> CommandedActuation:
        """The actuation of the nine commands in order.

        Counters, complements and enable bits must match; pedals are within 0..1 and never both pressed.
        """
        values = unpacked_set(frames, COMMANDS, layouts(), MessageLayout.unpack)
        throttle_ratio = values["accelerator_command"]["position"]
        brake_ratio = values["brake_command"]["position"]
        if throttle_ratio > 0.0 and brake_ratio > 0.0:
            raise CommandSetError("accelerator and brake pressed together")
        if max(throttle_ratio, brake_ratio) > 1.0:
            raise CommandSetError("a pedal beyond its end")
        return CommandedActuation(
            _counter(values),
            _enable(values),
            front_from_wheel(self.steering, values["steering_command"]["wheel_angle"]),
            throttle_ratio,
            brake_ratio,
        )

    def braking_frames(
        self, last: tuple[CanFrame, ...], steps: int, now_ns: int, brake_ratio: float
    ) -> tuple[CanFrame, ...]:
        known = layouts()
        frames = []
        for i, (name, frame) in enumerate(zip(COMMANDS, last, strict=True)):
            values = known[name].unpack(frame.data)
            if "counter" in values:
                counter = (int(values["counter"]) + steps) % COUNTER_STEPS
                values |= {"counter": counter, "complement": COUNTER_STEPS - 1 - counter}
            if name == "global_command":
                values |= {"clear_faults": 0.0, "clear_overrides": 0.0}
            if name == "accelerator_command":
                values["position"] = 0.0
            if name == "brake_command":
                values["position"] = brake_ratio if values["enable"] else 0.0
            if name == "turn_command":
                # Nobody steers by a plan any more; traffic behind must know.
                values["turn_signal"] = TURN_CODE["hazard"] if values["enable"] else TURN_CODE["none"]
            if name == "horn_command":
                values["horn"] = 0.0
            frames.append(CanFrame(now_ns + i * FRAME_GAP_NS, frame.arbitration_id, known[name].pack(values)))
        return tuple(frames)


def _counter(values: Values) -> int:
    """The counter of the two counted frames, which must match its complement."""
    counts = {(int(values[name]["counter"]), int(values[name]["complement"])) for name in COMMANDS[:2]}
    counter, complement = counts.pop()
    if counts or counter + complement != COUNTER_STEPS - 1:
        raise CommandSetError("counters and complements do not match")
    return counter


def _enable(values: Values) -> bool:
    enables = {bool(values[name]["enable"]) for name in COMMANDS[1:]}
    if len(enables) != 1:
        raise CommandSetError("the frames' enable bits differ")
    return enables.pop()

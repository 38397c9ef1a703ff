"""What the gate knows of a servo drive-by-wire: when a set of commands is sound, and how to brake with it."""

from vehicle_agent.can.braking import CommandSetError
from vehicle_agent.can.dbc import SERVO, FrameError, layouts
from vehicle_agent.can.servo_frames import (
    SERVO_COMMANDS,
    SERVO_COUNTER_STEPS,
    SERVO_FRAME_GAP_NS,
    checked_frame,
    unpack_checked,
)
from vehicle_agent.signals import CanFrame


class ServoBraking:
    """See `vehicle_agent.can.braking.Braking`."""

    frame_gap_ns = SERVO_FRAME_GAP_NS

    def command_ids(self) -> frozenset[int]:
        return frozenset(layouts(SERVO)[name].arbitration_id for name in SERVO_COMMANDS)

    def checked_counter(self, frames: tuple[CanFrame, ...]) -> int:
        known = layouts(SERVO)
        ids = tuple(known[name].arbitration_id for name in SERVO_COMMANDS)
        if tuple(frame.arbitration_id for frame in frames) != ids:
            raise CommandSetError("not the four command frames in order")
        try:
            values = {
                name: unpack_checked(known[name], frame.data)
                for name, frame in zip(SERVO_COMMANDS, frames, strict=True)
            }
        except FrameError as error:
            raise CommandSetError(str(error)) from error
        counters = {int(value["counter"]) for value in values.values()}
        if len(counters) != 1:
            raise CommandSetError("the frames' counters differ")
        if values["throttle_command"]["duty"] > 0.0 and values["brake_command"]["travel"] > 0.0:
            raise CommandSetError("throttle and brake pressed together")
        return counters.pop()

    def braking_frames(self, last: tuple[CanFrame, ...], steps: int, now_ns: int) -> tuple[CanFrame, ...]:
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
                values["travel"] = 1.0 if armed else 0.0
            frames.append(checked_frame(known[name], values, now_ns + i * SERVO_FRAME_GAP_NS))
        return tuple(frames)

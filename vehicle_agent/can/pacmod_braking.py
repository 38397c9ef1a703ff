"""What the gate knows of a PACMod3-class module: when commands are sound, and how to brake with it."""

from vehicle_agent.can.braking import CommandSetError
from vehicle_agent.can.commands import COMMANDS, COUNTER_STEPS, FRAME_GAP_NS
from vehicle_agent.can.dbc import FrameError, layouts
from vehicle_agent.signals import CanFrame


class PacmodBraking:
    """See `vehicle_agent.can.braking.Braking`."""

    frame_gap_ns = FRAME_GAP_NS

    def command_ids(self) -> frozenset[int]:
        return frozenset(layouts()[name].arbitration_id for name in COMMANDS)

    def checked_counter(self, frames: tuple[CanFrame, ...]) -> int:
        return checked_counter(frames)

    def braking_frames(self, last: tuple[CanFrame, ...], steps: int, now_ns: int) -> tuple[CanFrame, ...]:
        return braking_frames(last, steps, now_ns)


def checked_counter(frames: tuple[CanFrame, ...]) -> int:
    """The set's counter.

    Raises CommandSetError unless the frames are the six commands in order, with matching counters and
    complements, accelerator and brake within 0..1 and never both pressed.
    """
    known = layouts()
    if tuple(frame.arbitration_id for frame in frames) != tuple(
        known[name].arbitration_id for name in COMMANDS
    ):
        raise CommandSetError("not the six command frames in order")
    try:
        values = {name: known[name].unpack(frame.data) for name, frame in zip(COMMANDS, frames, strict=True)}
    except FrameError as error:
        raise CommandSetError(str(error)) from error
    counts = {(int(values[name]["counter"]), int(values[name]["complement"])) for name in COMMANDS[:2]}
    counter, complement = counts.pop()
    if counts or counter + complement != COUNTER_STEPS - 1:
        raise CommandSetError("counters and complements do not match")
    accelerator = values["accelerator_command"]["position"]
    brake = values["brake_command"]["position"]
    if accelerator > 0.0 and brake > 0.0:
        raise CommandSetError("accelerator and brake pressed together")
    return counter


def braking_frames(last: tuple[CanFrame, ...], steps: int, now_ns: int) -> tuple[CanFrame, ...]:
    """Full brake, no accelerator, steering and enable bits as they were; the counter `steps` further on.

    last  the last sound set of commands (see `checked_counter`)
    """
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
            values["position"] = 1.0 if values["enable"] else 0.0
        frames.append(CanFrame(now_ns + i * FRAME_GAP_NS, frame.arbitration_id, known[name].pack(values)))
    return tuple(frames)

"""The faults that `benchmarks.drive_by_wire` injects, and the required reaction to each."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from campusloop.scenes.faulted_drive import VEHICLE_ID, FaultedDrive, Sets
from simulator.ecus.bus_faults import flipped
from vehicle_agent.signals import CanFrame

Must = Literal["brake", "go on", "either", "fail action"]
Inject = Callable[[FaultedDrive, np.random.Generator], Callable[[int], None]]


@dataclass(frozen=True, slots=True)
class FaultKind:
    """must: the required reaction; "either" is for a flipped bit, which may or may not have an effect.

    inject   injects the fault into a drive; returns a function to call after each step, with its number
    """

    name: str
    must: Must
    inject: Inject


def catalogue() -> tuple[FaultKind, ...]:
    """All kinds; with the "fail action" kinds no process can brake by wire."""
    return (
        FaultKind("one set lost", "go on", _sets_lost(1, 1)),
        FaultKind("two sets lost", "go on", _sets_lost(2, 2)),
        FaultKind("burst of sets lost", "brake", _sets_lost(3, 25)),
        FaultKind("tick dead", "brake", _tick_dead),
        FaultKind("sets repeated", "brake", _sets_repeated),
        FaultKind("sets late", "brake", _sets_late),
        FaultKind("one set's bit flipped", "either", _set_flipped(1, 1)),
        FaultKind("sets' counters flipped", "brake", _set_flipped(4, 25)),
        FaultKind("one command frame lost on the bus", "go on", _bus_lost(1, 1, "to_module", one_frame=True)),
        FaultKind("commands lost on the bus up to 60 ms", "go on", _bus_lost(1, 3, "to_module")),
        FaultKind("one command's bit flipped on the bus", "either", _bus_flipped("to_module")),
        FaultKind("one round of reports lost", "go on", _bus_lost(1, 2, "to_vehicle")),
        FaultKind("reports lost", "brake", _bus_lost(8, 50, "to_vehicle")),
        FaultKind("one report's bit flipped", "either", _bus_flipped("to_vehicle")),
        FaultKind("steering stuck", "brake", _steering_stuck),
        FaultKind("computer's clock jumps", "brake", _clock_jumps(both=True)),
        FaultKind("tick's clock jumps", "brake", _clock_jumps(both=False)),
        FaultKind("gate dead", "fail action", _gate_dead),
        FaultKind("bus off", "fail action", _bus_off),
    )


def _nothing(_step: int) -> None:
    return


def _sets_lost(least: int, most: int) -> Inject:
    def inject(drive: FaultedDrive, rng: np.random.Generator) -> Callable[[int], None]:
        left = [int(rng.integers(least, most + 1))]

        def set_filter(sets: Sets) -> Sets:
            left[0] -= 1
            return sets if left[0] < 0 else []

        drive.set_filter = set_filter
        return _nothing

    return inject


def _tick_dead(drive: FaultedDrive, rng: np.random.Generator) -> Callable[[int], None]:
    """Dead, and restarted by the supervisor some time later, in its initial state."""
    drive.tick_dead = True
    again = int(rng.integers(10, 100))

    def after(step: int) -> None:
        if step == again:
            drive.boot_tick()

    return after


def _sets_repeated(drive: FaultedDrive, rng: np.random.Generator) -> Callable[[int], None]:
    """The same set repeatedly, with its old stamp or a new one; then the running tick's sets."""
    left, fresh = [int(rng.integers(4, 26))], bool(rng.integers(2))
    repeated: Sets = []

    def set_filter(sets: Sets) -> Sets:
        if not repeated:
            repeated.extend(sets)
            return sets
        left[0] -= 1
        if left[0] < 0:
            return sets
        stamp_ns = drive.now_ns if fresh else repeated[0][0].stamp_ns
        return [tuple(CanFrame(stamp_ns, frame.arbitration_id, frame.data) for frame in repeated[0])]

    drive.set_filter = set_filter
    return _nothing


def _sets_late(drive: FaultedDrive, rng: np.random.Generator) -> Callable[[int], None]:
    """Every set is delayed by some steps from now on, for a second."""
    late, steps = int(rng.integers(3, 16)), [0]
    queue: Sets = []

    def set_filter(sets: Sets) -> Sets:
        steps[0] += 1
        queue.extend(sets)
        if steps[0] > 50:
            ready, queue[:] = list(queue), []
            return ready
        return [queue.pop(0)] if len(queue) > late else []

    drive.set_filter = set_filter
    return _nothing


def _set_flipped(least: int, most: int) -> Inject:
    """One: any bit of any frame. Many: bits of the counted frames' counters, in every set."""

    def inject(drive: FaultedDrive, rng: np.random.Generator) -> Callable[[int], None]:
        left = [int(rng.integers(least, most + 1))]

        def set_filter(sets: Sets) -> Sets:
            left[0] -= 1
            if left[0] < 0:
                return sets
            if most == 1:
                return [_one_flipped(frames, rng) for frames in sets]
            return [(flipped(frames[0], int(rng.integers(8, 16))), *frames[1:]) for frames in sets]

        drive.set_filter = set_filter
        return _nothing

    return inject


def _one_flipped(frames: tuple[CanFrame, ...], rng: np.random.Generator) -> tuple[CanFrame, ...]:
    """The frames with a random bit of a random frame inverted."""
    if not frames:
        return frames
    which = int(rng.integers(len(frames)))
    bad = flipped(frames[which], int(rng.integers(64)))
    return (*frames[:which], bad, *frames[which + 1 :])


def _bus_lost(least: int, most: int, way: str, *, one_frame: bool = False) -> Inject:
    def inject(drive: FaultedDrive, rng: np.random.Generator) -> Callable[[int], None]:
        faults = drive.world.bus_faults(VEHICLE_ID)
        steps = int(rng.integers(least, most + 1))
        which = int(rng.integers(6))

        def filter_frames(frames: tuple[CanFrame, ...]) -> tuple[CanFrame, ...]:
            return tuple(frame for k, frame in enumerate(frames) if one_frame and k != which)

        setattr(faults, f"filter_{way}", filter_frames)

        def after(step: int) -> None:
            if step + 1 == steps:
                setattr(faults, f"filter_{way}", _unchanged)

        return after

    return inject


def _unchanged(frames: tuple[CanFrame, ...]) -> tuple[CanFrame, ...]:
    return frames


def _bus_flipped(way: str) -> Inject:
    """A bit of the next frames, once."""

    def inject(drive: FaultedDrive, rng: np.random.Generator) -> Callable[[int], None]:
        faults = drive.world.bus_faults(VEHICLE_ID)

        def filter_frames(frames: tuple[CanFrame, ...]) -> tuple[CanFrame, ...]:
            if frames:
                setattr(faults, f"filter_{way}", _unchanged)
            return _one_flipped(frames, rng)

        setattr(faults, f"filter_{way}", filter_frames)
        return _nothing

    return inject


def _steering_stuck(drive: FaultedDrive, rng: np.random.Generator) -> Callable[[int], None]:
    drive.world.module(VEHICLE_ID).steering_stuck = True
    return _nothing


def _clock_jumps(*, both: bool) -> Inject:
    """By 0.2 s to 100 s, in either direction; of the tick alone, or of the gate too."""

    def inject(drive: FaultedDrive, rng: np.random.Generator) -> Callable[[int], None]:
        size_s = float(10.0 ** rng.uniform(-0.7, 2.0))
        jump_ns = round(size_s * 1e9) * (1 if rng.integers(2) else -1)
        drive.tick_jump_ns += jump_ns
        drive.gate_jump_ns += jump_ns if both else 0
        return _nothing

    return inject


def _gate_dead(drive: FaultedDrive, rng: np.random.Generator) -> Callable[[int], None]:
    """Dead, and restarted by the supervisor some time later."""
    drive.gate_dead = True
    again = int(rng.integers(10, 150))

    def after(step: int) -> None:
        if step == again:
            drive.restart_gate()

    return after


def _bus_off(drive: FaultedDrive, rng: np.random.Generator) -> Callable[[int], None]:
    faults = drive.world.bus_faults(VEHICLE_ID)
    faults.loses_to_module = faults.loses_to_vehicle = True
    again = int(rng.integers(10, 150))

    def after(step: int) -> None:
        if step == again:
            faults.loses_to_module = faults.loses_to_vehicle = False

    return after

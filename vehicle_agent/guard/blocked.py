"""A vehicle that stands for an obstacle for a minute raises an incident."""

import msgspec

from contract.wire.messages import Blocked
from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.signals import Ego, Path, Task

_FOR_SOMETHING: tuple[SpeedLimitReason, ...] = ("obstacle", "gap")


class BlockedState(msgspec.Struct, frozen=True):
    """since_ns: standing for an obstacle since then, 0 if not; reported: the incident was reported."""

    since_ns: int = 0
    reported: bool = False


def watch_blocked(
    before: BlockedState, ego: Ego, task: Task, path: Path, after_ns: int
) -> tuple[BlockedState, tuple[Blocked, ...]]:
    """One tick: an event after after_ns of standing, and another when the vehicle drives on."""
    stands = ego.speed_mps < 0.1 and task.mode == "drive"
    if stands and path.limited_by in _FOR_SOMETHING:
        since_ns = before.since_ns or ego.stamp_ns
        if before.reported or ego.stamp_ns - since_ns < after_ns:
            return BlockedState(since_ns, before.reported), ()
        return BlockedState(since_ns, True), (_event(since_ns, False, ego, path),)
    if before.reported and stands:
        # Another reason to stand does not mean that the vehicle drives on.
        return before, ()
    if before.reported:
        return BlockedState(), (_event(before.since_ns, True, ego, path),)
    return BlockedState(), ()


def _event(since_ns: int, cleared: bool, ego: Ego, path: Path) -> Blocked:
    return Blocked(since_ns, cleared, path.obstacle_m if path.obstacle_m is not None else 0.0, ego.pose_map)

"""A vehicle that stands for something in its path for a minute is an incident."""

import msgspec

from contract.wire.messages import Blocked
from vehicle_agent.signals import Ego, Path, Task

_FOR_SOMETHING = ("obstacle", "gap")


class BlockedState(msgspec.Struct, frozen=True):
    """since_ns: standing for an obstacle since, 0 if not; told: the incident has been reported."""

    since_ns: int = 0
    told: bool = False


def watched(
    before: BlockedState, ego: Ego, task: Task, path: Path, after_ns: int
) -> tuple[BlockedState, tuple[Blocked, ...]]:
    """One tick; one event when a minute is over and one when the vehicle goes on."""
    stands = ego.speed_mps < 0.1 and task.mode == "drive"
    if stands and path.limited_by in _FOR_SOMETHING:
        since_ns = before.since_ns or ego.stamp_ns
        if before.told or ego.stamp_ns - since_ns < after_ns:
            return BlockedState(since_ns, before.told), ()
        return BlockedState(since_ns, True), (_event(since_ns, False, ego, path),)
    if before.told and stands:
        # Still where it was: another reason to stand does not mean that it goes on.
        return before, ()
    if before.told:
        return BlockedState(), (_event(before.since_ns, True, ego, path),)
    return BlockedState(), ()


def _event(since_ns: int, cleared: bool, ego: Ego, path: Path) -> Blocked:
    return Blocked(since_ns, cleared, path.obstacle_m if path.obstacle_m is not None else 0.0, ego.pose_map)

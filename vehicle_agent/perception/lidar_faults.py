"""What the lidars' driver says of single lidars, as faults that name them."""

from typing import Literal

from contract.wire.reasons import FaultCode
from vehicle_agent.signals import Fault, LidarConditions, PerceptionInput

# The driver speaks once a second; an older word says nothing.
CONDITIONS_AGE_NS_MAX = 5_000_000_000
# What fits into a fault's detail on the wire.
DETAIL_MAX = 80
NO_CONDITIONS = LidarConditions(0)

_CODES: tuple[tuple[Literal["silent", "unusable", "moved"], FaultCode], ...] = (
    ("silent", "lidar_silent"), ("unusable", "lidar_unusable"), ("moved", "lidar_moved"),
)  # fmt: skip


def newest_conditions(known: LidarConditions, percepts: tuple[PerceptionInput, ...]) -> LidarConditions:
    """The newest word of the driver; the same object where there is no newer one."""
    newer = [one for one in percepts if isinstance(one, LidarConditions) and one.stamp_ns > known.stamp_ns]
    return max(newer, key=lambda one: one.stamp_ns, default=known)


def lidar_faults(conditions: LidarConditions, now_ns: int) -> tuple[Fault, ...]:
    """Warnings with the lidars' names; the guard makes a stop of `lidar_blind` where a scan is empty."""
    if not conditions.lidars or now_ns - conditions.stamp_ns > CONDITIONS_AGE_NS_MAX:
        return ()
    since_ns = conditions.stamp_ns
    found = []
    for state, code in _CODES:
        names = [one.name for one in conditions.lidars if one.state == state]
        if names:
            found.append(Fault(code, "warning", since_ns, _joined(names)))
    needed = [one.name for one in conditions.lidars if one.is_required and one.state != "moved"]
    if needed:
        found.append(Fault("lidar_blind", "warning", since_ns, _joined(needed)))
    return tuple(found)


def _joined(names: list[str]) -> str:
    text = ", ".join(sorted(names))
    return text if len(text) <= DETAIL_MAX else text[: DETAIL_MAX - 1] + "…"

"""How the vehicle yields to people, with hysteresis for texts and announcements.

Planning may change its reason ten times a second; the texts must not.
"""

import msgspec

from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.signals import GuardStatus, Path, Task

# `Path.limited_by` of the stacks when a road user or an obstacle holds the vehicle back.
YIELDS: frozenset[SpeedLimitReason] = frozenset(
    {"obstacle", "blocked", "footprint", "yielding", "crossing", "crossing_traffic"}
)
PASSES: frozenset[SpeedLimitReason] = frozenset({"passing", "pedestrian_clearance"})
# A vehicle slower than this stands.
STANDS_MPS = 0.05


class YieldingState(msgspec.Struct, frozen=True):
    """Stamps of the vehicle clock; 0 if it is not the case.

    yields_ns, passes_ns  when the vehicle last yielded, when it last passed people
    stood_ns              since when it stands for a road user
    passing_ns            since when it passes people
    """

    yields_ns: int = 0
    passes_ns: int = 0
    stood_ns: int = 0
    passing_ns: int = 0

    @property
    def yields(self) -> bool:
        """The vehicle slows or stands for a road user or an obstacle."""
        return self.yields_ns > 0

    @property
    def stands(self) -> bool:
        return self.stood_ns > 0

    @property
    def passes(self) -> bool:
        """The vehicle slowly passes people beside its way."""
        return self.passes_ns > 0


def update_yielding(
    before: YieldingState, task: Task, path: Path, guard_status: GuardStatus, hysteresis_ns: int, now_ns: int
) -> YieldingState:
    """The state now. Yielding and passing end after hysteresis_ns, or at once when not driving."""
    if guard_status.mode != "autonomous" or task.mode != "drive":
        return YieldingState()
    yields = path.limited_by in YIELDS or bool(path.yields_to)
    yields_ns = now_ns if yields else _recent(before.yields_ns, hysteresis_ns, now_ns)
    is_standing = path.speed_mps <= STANDS_MPS
    stood_ns = (before.stood_ns or (now_ns if yields else 0)) if yields_ns and is_standing else 0
    passes = path.limited_by in PASSES
    passes_ns = now_ns if passes else _recent(before.passes_ns, hysteresis_ns, now_ns)
    passing_ns = (before.passing_ns or now_ns) if passes_ns else 0
    return YieldingState(yields_ns, passes_ns, stood_ns, passing_ns)


def _recent(last_ns: int, hysteresis_ns: int, now_ns: int) -> int:
    return last_ns if last_ns and now_ns - last_ns < hysteresis_ns else 0

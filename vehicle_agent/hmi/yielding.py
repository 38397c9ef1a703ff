"""How the vehicle behaves towards people, held long enough to be put into words.

Planning decides ten times a second and may change its reason each time; what is said about it may not.
"""

import msgspec

from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.signals import GuardStatus, Path, Task

# What the stacks' planners name when somebody or something in the way holds the vehicle back.
YIELDS: frozenset[SpeedLimitReason] = frozenset(
    {"obstacle", "blocked", "footprint", "yielding", "crossing", "crossing_traffic"}
)
PASSES: frozenset[SpeedLimitReason] = frozenset({"passing", "pedestrian_clearance"})
# A vehicle slower than this stands.
STANDS_MPS = 0.05


class YieldingState(msgspec.Struct, frozen=True):
    """Vehicle clock; 0: not so.

    yields_ns, passes_ns  when it was last so
    stood_ns              standing for somebody since
    passing_ns            passing people since
    """

    yields_ns: int = 0
    passes_ns: int = 0
    stood_ns: int = 0
    passing_ns: int = 0

    @property
    def yields(self) -> bool:
        """The vehicle slows or stands for somebody."""
        return self.yields_ns > 0

    @property
    def stands(self) -> bool:
        return self.stood_ns > 0

    @property
    def passes(self) -> bool:
        """The vehicle goes slowly by people who are beside its way."""
        return self.passes_ns > 0


def manner_now(
    before: YieldingState, task: Task, path: Path, verdict: GuardStatus, calm_ns: int, now_ns: int
) -> YieldingState:
    """What is going on; it is over when it has not been so for calm_ns, or at once when not driving."""
    if verdict.mode != "autonomous" or task.mode != "drive":
        return YieldingState()
    yields = path.limited_by in YIELDS or bool(path.yields_to)
    yields_ns = now_ns if yields else _fading(before.yields_ns, calm_ns, now_ns)
    still = path.speed_mps <= STANDS_MPS
    stood_ns = (before.stood_ns or (now_ns if yields else 0)) if yields_ns and still else 0
    passes = path.limited_by in PASSES
    passes_ns = now_ns if passes else _fading(before.passes_ns, calm_ns, now_ns)
    passing_ns = (before.passing_ns or now_ns) if passes_ns else 0
    return YieldingState(yields_ns, passes_ns, stood_ns, passing_ns)


def _fading(last_ns: int, calm_ns: int, now_ns: int) -> int:
    return last_ns if last_ns and now_ns - last_ns < calm_ns else 0

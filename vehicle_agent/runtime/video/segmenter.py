"""Which pictures of a camera are recorded, and where one segment ends and another begins. Pure."""

from enum import Enum
from typing import NamedTuple


class Verdict(Enum):
    """SURPLUS: the camera is faster than what is recorded. LATE: not younger than the picture before."""

    SURPLUS = "surplus"
    LATE = "late"
    ADD = "add"
    BEGIN = "begin"


class SegmentRules(NamedTuple):
    """length_ns  of a segment. They begin at multiples of it, so that those of all cameras begin together.
    gap_ns     a pause of more ends a segment: the camera was away
    period_ns  of the pictures that are recorded
    """

    length_ns: int
    gap_ns: int
    period_ns: int


class SegmentState(NamedTuple):
    """last_ns: of the picture recorded last, None before the first. due_ns: when the next one is due."""

    last_ns: int | None = None
    due_ns: int = 0


def step(state: SegmentState, stamp_ns: int, rules: SegmentRules) -> tuple[Verdict, SegmentState]:
    """What becomes of a picture of this time.

    A clock that goes back by more than a gap is another clock (a driver was started again): a segment begins.
    """
    last_ns = state.last_ns
    if last_ns is None or not -rules.gap_ns <= stamp_ns - last_ns <= rules.gap_ns:
        return Verdict.BEGIN, SegmentState(stamp_ns, stamp_ns + rules.period_ns)
    # Below a millisecond two pictures have one time in the file.
    if stamp_ns - last_ns < 1_000_000:
        return Verdict.LATE, state
    # Half a period of jitter is no second picture.
    if stamp_ns < state.due_ns - rules.period_ns // 2:
        return Verdict.SURPLUS, state
    due_ns = max(state.due_ns + rules.period_ns, stamp_ns + rules.period_ns // 2)
    begins = stamp_ns // rules.length_ns != last_ns // rules.length_ns
    return Verdict.BEGIN if begins else Verdict.ADD, SegmentState(stamp_ns, due_ns)

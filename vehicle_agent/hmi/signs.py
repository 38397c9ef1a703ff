"""Which text stands on the screens, front and rear, and how long: never shorter than can be read."""

import msgspec

from vehicle_agent.hmi import texts
from vehicle_agent.hmi.texts import Words
from vehicle_agent.hmi.yielding import YieldingState
from vehicle_agent.signals import GuardStatus, Path, Task

# Ranks: a warning replaces what ranks lower at once; everything else waits until the text has been read.
TEXT, WARNING, DOORS, STOPPED, BY_HAND = range(5)


class SignText(msgspec.Struct, frozen=True):
    """One situation's texts."""

    front: Words = texts.NOTHING
    rear: Words = texts.NOTHING
    rank: int = TEXT


class DisplayState(msgspec.Struct, frozen=True):
    """sign: on the screens since shown_ns; 0 before the first."""

    sign: SignText = SignText()
    shown_ns: int = 0

    def turned_to(self, wanted: SignText, show_ns: int, now_ns: int) -> "DisplayState":
        """With the wanted sign, when that may replace the one that is there."""
        if wanted == self.sign and self.shown_ns:
            return self
        read = not self.shown_ns or now_ns - self.shown_ns >= show_ns
        warns = wanted.rank >= WARNING and wanted.rank > self.sign.rank
        return DisplayState(wanted, now_ns) if read or warns else self


def sign_for(
    task: Task, path: Path, verdict: GuardStatus, manner: YieldingState, aside: bool, near_m: float
) -> SignText:
    """What there is to read now. aside: somebody should step aside; near_m: before a stop, it is told."""
    if verdict.mode == "manual":
        return SignText(texts.MANUAL, texts.MANUAL, BY_HAND)
    if verdict.mode in ("minimal_risk", "fault"):
        return SignText(texts.SAFETY_STOP, texts.REAR_STANDING, STOPPED)
    if task.doors_open:
        return SignText(texts.DOORS_OPEN, texts.REAR_DOORS, DOORS)
    if verdict.mode == "held":
        return SignText(texts.HELD, texts.REAR_STANDING)
    if task.mode == "dwell":
        return SignText(texts.DOORS_CLOSING, texts.REAR_DOORS, DOORS)
    if aside:
        return SignText(texts.STEP_ASIDE, texts.REAR_YIELDING, WARNING)
    if manner.yields:
        if manner.stands:
            return SignText(texts.AFTER_YOU, texts.REAR_YIELDING)
        return SignText(texts.SLOWING, texts.REAR_SLOWING)
    if manner.passes:
        return SignText(texts.PASSING, texts.REAR_PASSING)
    return _on_the_way(task, path, near_m)


def is_arriving(task: Task, path: Path, near_m: float) -> bool:
    """Near to the stop whose name the task gives, with the road to it granted and nobody on it."""
    return path.stop_m < near_m and not task.waiting_for and task.reason != "stop_occupied"


def _on_the_way(task: Task, path: Path, near_m: float) -> SignText:
    if task.mode != "drive":
        return SignText(texts.RESTING, texts.REAR_STANDING)
    if task.waiting_for and path.stop_m < near_m:
        return SignText(texts.WAITING, texts.REAR_STOPPING)
    if task.reason == "stop_occupied" and path.stop_m < near_m:
        return SignText(texts.WAITING_FOR_STOP, texts.REAR_STOPPING)
    if task.reason == "requested_stop":
        return SignText(texts.REQUESTED, texts.REAR_STOPPING)
    if not (task.stop_name or task.stop_name_en):
        standing = path.speed_mps <= 0.0
        return SignText(texts.RESTING, texts.REAR_STANDING) if standing else SignText(rear=texts.REAR_DRIVING)
    names = (task.stop_name, task.stop_name_en)
    if is_arriving(task, path, near_m):
        return SignText(texts.stopping_at(*names), texts.REAR_STOPPING)
    return SignText(texts.next_stop(*names), texts.REAR_DRIVING)

"""Which text stands on the screens, front and rear, and how long: never shorter than can be read."""

import msgspec

from vehicle_agent.hmi import words
from vehicle_agent.hmi.manner import Manner
from vehicle_agent.hmi.words import Words
from vehicle_agent.signals import STOP_TAKEN, Guarded, Path, Task

# Ranks: a warning replaces what ranks lower at once; everything else waits until the text has been read.
TEXT, WARNING, DOORS, STOPPED, BY_HAND = range(5)


class Sign(msgspec.Struct, frozen=True):
    """One situation's texts."""

    front: Words = words.NOTHING
    rear: Words = words.NOTHING
    rank: int = TEXT


class Board(msgspec.Struct, frozen=True):
    """sign: on the screens since shown_ns; 0 before the first."""

    sign: Sign = Sign()
    shown_ns: int = 0

    def turned_to(self, wanted: Sign, show_ns: int, now_ns: int) -> "Board":
        """With the wanted sign, when that may replace the one that is there."""
        if wanted == self.sign and self.shown_ns:
            return self
        read = not self.shown_ns or now_ns - self.shown_ns >= show_ns
        warns = wanted.rank >= WARNING and wanted.rank > self.sign.rank
        return Board(wanted, now_ns) if read or warns else self


def sign_for(task: Task, path: Path, verdict: Guarded, manner: Manner, aside: bool, near_m: float) -> Sign:
    """What there is to read now. aside: somebody should step aside; near_m: before a stop, it is told."""
    if verdict.mode == "manual":
        return Sign(words.MANUAL, words.MANUAL, BY_HAND)
    if verdict.mode in ("minimal_risk", "fault"):
        return Sign(words.SAFETY_STOP, words.REAR_STANDING, STOPPED)
    if task.doors_open:
        return Sign(words.DOORS_OPEN, words.REAR_DOORS, DOORS)
    if verdict.mode == "held":
        return Sign(words.HELD, words.REAR_STANDING)
    if task.mode == "dwell":
        return Sign(words.DOORS_CLOSING, words.REAR_DOORS, DOORS)
    if aside:
        return Sign(words.STEP_ASIDE, words.REAR_YIELDING, WARNING)
    if manner.yields:
        if manner.stands:
            return Sign(words.AFTER_YOU, words.REAR_YIELDING)
        return Sign(words.SLOWING, words.REAR_SLOWING)
    if manner.passes:
        return Sign(words.PASSING, words.REAR_PASSING)
    return _on_the_way(task, path, near_m)


def is_arriving(task: Task, path: Path, near_m: float) -> bool:
    """Near to the stop whose name the task gives, with the road to it granted and nobody on it."""
    return path.stop_m < near_m and not task.waiting_for and task.reason != STOP_TAKEN


def _on_the_way(task: Task, path: Path, near_m: float) -> Sign:
    if task.mode != "drive":
        return Sign(words.RESTING, words.REAR_STANDING)
    if task.waiting_for and path.stop_m < near_m:
        return Sign(words.WAITING, words.REAR_STOPPING)
    if task.reason == STOP_TAKEN and path.stop_m < near_m:
        return Sign(words.WAITING_FOR_STOP, words.REAR_STOPPING)
    if task.reason == "requested stop":
        return Sign(words.REQUESTED, words.REAR_STOPPING)
    if not (task.stop_name or task.stop_name_en):
        standing = path.speed_mps <= 0.0
        return Sign(words.RESTING, words.REAR_STANDING) if standing else Sign(rear=words.REAR_DRIVING)
    names = (task.stop_name, task.stop_name_en)
    if is_arriving(task, path, near_m):
        return Sign(words.stopping_at(*names), words.REAR_STOPPING)
    return Sign(words.next_stop(*names), words.REAR_DRIVING)

"""The texts on the front and rear screens; each stays long enough to be read."""

import msgspec

from vehicle_agent.hmi import texts
from vehicle_agent.hmi.texts import BilingualText
from vehicle_agent.hmi.yielding import YieldingState
from vehicle_agent.signals import GuardStatus, Path, Task

# Ranks: a warning replaces a text of lower rank at once; every other text waits until it has been read.
TEXT, WARNING, DOORS, STOPPED, MANUAL = range(5)


class SignText(msgspec.Struct, frozen=True):
    """One situation's texts."""

    front: BilingualText = texts.NO_TEXT
    rear: BilingualText = texts.NO_TEXT
    rank: int = TEXT


class DisplayState(msgspec.Struct, frozen=True):
    """sign: on the screens since shown_ns, 0 before the first."""

    sign: SignText = SignText()
    shown_ns: int = 0

    def with_sign(self, wanted: SignText, show_ns: int, now_ns: int) -> "DisplayState":
        """The display with the wanted sign, if it may replace the present one."""
        if wanted == self.sign and self.shown_ns:
            return self
        is_read = not self.shown_ns or now_ns - self.shown_ns >= show_ns
        is_warning = wanted.rank >= WARNING and wanted.rank > self.sign.rank
        return DisplayState(wanted, now_ns) if is_read or is_warning else self


def sign_for(
    task: Task,
    path: Path,
    guard_status: GuardStatus,
    yielding: YieldingState,
    is_blocked: bool,
    near_m: float,
) -> SignText:
    """The sign for the situation.

    is_blocked: a person should step aside; near_m: a stop is announced this far before it
    """
    if guard_status.mode == "manual":
        return SignText(texts.MANUAL, texts.MANUAL, MANUAL)
    if guard_status.mode in ("minimal_risk", "fault"):
        return SignText(texts.SAFETY_STOP, texts.REAR_STANDING, STOPPED)
    if task.doors_open:
        return SignText(texts.DOORS_OPEN, texts.REAR_DOORS, DOORS)
    if guard_status.mode == "held":
        return SignText(texts.HELD, texts.REAR_STANDING)
    if task.mode == "dwell":
        return SignText(texts.DOORS_CLOSING, texts.REAR_DOORS, DOORS)
    if is_blocked:
        return SignText(texts.STEP_ASIDE, texts.REAR_YIELDING, WARNING)
    return _towards_people(yielding) or _on_the_way(task, path, near_m)


def _towards_people(yielding: YieldingState) -> SignText | None:
    """The sign for a person whom the vehicle yields to or passes."""
    if yielding.yields:
        if yielding.stands:
            return SignText(texts.AFTER_YOU, texts.REAR_YIELDING)
        return SignText(texts.SLOWING, texts.REAR_SLOWING)
    return SignText(texts.PASSING, texts.REAR_PASSING) if yielding.passes else None


def is_arriving(task: Task, path: Path, near_m: float) -> bool:
    """The vehicle is near its stop, the road to it is granted, and no vehicle stands on it."""
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

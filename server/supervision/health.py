"""The condition of the standing tasks, for the readiness endpoint and for incidents."""

from dataclasses import dataclass, replace
from datetime import datetime, timedelta

from server.usecases.record.outages import TaskOutage

# A task is late if its cycle takes longer than this beyond twice its period: it hangs.
LATE_S = 30.0
CAUSE_CHARACTERS_MAX = 200


@dataclass(frozen=True, slots=True)
class TaskHealth:
    """One standing task.

    started_at      when the server started it
    period_s        the time between its cycles; None for a task that waits for messages
    last_good_at    when a cycle ended well, None before the first one
    failures        in a row, 0 if the last cycle was good
    failures_total  since the server started
    failing_since   when the first of the failures in a row happened
    cause           of the newest failure
    """

    name: str
    started_at: datetime
    period_s: float | None = None
    last_good_at: datetime | None = None
    failures: int = 0
    failures_total: int = 0
    failing_since: datetime | None = None
    cause: str = ""

    def is_late(self, now: datetime) -> bool:
        """No cycle has ended for much longer than the period."""
        if self.period_s is None:
            return False
        limit = timedelta(seconds=2.0 * self.period_s + LATE_S)
        return now - (self.last_good_at or self.started_at) > limit


def after_success(health: TaskHealth, at: datetime) -> TaskHealth:
    return replace(health, last_good_at=at, failures=0, failing_since=None)


def after_failure(health: TaskHealth, error: BaseException, at: datetime) -> TaskHealth:
    return replace(
        health,
        failures=health.failures + 1,
        failures_total=health.failures_total + 1,
        failing_since=health.failing_since or at,
        cause=cause_of(error),
    )


def past_outage(health: TaskHealth, ended_at: datetime) -> TaskOutage | None:
    """What a good cycle ends; None after fewer than two failures in a row."""
    if health.failures < 2 or health.failing_since is None:
        return None
    return TaskOutage(health.name, health.failing_since, health.cause, ended_at)


def present_outage(health: TaskHealth, now: datetime) -> TaskOutage | None:
    """A task that has failed at least twice in a row, or hangs."""
    if health.failures >= 2 and health.failing_since is not None:
        return TaskOutage(health.name, health.failing_since, health.cause)
    if health.is_late(now):
        return TaskOutage(health.name, health.last_good_at or health.started_at, "its cycle does not end")
    return None


def cause_of(error: BaseException) -> str:
    """The innermost error of a group, in one line: further lines may quote statements and their values."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    lines = str(error).splitlines()
    text = f"{type(error).__name__}: {lines[0]}" if lines else type(error).__name__
    return text[:CAUSE_CHARACTERS_MAX]

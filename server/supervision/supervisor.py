"""Runs the standing tasks: a task that fails is run again after a pause, and no failure goes unseen."""

import asyncio
import random
from collections.abc import Callable, Sequence

import structlog

from server.supervision.health import (
    TaskHealth,
    after_failure,
    after_success,
    past_outage,
    present_outage,
)
from server.supervision.retries import RetryPolicy
from server.supervision.standing_tasks import StandingTask
from server.usecases.ports.clock_and_ids import Clock, Ids
from server.usecases.record.outages import TaskOutage

# Past outages that wait for their incidents; the oldest are forgotten.
OUTAGES_MAX = 100

log = structlog.get_logger("supervision")


def tell_event_loop(text: str, error: BaseException) -> None:
    """In virtual time the run ends with this error."""
    context = {"message": text, "exception": error}
    asyncio.get_running_loop().call_exception_handler(context)


class Supervisor:
    """`start` tasks; `health` says how they are; `close` ends them.

    end  called with a clear text when a task has failed `policy.failures_max` times in a row: the process
         cannot do its work, and whatever runs it shall start it again
    """

    def __init__(
        self,
        clock: Clock,
        ids: Ids,
        policy: RetryPolicy,
        end: Callable[[str, BaseException], None] = tell_event_loop,
    ) -> None:
        self._clock, self._ids, self._policy, self._end = clock, ids, policy, end
        self._health: dict[str, TaskHealth] = {}
        self._tasks: list[asyncio.Task[None]] = []
        self._past_outages: list[TaskOutage] = []

    def start(self, task: StandingTask) -> "asyncio.Task[None]":
        """Run a task until it is cancelled or the supervisor is closed. Task names are unique."""
        assert task.name not in self._health, f"two standing tasks are called {task.name}"
        self._health[task.name] = TaskHealth(task.name, self._clock.now(), task.period_s)
        running = asyncio.get_running_loop().create_task(self._supervise(task), name=task.name)
        running.add_done_callback(self._ended)
        self._tasks.append(running)
        return running

    def health(self) -> tuple[TaskHealth, ...]:
        return tuple(self._health.values())

    def present_outages(self) -> tuple[TaskOutage, ...]:
        """Tasks that fail or hang now."""
        now = self._clock.now()
        outages = (present_outage(health, now) for health in self._health.values())
        return tuple(outage for outage in outages if outage is not None)

    def past_outages(self) -> tuple[TaskOutage, ...]:
        """Outages that are over and not recorded yet."""
        return tuple(self._past_outages)

    def recorded(self, outages: Sequence[TaskOutage]) -> None:
        """These past outages are in the record."""
        self._past_outages = [outage for outage in self._past_outages if outage not in outages]

    async def close(self) -> None:
        for task in self._tasks:
            task.cancel()
        if self._tasks:
            await asyncio.wait(self._tasks)

    def _ended(self, running: "asyncio.Task[None]") -> None:
        """Supervision itself has failed, e.g. to write the log: nothing would repeat the task any more."""
        error = None if running.cancelled() else running.exception()
        if error is not None:
            name = running.get_name()
            self._health[name] = after_failure(self._health[name], error, self._clock.now())
            self._end(f"{name} is not supervised any more: {self._health[name].cause}", error)

    async def _supervise(self, task: StandingTask) -> None:
        cycles = _CyclesOf(self, task.name)
        while True:
            try:
                await task.run(cycles)
            except Exception as error:
                pause_s = self._failed(task.name, error)
                if pause_s is None:
                    return
                await asyncio.sleep(pause_s)

    def succeeded(self, name: str) -> None:
        health, now = self._health[name], self._clock.now()
        if health.failures:
            log.info("task.recovered", task=name, failures=health.failures, since=str(health.failing_since))
            outage = past_outage(health, now)
            if outage is not None:
                self._past_outages = [*self._past_outages, outage][-OUTAGES_MAX:]
        self._health[name] = after_success(health, now)

    def input_failed(self, name: str, error: Exception) -> None:
        health = self._health[name]
        counted = after_failure(health, error, self._clock.now())
        # The task goes on: only the total tells of it.
        self._health[name] = after_success(counted, self._clock.now())
        log.error("task.input_failed", task=name, failures_total=counted.failures_total, exc_info=error)
        if self._policy.failures_max == 1:
            self._end(f"{name} could not handle an input: {counted.cause}", error)

    def _failed(self, name: str, error: Exception) -> float | None:
        """Note a failure. Returns the pause until the next attempt, None if there is none."""
        health = after_failure(self._health[name], error, self._clock.now())
        self._health[name] = health
        if health.failures >= self._policy.failures_max:
            text = f"{name} has failed {health.failures} times since {health.failing_since}: {health.cause}"
            log.critical("task.given_up", task=name, failures=health.failures, exc_info=error)
            self._end(text, error)
            return None
        pause_s = self._policy.pause_s(health.failures, random.Random(self._ids.seed()).random())
        log.error(
            "task.failed", task=name, failures=health.failures, retry_s=round(pause_s, 1), exc_info=error
        )
        return pause_s


class _CyclesOf:
    """The cycles of one task."""

    def __init__(self, supervisor: Supervisor, name: str) -> None:
        self._supervisor, self._name = supervisor, name

    def succeeded(self) -> None:
        self._supervisor.succeeded(self._name)

    def input_failed(self, error: Exception) -> None:
        self._supervisor.input_failed(self._name, error)

"""Standing tasks on a virtual loop: what fails is tried again, counted, and told."""

import asyncio
from datetime import UTC, datetime, timedelta

import pytest
from structlog.testing import capture_logs

from campusloop.virtual.event_loop import VirtualLoop
from server.adapters import SeededIds
from server.bus.in_process import InProcessBus
from server.domain.errors import DomainError, NoVehicleFree, OutcomeUnknown, StoreUnavailable
from server.supervision.health import LATE_S, TaskHealth, cause_of
from server.supervision.retries import FAIL_AT_ONCE, RetryPolicy
from server.supervision.standing_tasks import PeriodicTask, TopicReader
from server.supervision.steps import run_steps
from server.supervision.supervisor import Supervisor

START = datetime(2026, 9, 1, 8, 0, tzinfo=UTC)
STEP_NS = 100_000_000
PLAIN = RetryPolicy(first_s=1.0, pause_s_max=4.0, jitter_ratio=0.0, failures_max=5)


class LoopClock:
    def __init__(self, loop: VirtualLoop) -> None:
        self._loop = loop

    def now(self) -> datetime:
        return START + timedelta(microseconds=self._loop.now_ns // 1000)


class Supervised:
    """A supervisor on a loop of its own, and what it wanted to end the process for."""

    def __init__(self, policy: RetryPolicy = PLAIN) -> None:
        self.loop = VirtualLoop()
        self.ends: list[str] = []
        self.supervisor = Supervisor(LoopClock(self.loop), SeededIds(1), policy, self._end)

    def _end(self, text: str, _error: BaseException) -> None:
        self.ends.append(text)

    def start(self, task: PeriodicTask | TopicReader) -> None:
        async def start() -> None:
            self.supervisor.start(task)

        self.loop.run_now(start())

    def until(self, seconds: float) -> None:
        for now_ns in range(self.loop.now_ns, round(seconds * 1e9) + 1, STEP_NS):
            self.loop.run_until_idle(now_ns)

    def close(self) -> None:
        self.loop.run_now(self.supervisor.close())

    @property
    def health(self) -> TaskHealth:
        (health,) = self.supervisor.health()
        return health


class Work:
    """Notes when it runs, and fails while there are errors left for it."""

    def __init__(self, loop: VirtualLoop, *errors: Exception) -> None:
        self._loop, self._errors = loop, list(errors)
        self.at_s: list[float] = []

    async def __call__(self) -> None:
        self.at_s.append(round(self._loop.time(), 1))
        if self._errors:
            raise self._errors.pop(0)


def test_work_is_done_every_period_and_at_once_when_the_bus_says_so() -> None:
    supervised, bus = Supervised(), InProcessBus()
    work = Work(supervised.loop)
    supervised.start(PeriodicTask("test", work, 1.0, bus, ("campus/x/>",)))
    supervised.until(0.3)
    supervised.loop.run_now(bus.publish("campus/y/dispatch", b""))
    supervised.loop.run_now(bus.publish("campus/x/dispatch", b""))
    supervised.until(2.5)
    assert work.at_s == [0.0, 0.3, 1.3, 2.3]
    supervised.close()


def test_a_refusal_is_logged_and_does_not_count_as_a_failure() -> None:
    supervised = Supervised()
    work = Work(supervised.loop, NoVehicleFree("none"))
    with capture_logs() as logs:
        supervised.start(PeriodicTask("test", work, 1.0))
        supervised.until(1.0)
    assert [(entry["event"], entry["code"]) for entry in logs] == [("task.refused", "no_vehicle_free")]
    assert work.at_s == [0.0, 1.0]
    assert supervised.health.failures_total == 0
    supervised.close()


@pytest.mark.parametrize("error", [StoreUnavailable("locked"), OutcomeUnknown("cut")], ids=lambda e: e.code)
def test_a_failure_of_the_database_is_no_refusal(error: DomainError) -> None:
    supervised = Supervised()
    supervised.start(PeriodicTask("test", Work(supervised.loop, error), 10.0))
    supervised.until(0.5)
    assert supervised.health.failures == 1
    supervised.close()


def test_a_failure_of_the_database_ends_the_steps_of_a_cycle() -> None:
    supervised = Supervised()
    first, second = Work(supervised.loop, StoreUnavailable("locked")), Work(supervised.loop)
    with pytest.raises(StoreUnavailable):
        supervised.loop.run_now(run_steps([first, second]))
    assert (len(first.at_s), second.at_s) == (1, [])
    supervised.close()


def test_a_task_that_failed_runs_again_after_growing_pauses_and_says_that_it_recovered() -> None:
    supervised = Supervised()
    work = Work(supervised.loop, *(OSError("disk full") for _ in range(4)))
    with capture_logs() as logs:
        supervised.start(PeriodicTask("test", work, 10.0))
        supervised.until(12.0)
    assert work.at_s == [0.0, 1.0, 3.0, 7.0, 11.0]
    assert [entry["event"] for entry in logs] == ["task.failed"] * 4 + ["task.recovered"]
    assert isinstance(logs[0]["exc_info"], OSError)
    assert (supervised.health.failures, supervised.health.failures_total) == (0, 4)
    assert supervised.health.last_good_at == START + timedelta(seconds=11)
    assert supervised.ends == []
    supervised.close()


def test_pauses_are_shortened_at_random_but_never_below_their_share() -> None:
    policy = RetryPolicy(first_s=2.0, pause_s_max=10.0, jitter_ratio=0.25)
    assert policy.pause_s(1, 0.0) == 2.0
    assert policy.pause_s(1, 0.5) == 1.75
    assert policy.pause_s(50, 0.999) == pytest.approx(7.5, abs=0.01)
    assert policy.pause_s(5000, 0.0) == 10.0


def test_a_task_that_never_recovers_ends_the_process_with_a_clear_last_word() -> None:
    supervised = Supervised()
    work = Work(supervised.loop, *(OSError("disk full") for _ in range(9)))
    supervised.start(PeriodicTask("dispatcher", work, 10.0))
    supervised.until(60.0)
    assert work.at_s == [0.0, 1.0, 3.0, 7.0, 11.0]
    (last_word,) = supervised.ends
    assert last_word == f"dispatcher has failed 5 times since {START}: OSError: disk full"
    supervised.close()


def test_a_good_cycle_between_failures_starts_the_count_again() -> None:
    supervised = Supervised(RetryPolicy(first_s=1.0, jitter_ratio=0.0, failures_max=2))
    errors = iter([OSError("a"), None, OSError("b"), None, OSError("c"), None])

    async def work() -> None:
        error = next(errors, None)
        if error is not None:
            raise error

    supervised.start(PeriodicTask("test", work, 1.0))
    supervised.until(30.0)
    assert (supervised.health.failures_total, supervised.ends) == (3, [])
    supervised.close()


def test_in_virtual_time_a_failure_ends_the_run_with_its_cause() -> None:
    loop = VirtualLoop()
    supervisor = Supervisor(LoopClock(loop), SeededIds(1), FAIL_AT_ONCE)

    async def start() -> None:
        supervisor.start(PeriodicTask("test", Work(loop, ZeroDivisionError("defect")), 1.0))

    loop.create_task(start())
    with pytest.raises(ZeroDivisionError, match="defect"):
        loop.run_until_idle(0)


def test_one_message_that_cannot_be_taken_stops_no_other_one() -> None:
    supervised, bus, taken = Supervised(), InProcessBus(), []

    def take(_topic: str, payload: bytes) -> None:
        taken.append(int(payload))

    supervised.start(TopicReader("reader", bus, "campus/x/>", take))
    supervised.until(0.1)
    with capture_logs() as logs:
        for payload in (b"1", b"poison", b"2"):
            supervised.loop.run_now(bus.publish("campus/x/live", payload))
        supervised.until(0.2)
    assert taken == [1, 2]
    assert [entry["event"] for entry in logs] == ["task.input_failed"]
    assert (supervised.health.failures, supervised.health.failures_total) == (0, 1)
    supervised.close()


def test_a_reader_whose_subscription_ended_subscribes_again() -> None:
    supervised, bus, taken = Supervised(), InProcessBus(), []
    supervised.start(TopicReader("reader", bus, "campus/x/>", lambda _, payload: taken.append(payload)))
    supervised.until(0.1)
    supervised.loop.run_now(bus.close())
    supervised.until(2.0)
    supervised.loop.run_now(bus.publish("campus/x/live", b"later"))
    supervised.until(2.1)
    assert taken == [b"later"]
    supervised.close()


def test_a_periodic_task_whose_subscription_ended_subscribes_again() -> None:
    supervised, bus = Supervised(), InProcessBus()
    work = Work(supervised.loop)
    supervised.start(PeriodicTask("test", work, 10.0, bus, ("campus/x/>",)))
    supervised.until(0.5)
    supervised.loop.run_now(bus.close())
    supervised.until(2.0)
    supervised.loop.run_now(bus.publish("campus/x/live", b""))
    supervised.until(2.5)
    assert work.at_s == [0.0, 1.5, 2.0]
    assert supervised.health.failures_total == 1
    supervised.close()


def test_a_cycle_that_does_not_end_is_late() -> None:
    supervised = Supervised()

    async def hang() -> None:
        await asyncio.Event().wait()

    supervised.start(PeriodicTask("solver", hang, 1.0))
    supervised.until(LATE_S)
    assert supervised.supervisor.present_outages() == ()
    supervised.until(LATE_S + 3.0)
    (outage,) = supervised.supervisor.present_outages()
    assert (outage.name, outage.since, outage.cause) == ("solver", START, "its cycle does not end")
    supervised.close()


def test_an_outage_is_kept_until_it_is_recorded() -> None:
    supervised = Supervised()
    work = Work(supervised.loop, OSError("disk full"), OSError("disk full"))
    supervised.start(PeriodicTask("test", work, 10.0))
    supervised.until(2.0)
    (present,) = supervised.supervisor.present_outages()
    assert present.since == START
    supervised.until(5.0)
    (past,) = supervised.supervisor.past_outages()
    assert (past.since, past.ended_at) == (START, START + timedelta(seconds=3))
    supervised.supervisor.recorded([past])
    assert supervised.supervisor.past_outages() == ()
    supervised.close()


def test_a_cause_has_one_line_since_others_may_quote_values_of_a_statement() -> None:
    error = ExceptionGroup("steps", [ValueError("database is locked\n[parameters: ('secret',)]")])
    assert cause_of(error) == "ValueError: database is locked"
    assert cause_of(OSError()) == "OSError"
    assert len(cause_of(ValueError("x" * 5000))) == 200


def test_supervision_that_fails_itself_ends_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    def full_disk(*_: object, **__: object) -> None:
        raise OSError("no room for the log")

    supervised = Supervised()
    monkeypatch.setattr("server.supervision.supervisor.log.error", full_disk, raising=False)
    supervised.start(PeriodicTask("dispatcher", Work(supervised.loop, OSError("disk full")), 1.0))
    supervised.until(0.1)
    assert supervised.ends == ["dispatcher is not supervised any more: OSError: no room for the log"]
    assert supervised.health.failures == 2
    supervised.close()

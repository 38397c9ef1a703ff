"""Events of many vehicles in one transaction: what one may not report, or what breaks, harms no other one."""

import asyncio
from collections.abc import Callable, Sequence
from typing import TypeVar

import pytest

from contract.wire.messages import DestinationRequested, DoorsChanged, EventReport, VehicleEvent
from contract.wire.sequence import SequenceGap
from server.domain.errors import SessionFenced, StoreUnavailable
from server.fleet import event_intake
from server.fleet.event_intake import EventIntake
from server.usecases.fleet.events import EventResult, SessionEvent
from server.usecases.ports.unit_of_work import UnitOfWork

T = TypeVar("T")


class NotedLink:
    """A link that notes what it is told."""

    def __init__(self, vehicle_id: str) -> None:
        self.vehicle_id = vehicle_id
        self.session = self
        self.told: list[tuple[object, int]] = []

    def events_stored(self, next_sequences: dict[str, int], handled: int) -> None:
        self.told.append((next_sequences, handled))

    def events_refused(self, code: str, detail: str, handled: int) -> None:
        self.told.append((code, handled))


class NotedCycles:
    def __init__(self) -> None:
        self.failed: list[Exception] = []

    def succeeded(self) -> None:
        return

    def input_failed(self, error: Exception) -> None:
        self.failed.append(error)


class Intake:
    """An intake whose use case is `apply`: how often it was run, and what was noted."""

    def __init__(
        self,
        monkeypatch: pytest.MonkeyPatch,
        apply: Callable[[Sequence[SessionEvent]], tuple[object, ...]],
    ) -> None:
        self.transactions = 0
        self.noted: list[tuple[str, int]] = []
        self.cycles = NotedCycles()
        monkeypatch.setattr(event_intake, "apply_events", lambda _uow, events: apply(events))

        def note(vehicle_id: str, report: EventReport) -> None:
            self.noted.append((vehicle_id, report.sequence))

        self.intake = EventIntake(self, note)  # type: ignore[arg-type]

    async def run(self, work: Callable[[UnitOfWork], T]) -> T:
        self.transactions += 1
        for _ in range(3):
            await asyncio.sleep(0)
        return work(None)  # type: ignore[arg-type]

    def store(self, *events: tuple[NotedLink, int], body: VehicleEvent = DoorsChanged(True, "visit")) -> None:
        async def until_told() -> None:
            task = asyncio.create_task(self.intake.run(self.cycles))
            for link, sequence in events:
                report = EventReport(1, "boot-1", sequence, 5, body)
                self.intake.take(link, report, 7)  # type: ignore[arg-type]
            for _ in range(50):
                await asyncio.sleep(0)
            task.cancel()

        asyncio.run(until_told())


def stored(events: Sequence[SessionEvent]) -> tuple[object, ...]:
    return tuple(EventResult(True, one.event.sequence + 1) for one in events)


def test_events_of_many_vehicles_share_a_transaction_and_each_link_one_answer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    a, b = NotedLink("a"), NotedLink("b")
    intake = Intake(monkeypatch, stored)
    intake.store((a, 0), (b, 0), (a, 1), (a, 2))
    assert intake.transactions == 1
    assert (a.told, b.told) == ([({"boot-1": 3}, 3)], [({"boot-1": 1}, 1)])
    assert intake.noted == [("a", 0), ("b", 0), ("a", 1), ("a", 2)]


def test_events_that_come_while_a_batch_is_stored_wait_for_the_next_one_together(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    link = NotedLink("a")
    batches: list[int] = []

    all_stored = asyncio.Event()

    def apply(events: Sequence[SessionEvent]) -> tuple[object, ...]:
        batches.append(len(events))
        if sum(batches) == 10:
            all_stored.set()
        return stored(events)

    intake = Intake(monkeypatch, apply)
    intake.intake.batch_every_s = 0.05

    async def steadily() -> None:
        task = asyncio.create_task(intake.intake.run(intake.cycles))
        for sequence in range(10):
            report = EventReport(1, "boot-1", sequence, 5, DoorsChanged(True, "visit"))
            intake.intake.take(link, report, 7)  # type: ignore[arg-type]
            # Several come while a batch is stored, and all of them within a fraction of the pause.
            await asyncio.sleep(0)
        await all_stored.wait()
        task.cancel()

    asyncio.run(asyncio.wait_for(steadily(), 10.0))
    assert len(batches) == 2


def test_a_repeat_is_acknowledged_and_not_published(monkeypatch: pytest.MonkeyPatch) -> None:
    link = NotedLink("a")
    intake = Intake(monkeypatch, lambda events: tuple(EventResult(False, 9) for _ in events))
    intake.store((link, 4))
    assert (link.told, intake.noted) == ([({"boot-1": 9}, 1)], [])


def test_a_gap_and_a_fenced_session_are_their_vehicles_own(monkeypatch: pytest.MonkeyPatch) -> None:
    gap, fenced, good = NotedLink("gap"), NotedLink("fenced"), NotedLink("good")
    results = {
        "gap": SequenceGap("boot-1", 2, 5),
        "fenced": SessionFenced("newer"),
        "good": EventResult(True, 1),
    }
    intake = Intake(monkeypatch, lambda events: tuple(results[one.event.vehicle_id] for one in events))
    intake.store((gap, 5), (fenced, 0), (good, 0))
    assert gap.told == [({"boot-1": 2}, 1)]
    assert fenced.told == [("superseded", 1)]
    assert good.told == [({"boot-1": 1}, 1)]
    assert intake.noted == [("good", 0)]


def test_an_event_that_breaks_the_transaction_ends_its_own_session_only(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    broken, good = NotedLink("broken"), NotedLink("good")

    def apply(events: Sequence[SessionEvent]) -> tuple[object, ...]:
        if any(one.event.vehicle_id == "broken" for one in events):
            raise RuntimeError("an effect failed")
        return stored(events)

    intake = Intake(monkeypatch, apply)
    intake.store((good, 0), (broken, 0), (good, 1))
    assert broken.told == [("server_fault", 1)]
    assert good.told == [({"boot-1": 2}, 2)]
    assert [str(error) for error in intake.cycles.failed] == ["an effect failed"]


def test_while_the_database_is_away_nothing_is_acknowledged(monkeypatch: pytest.MonkeyPatch) -> None:
    a, b = NotedLink("a"), NotedLink("b")

    def away(_events: Sequence[SessionEvent]) -> tuple[object, ...]:
        raise StoreUnavailable("full")

    intake = Intake(monkeypatch, away)
    intake.store((a, 0), (b, 0))
    assert (a.told, b.told) == ([("server_fault", 1)], [("server_fault", 1)])
    assert intake.transactions == 1
    assert intake.noted == []


def test_another_destination_is_decided_after_its_event_is_stored_and_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    answered: list[tuple[str, DestinationRequested]] = []
    link, wish = NotedLink("a"), DestinationRequested("ride-1", "library")

    async def answer(_: object, vehicle_id: str, request: DestinationRequested) -> None:
        assert link.told, "the event is acknowledged first"
        answered.append((vehicle_id, request))

    monkeypatch.setattr(event_intake, "answer_destination_request", answer)
    Intake(monkeypatch, stored).store((link, 0), body=wish)
    assert answered == [("a", wish)]
    repeated = Intake(monkeypatch, lambda events: tuple(EventResult(False, 1) for _ in events))
    repeated.store((link, 0), body=wish)
    assert len(answered) == 1


def test_a_destination_that_cannot_be_stored_is_noted_and_events_go_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def fail(*_: object) -> None:
        raise StoreUnavailable("the disk is full")

    monkeypatch.setattr(event_intake, "answer_destination_request", fail)
    link, intake = NotedLink("a"), Intake(monkeypatch, stored)
    intake.store((link, 0), (link, 1), body=DestinationRequested("ride-1", "library"))
    assert [type(error) for error in intake.cycles.failed] == [StoreUnavailable] * 2
    assert link.told == [({"boot-1": 2}, 2)]

"""Stores the events of all links: one transaction for all that have come since the last one.

An event is acknowledged after its commit only. What one vehicle reports harms no other one: if the
transaction of a batch fails, the events of each vehicle are tried in one of their own.
"""

import asyncio
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import structlog

from contract.wire.close_reasons import CloseCode
from contract.wire.messages import DestinationRequested, EventReport
from contract.wire.sequence import SequenceGap
from server.domain.errors import SessionFenced, StoreFailure, VehicleUnknown
from server.domain.record.events import RecordedEvent
from server.fleet.link import Link
from server.supervision.standing_tasks import Cycles
from server.usecases.fleet.cabin_requests import answer_destination_request
from server.usecases.fleet.events import EventResult, SessionEvent, apply_events
from server.usecases.ports.unit_of_work import Transactions

# Under load a batch begins so long after the one before: a commit costs as much as many events. An event that
# comes alone is stored at once.
BATCH_EVERY_S = 0.03
BATCH_MAX = 2_000

log = structlog.get_logger("fleet.events")

Result = EventResult | SequenceGap | SessionFenced | VehicleUnknown


class _Waiting(NamedTuple):
    link: Link
    report: EventReport
    reported: SessionEvent


class EventIntake:
    """A standing task. note_event: called for each event that is stored for the first time.

    batch_every_s  between the beginnings of two batches
    """

    name = "hub.events"
    period_s: float | None = None

    def __init__(self, transactions: Transactions, note_event: Callable[[str, EventReport], None]) -> None:
        self._transactions, self._note_event = transactions, note_event
        self.batch_every_s = BATCH_EVERY_S
        self._waiting: list[_Waiting] = []
        self._arrived = asyncio.Event()

    def take(self, link: Link, report: EventReport, received_ns: int) -> None:
        """The link is told when it is stored, or why it is not."""
        event = RecordedEvent(
            link.session.vehicle_id,
            report.boot_id,
            report.sequence,
            report.stamp_ns,
            received_ns,
            report.body,
        )
        self._waiting.append(_Waiting(link, report, SessionEvent(report.epoch, event)))
        if len(self._waiting) == 1:
            self._arrived.set()

    async def run(self, cycles: Cycles) -> None:
        loop = asyncio.get_running_loop()
        cycles.succeeded()
        while True:
            await self._arrived.wait()
            begun_s = loop.time()
            batch, self._waiting = self._waiting[:BATCH_MAX], self._waiting[BATCH_MAX:]
            is_more = bool(self._waiting)
            if not is_more:
                self._arrived.clear()
            await self._store(batch, cycles)
            if not is_more:
                await asyncio.sleep(max(0.0, begun_s + self.batch_every_s - loop.time()))

    async def _store(self, batch: Sequence[_Waiting], cycles: Cycles) -> None:
        applying = asyncio.ensure_future(self._apply(batch))
        await asyncio.wait((applying,))
        error = applying.exception()
        if error is None:
            self._tell(batch, applying.result())
            await self._answer_requests(batch, applying.result(), cycles)
            return
        vehicles = _by_link(batch)
        if isinstance(error, StoreFailure):
            _refuse(vehicles, error)
        elif len(vehicles) > 1:
            for events in vehicles.values():
                await self._store(events, cycles)
        else:
            assert isinstance(error, Exception)
            _refuse(vehicles, error)
            cycles.input_failed(error)

    async def _answer_requests(
        self, batch: Sequence[_Waiting], results: Sequence[Result], cycles: Cycles
    ) -> None:
        """Decide about new destinations. One that the server cannot store is asked for again on board."""
        for waiting, result in zip(batch, results, strict=True):
            body = waiting.report.body
            if not isinstance(body, DestinationRequested):
                continue
            if isinstance(result, EventResult) and result.is_new:
                try:
                    await answer_destination_request(self._transactions, waiting.link.vehicle_id, body)
                except StoreFailure as error:
                    log.error("destination.not_stored", vehicle_id=waiting.link.vehicle_id, exc_info=error)
                    cycles.input_failed(error)

    async def _apply(self, batch: Sequence[_Waiting]) -> tuple[Result, ...]:
        events = [waiting.reported for waiting in batch]
        return await self._transactions.run(lambda uow: apply_events(uow, events))

    def _tell(self, batch: Sequence[_Waiting], results: Sequence[Result]) -> None:
        """Acknowledge, once for each link and boot, and publish what is new."""
        for waiting, result in zip(batch, results, strict=True):
            if isinstance(result, EventResult) and result.is_new:
                self._note_event(waiting.link.vehicle_id, waiting.report)
        answers: dict[Link, _Answer] = {}
        for waiting, result in zip(batch, results, strict=True):
            answer = answers.get(waiting.link)
            if answer is None:
                answer = answers[waiting.link] = _Answer({})
            answer.add(waiting.report.boot_id, result)
        for link, answer in answers.items():
            answer.tell(link)


@dataclass(slots=True)
class _Answer:
    """What one link is told after a batch."""

    next_sequences: dict[str, int]
    handled: int = 0
    refusal: SessionFenced | VehicleUnknown | None = None

    def add(self, boot_id: str, result: Result) -> None:
        self.handled += 1
        if isinstance(result, EventResult):
            self.next_sequences[boot_id] = result.next_sequence
        elif isinstance(result, SequenceGap):
            self.next_sequences[boot_id] = result.expected
        else:
            self.refusal = result

    def tell(self, link: Link) -> None:
        if self.refusal is None:
            link.events_stored(self.next_sequences, self.handled)
        else:
            is_fenced = isinstance(self.refusal, SessionFenced)
            code: CloseCode = "superseded" if is_fenced else "key_unknown"
            link.events_refused(code, self.refusal.detail, self.handled)


def _refuse(vehicles: Mapping[Link, Sequence[_Waiting]], error: Exception) -> None:
    """These events could not be stored; the vehicles keep them and dial again."""
    log.error("events.not_stored", vehicles=len(vehicles), exc_info=error)
    for link, events in vehicles.items():
        link.events_refused("server_fault", "the server failed to store an event", len(events))


def _by_link(batch: Sequence[_Waiting]) -> dict[Link, list[_Waiting]]:
    found: dict[Link, list[_Waiting]] = {}
    for waiting in batch:
        found.setdefault(waiting.link, []).append(waiting)
    return found

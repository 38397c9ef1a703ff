"""Webhooks are delivered to a real receiver, in order and at least once, on SQLite and on PostgreSQL."""

import asyncio
import json
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from datetime import timedelta

import pytest
from sqlalchemy import Engine

from campusloop_sdk import verify_webhook
from server.addresses import LOOPBACK
from server.domain.record.incidents import IncidentKind
from server.domain.record.webhooks import PAUSES_S, Webhook
from server.domain.rides.ticket_keys import TicketKeys
from server.loops.webhooks import LEASE_S, WebhookDeliveries
from server.usecases.record.server_events import record_event
from server.usecases.record.webhooks import deliveries, registration
from server.usecases.record.webhooks.deliveries import BATCH, KEY_GONE, PASSED_MAX
from server.webhook_sender import HttpWebhookSender
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.shipped_maps import shipped_map

DAY_S = 86_400.0
RIDER = "Ann Rider"


class Receiver:
    """A server of a developer: it checks every message, and answers with `statuses`, then with 204."""

    def __init__(self, campus: CampusUnderTest, *statuses: int) -> None:
        self.secret = ""
        self.statuses = list(statuses)
        self.attempts: list[str] = []
        self.accepted: list[tuple[str, str]] = []
        self.bodies: list[bytes] = []
        self.url = ""
        self._campus = campus

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        head = (await reader.readuntil(b"\r\n\r\n")).decode()
        lines = [line.split(": ", 1) for line in head.split("\r\n")[1:] if line]
        headers = {name.lower(): value for name, value in lines}
        body = await reader.readexactly(int(headers["content-length"]))
        now_s = self._campus.clock.now().timestamp()
        message = verify_webhook(self.secret, headers, body, now_s=now_s)
        self.attempts.append(message.message_id)
        status = self.statuses.pop(0) if self.statuses else 204
        if status == 204:
            self.accepted.append((message.type, message.data.subject))
            self.bodies.append(body)
        writer.write(f"HTTP/1.1 {status} Said\r\ncontent-length: 0\r\n\r\n".encode())
        await writer.drain()
        writer.close()


@asynccontextmanager
async def receiving(receiver: Receiver) -> AsyncIterator[None]:
    server = await asyncio.start_server(receiver.serve, "127.0.0.1", 0)
    receiver.url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/campus"
    async with server:
        yield


@pytest.fixture
def campus(engine: Engine) -> Iterator[CampusUnderTest]:
    campus = CampusUnderTest(shipped_map("snow-lion"), engine=engine)
    yield campus
    campus.close()


async def registered(campus: CampusUnderTest, receiver: Receiver, *types: str) -> str:
    made = await campus.transactions.run(
        lambda uow: registration.create(uow, receiver.url, types or ("ride.*",), "operator:1", "ann")
    )
    receiver.secret = made.secret
    return made.webhook.webhook_id


async def happen(campus: CampusUnderTest, *names: str) -> None:
    """Each name is an event; its subject is its number among them."""
    await campus.transactions.run(
        lambda uow: [record_event(uow, name, f"r{n}", RIDER, f"of {RIDER}") for n, name in enumerate(names)]
    )


async def cycle(campus: CampusUnderTest, holder: str = "one", times: int = 1) -> None:
    sender = HttpWebhookSender(LOOPBACK)
    loop = WebhookDeliveries(campus.transactions, sender, campus.clock, campus.ids, holder)
    for _ in range(times):
        await loop.run_once()
    await sender.close()


async def stored(campus: CampusUnderTest, webhook_id: str) -> Webhook:
    return await campus.transactions.read(lambda uow: registration.seen(uow, webhook_id, None))


def test_a_receiver_that_fails_twice_gets_all_events_in_order_with_the_same_ids(
    campus: CampusUnderTest,
) -> None:
    async def claim() -> None:
        receiver = Receiver(campus, 500, 503)
        async with receiving(receiver):
            webhook_id = await registered(campus, receiver)
            await happen(campus, "ride.assigned", "vehicle.hold", "ride.completed")
            await cycle(campus)
            await cycle(campus)
            assert (len(receiver.attempts), receiver.accepted) == (1, []), "it is tried again after a pause"
            campus.clock.advance(PAUSES_S[0] * 1.2)
            await cycle(campus)
            failing = await stored(campus, webhook_id)
            assert (failing.failures, failing.last_failure) == (2, "it answered 503")
            campus.clock.advance(PAUSES_S[1] * 1.2)
            await cycle(campus)
            assert receiver.accepted == [("ride.assigned", "r0"), ("ride.completed", "r2")]
            assert receiver.attempts[0] == receiver.attempts[1] == receiver.attempts[2]
            assert len(set(receiver.attempts)) == 2
            well = await stored(campus, webhook_id)
            assert (well.failures, well.last_success_at) == (0, campus.clock.now())

    campus.wait_for(claim())


def test_nothing_is_lost_and_nothing_repeated_when_another_replica_goes_on(campus: CampusUnderTest) -> None:
    async def claim() -> None:
        receiver = Receiver(campus)
        async with receiving(receiver):
            await registered(campus, receiver)
            await happen(campus, *["ride.assigned"] * (BATCH + 5))
            await cycle(campus, "one")
            await cycle(campus, "two")
            assert len(receiver.accepted) == BATCH, "another replica holds the lease"
            campus.clock.advance(LEASE_S + 1.0)
            await cycle(campus, "two")
        assert receiver.accepted == [("ride.assigned", f"r{n}") for n in range(BATCH + 5)]

    campus.wait_for(claim())


def test_a_crash_after_the_sending_repeats_the_same_messages(campus: CampusUnderTest) -> None:
    async def claim() -> None:
        receiver = Receiver(campus)
        async with receiving(receiver):
            webhook_id = await registered(campus, receiver)
            await happen(campus, "ride.assigned")
            (due,) = await campus.transactions.read(deliveries.due)
            sender = HttpWebhookSender(LOOPBACK)
            (message,) = due.messages
            await sender.send(receiver.url, due.headers(message, campus.clock.now()), message.body)
            await sender.close()
            campus.clock.advance(60.0)
            await cycle(campus)
        assert receiver.attempts[0] == receiver.attempts[1] == f"{webhook_id}-{message.number}"
        assert receiver.bodies[0] == receiver.bodies[1]

    campus.wait_for(claim())


def test_a_message_names_no_person(campus: CampusUnderTest) -> None:
    async def claim() -> bytes:
        receiver = Receiver(campus)
        async with receiving(receiver):
            await registered(campus, receiver)
            await happen(campus, "ride.assigned")
            await cycle(campus)
        return receiver.bodies[0]

    body = campus.wait_for(claim())
    assert RIDER.encode() not in body
    assert set(json.loads(body)) == {"type", "timestamp", "data"}
    assert set(json.loads(body)["data"]) == {"campus_id", "number", "subject"}


def test_one_that_fails_for_days_is_disabled_with_an_incident_and_goes_on_when_enabled(
    campus: CampusUnderTest,
) -> None:
    async def claim() -> None:
        receiver = Receiver(campus, *[500] * 20)
        async with receiving(receiver):
            webhook_id = await registered(campus, receiver)
            await happen(campus, "ride.assigned")
            for _ in range(14):
                await cycle(campus)
                campus.clock.advance(DAY_S / 2.0)
            ended = await stored(campus, webhook_id)
            assert ended.disabled_at is not None
            assert ended.failing_since is not None
            assert ended.disabled_at - ended.failing_since >= timedelta(
                days=campus.rules.webhook_failure_days
            )
            attempts = len(receiver.attempts)
            await cycle(campus)
            assert len(receiver.attempts) == attempts
            assert await open_incidents() == [webhook_id]
            receiver.statuses.clear()
            await campus.transactions.run(lambda uow: registration.enable(uow, webhook_id, None, "ann"))
            await cycle(campus)
            assert receiver.accepted == [("ride.assigned", "r0")]
            assert await open_incidents() == []

    async def open_incidents() -> list[str]:
        found = await campus.transactions.read(lambda uow: uow.incidents.all_open())
        return [one.subject for one in found if one.kind is IncidentKind.WEBHOOK_DISABLED]

    campus.wait_for(claim())


def test_an_address_that_is_gone_is_disabled_at_once(campus: CampusUnderTest) -> None:
    async def claim() -> None:
        receiver = Receiver(campus, 410)
        async with receiving(receiver):
            webhook_id = await registered(campus, receiver)
            await happen(campus, "ride.assigned")
            await cycle(campus)
            assert (await stored(campus, webhook_id)).disabled_reason == "its address answers 410 Gone"

    campus.wait_for(claim())


def test_a_failing_one_does_not_keep_another_one_waiting(campus: CampusUnderTest) -> None:
    async def claim() -> None:
        bad, good = Receiver(campus, *[500] * 5), Receiver(campus)
        async with receiving(bad), receiving(good):
            await registered(campus, bad)
            await registered(campus, good)
            await happen(campus, "ride.assigned", "ride.completed")
            await cycle(campus)
        assert (len(bad.accepted), len(good.accepted)) == (0, 2)

    campus.wait_for(claim())


def test_after_a_rotation_both_secrets_verify_for_a_day(campus: CampusUnderTest) -> None:
    async def claim() -> None:
        receiver = Receiver(campus)
        async with receiving(receiver):
            webhook_id = await registered(campus, receiver)
            renewed = await campus.transactions.run(
                lambda uow: registration.rotate(uow, webhook_id, None, "ann")
            )
            assert renewed.secret != receiver.secret
            await happen(campus, "ride.assigned")
            await cycle(campus)
            receiver.secret = renewed.secret
            await happen(campus, "ride.completed")
            await cycle(campus)
            campus.clock.advance(DAY_S + 1.0)
            await happen(campus, "ride.completed")
            await cycle(campus)
            assert len(receiver.accepted) == 3

    campus.wait_for(claim())


def test_one_whose_ticket_key_is_gone_fails_with_that_reason(campus: CampusUnderTest) -> None:
    async def claim() -> None:
        receiver = Receiver(campus)
        async with receiving(receiver):
            webhook_id = await registered(campus, receiver)
            await happen(campus, "ride.assigned")
            object.__setattr__(campus.context, "tickets", TicketKeys([b"another key of the server, long."]))
            await cycle(campus)
            assert (await stored(campus, webhook_id)).last_failure == KEY_GONE
            assert receiver.attempts == []

    campus.wait_for(claim())


def test_the_cursor_follows_events_of_other_types(campus: CampusUnderTest) -> None:
    async def claim() -> None:
        receiver = Receiver(campus)
        async with receiving(receiver):
            webhook_id = await registered(campus, receiver)
            await happen(campus, *["vehicle.hold"] * (PASSED_MAX + 1))
            await cycle(campus)
            last = await campus.transactions.read(lambda uow: uow.webhooks.last_event_number())
            assert (await stored(campus, webhook_id)).cursor == last
            assert receiver.attempts == []

    campus.wait_for(claim())

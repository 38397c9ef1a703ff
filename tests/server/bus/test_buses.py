"""Both buses behave alike; NATS is the real server."""

import asyncio
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from server.bus.in_process import QUEUE_MAX, InProcessBus
from server.bus.nats import BusUnreachable, connect
from server.bus.topics import matches
from server.usecases.ports.bus import Bus


@pytest.fixture(scope="module")
def nats_url() -> Iterator[str]:
    beside = Path(sys.executable).parent / "nats-server"
    program = str(beside) if beside.exists() else shutil.which("nats-server")
    assert program, "nats-server is missing: install the project with its dev extra (make setup)"
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    server = subprocess.Popen([program, "-a", "127.0.0.1", "-p", str(port)], stderr=subprocess.DEVNULL)
    try:
        _wait_for(port)
        yield f"nats://127.0.0.1:{port}"
    finally:
        server.terminate()
        server.wait(10)


def _wait_for(port: int) -> None:
    for _ in range(200):
        with socket.socket() as probe:
            probe.settimeout(0.05)
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.05)
    raise TimeoutError("nats-server does not answer")


@asynccontextmanager
async def opened(kind: str, request: pytest.FixtureRequest) -> AsyncIterator[Bus]:
    bus: Bus = InProcessBus() if kind == "in_process" else await connect(request.getfixturevalue("nats_url"))
    yield bus
    await bus.close()


def on_both(
    scenario: Callable[[Bus], Awaitable[None]],
) -> Callable[[str, pytest.FixtureRequest], None]:
    @pytest.mark.parametrize("kind", ["in_process", "nats"])
    def test(kind: str, request: pytest.FixtureRequest) -> None:
        if kind == "nats":
            request.getfixturevalue("nats_url")

        async def run() -> None:
            async with opened(kind, request) as bus:
                await asyncio.wait_for(scenario(bus), 10.0)

        asyncio.run(run())

    return test


@on_both
async def test_a_subscriber_hears_what_matches_in_order_and_nothing_else(bus: Bus) -> None:
    one = await bus.subscribe("campus/a.b/vehicle/*/outbox")
    everything = await bus.subscribe("campus/a.b/>")
    await bus.publish("campus/a.b/vehicle/shuttle 1.x/outbox".replace(" ", "-"), b"1")
    await bus.publish("campus/a.b/ride/r%1", b"2")
    await bus.publish("campus/other/vehicle/v/outbox", b"3")
    await bus.publish("campus/a.b/vehicle/v/outbox", b"4")
    assert [await anext(one) for _ in range(2)] == [
        ("campus/a.b/vehicle/shuttle-1.x/outbox", b"1"),
        ("campus/a.b/vehicle/v/outbox", b"4"),
    ]
    assert [(await anext(everything))[1] for _ in range(3)] == [b"1", b"2", b"4"]


@on_both
async def test_a_closed_subscription_ends_its_reader(bus: Bus) -> None:
    subscription = await bus.subscribe("campus/>")

    async def read_all() -> list[bytes]:
        return [payload async for _, payload in subscription]

    reader = asyncio.create_task(read_all())
    await bus.publish("campus/x", b"last")
    await asyncio.sleep(0.1)
    await subscription.close()
    await bus.publish("campus/x", b"unheard")
    assert await reader == [b"last"]


@on_both
async def test_a_reader_that_was_cancelled_with_messages_waiting_is_closed_at_once(bus: Bus) -> None:
    subscription = await bus.subscribe("campus/snow-lion/*/outbox")

    async def read() -> None:
        async for _ in subscription:
            await asyncio.sleep(60)

    reading = asyncio.create_task(read())
    await asyncio.sleep(0)
    for _ in range(5):
        await bus.publish("campus/snow-lion/vehicle/outbox", b"")
    await asyncio.sleep(0.2)
    reading.cancel()
    await asyncio.gather(reading, return_exceptions=True)
    async with asyncio.timeout(5):
        await subscription.close()


def test_who_cannot_keep_up_loses_the_oldest() -> None:
    async def scenario() -> None:
        bus = InProcessBus()
        slow = await bus.subscribe(">")
        for number in range(QUEUE_MAX + 3):
            await bus.publish("t", str(number).encode())
        assert slow.dropped == 3
        assert (await anext(slow))[1] == b"3"

    asyncio.run(scenario())


def test_a_missing_nats_server_is_said_so() -> None:
    with pytest.raises(BusUnreachable, match="start one"):
        asyncio.run(asyncio.wait_for(connect("nats://127.0.0.1:1"), 20.0))


@pytest.mark.parametrize(
    ("pattern", "topic", "expected"),
    [
        ("a/b", "a/b", True),
        ("a/*", "a/b", True),
        ("a/*", "a/b/c", False),
        ("a/>", "a/b/c", True),
        ("a/>", "a", False),
        ("*/b", "a/b", True),
        ("a/b/c", "a/b", False),
    ],
)
def test_patterns(pattern: str, topic: str, expected: bool) -> None:
    assert matches(pattern, topic) is expected


def test_a_message_that_has_no_reader_here_need_not_be_made() -> None:
    async def wanted() -> tuple[bool, bool, bool]:
        bus = InProcessBus()
        before = bus.wants("campus/c/vehicle/v/event")
        subscription = await bus.subscribe("campus/c/vehicle/*/event")
        during = bus.wants("campus/c/vehicle/v/event")
        await subscription.close()
        return before, during, bus.wants("campus/c/vehicle/v/event")

    assert asyncio.run(wanted()) == (False, True, False)

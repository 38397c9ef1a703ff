"""Webhook receivers that hang, never end their answer, or refuse: nothing else may wait for them."""

import asyncio
from collections.abc import Awaitable, Callable

from benchmarks.faults.stage import Stage, require

_LASTS_S = 15.0
_CALLS_MAX = 20
Answer = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


async def webhook_that_hangs(stage: Stage) -> None:
    """It takes the message and never answers."""

    async def answer(_: asyncio.StreamReader, __: asyncio.StreamWriter) -> None:
        await asyncio.sleep(60.0)

    await _receive(stage, answer)


async def webhook_without_an_end(stage: Stage) -> None:
    """Its answer has no end."""

    async def answer(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n")
        while True:
            writer.write(b"8000\r\n" + 0x8000 * b"x" + b"\r\n")
            await writer.drain()
            await asyncio.sleep(0.01)

    # An answer of 200 counts, whatever follows: every message is delivered.
    await _receive(stage, answer, calls_max=None)


async def webhook_that_fails(stage: Stage) -> None:
    """It answers 500 to everything."""

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        writer.write(b"HTTP/1.1 500 Broken\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
        await writer.drain()
        writer.close()

    await _receive(stage, answer)


async def _receive(stage: Stage, answer: Answer, calls_max: int | None = _CALLS_MAX) -> None:
    calls = 0

    async def called(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        nonlocal calls
        calls += 1
        try:
            await answer(reader, writer)
        except (ConnectionError, asyncio.IncompleteReadError):
            return
        finally:
            writer.close()

    receiver = await asyncio.start_server(called, "127.0.0.1", 0)
    port = receiver.sockets[0].getsockname()[1]
    hook = {"url": f"http://127.0.0.1:{port}/", "event_types": ["ride.*"]}
    made = await stage.installation.ask("POST", "/webhooks", hook)
    booked = len(stage.riders.acknowledged)
    before = stage.installation.process.memory_info().rss
    await asyncio.sleep(_LASTS_S)
    grown = stage.installation.process.memory_info().rss - before
    receiver.close()
    (await stage.installation.http.delete(f"/webhooks/{made['webhook_id']}")).raise_for_status()
    require(calls > 0, "the webhook was never called")
    require(
        calls_max is None or calls < calls_max, f"the webhook was called {calls} times in {_LASTS_S:.0f} s"
    )
    require(len(stage.riders.acknowledged) > booked + 10, "bookings waited for a webhook")
    require(grown < 100 << 20, f"memory grew by {grown >> 20} MiB")

"""A script's coroutine against the real server: websockets, threads, files and all."""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

from campusloop_sdk import Live, Update
from tests.campusloop.live.live_server import LiveServer, live_server

TIME_LIMIT_S = 40


def against_server(tmp_path: Path, claim: Callable[[LiveServer], Awaitable[None]]) -> None:
    async def run() -> None:
        async with asyncio.timeout(TIME_LIMIT_S), live_server(tmp_path) as server:
            await claim(server)

    asyncio.run(run())


async def until(live: Live, is_it: Callable[[Update], bool]) -> Update:
    """The first update that is it."""
    async for update in live:
        if is_it(update):
            return update
    raise AssertionError("updates have no end")

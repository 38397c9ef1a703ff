"""A process that is one asyncio task, until SIGTERM."""

import asyncio
import signal
from collections.abc import Awaitable, Callable


def run_until_stopped(run: Callable[[asyncio.Event], Awaitable[None]]) -> None:
    """run: ends when its event is set. Ctrl-C is for the supervisor, which stops its children in order."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    async def serve() -> None:
        stop = asyncio.Event()
        asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, stop.set)
        await run(stop)

    asyncio.run(serve())

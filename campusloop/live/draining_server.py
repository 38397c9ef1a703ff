"""uvicorn that lets the vehicles go in order before it closes connections."""

import asyncio
import socket
from collections.abc import Callable, Coroutine

import uvicorn
from fastapi import FastAPI

from server.app import services_of_app

_LOOKS_EVERY_S = 0.1


class DrainingServer(uvicorn.Server):
    """On SIGTERM: no new connections, then `drain`, then uvicorn's own end.

    uvicorn closes every websocket at one moment and without a farewell, before the application hears of it.
    """

    def __init__(self, config: uvicorn.Config, drain: Callable[[], Coroutine[object, None, None]]) -> None:
        super().__init__(config)
        self._drain = drain

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """A second Ctrl-C ends the wait."""
        for server in self.servers:
            server.close()
        for listening in sockets or []:
            listening.close()
        draining = asyncio.get_running_loop().create_task(self._drain())
        try:
            while not draining.done() and not self.force_exit:
                await asyncio.wait({draining}, timeout=_LOOKS_EVERY_S)
            if draining.done():
                draining.result()
        finally:
            draining.cancel()
            await super().shutdown(sockets)


def draining_server(config: uvicorn.Config) -> DrainingServer:
    """The server of our application, whose links leave first."""
    assert isinstance(config.app, FastAPI)
    return DrainingServer(config, services_of_app(config.app).hub.leave)

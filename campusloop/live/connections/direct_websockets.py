"""uvicorn's websockets, from which an endpoint can take the frames over (docs/decisions/0015).

The handshake and every socket that stays with its endpoint are uvicorn's. A connection that was taken over is
a `FrameConnection`, and uvicorn's own object and the handshake are forgotten.
"""

import asyncio
from collections.abc import Callable
from http import HTTPStatus
from typing import Any
from weakref import WeakKeyDictionary

from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.http11 import Request

from campusloop.live.connections.frame_connection import FrameConnection, QuietWatch
from server.api.sockets.frame_stream import EXTENSION

_WATCHES: WeakKeyDictionary[asyncio.AbstractEventLoop, dict[float, QuietWatch]] = WeakKeyDictionary()


class DirectFrames:
    """A `server.api.sockets.frame_stream.FrameStream`: what is sent before the take-over waits for it."""

    def __init__(self, websocket: "DirectWebsockets") -> None:
        self._websocket: DirectWebsockets | None = websocket
        self._waiting: list[Callable[[FrameConnection], None]] = []

    def take_over(self, received: Callable[[bytes], None], lost: Callable[[str], None]) -> FrameConnection:
        assert self._websocket is not None, "taken over twice"
        websocket, self._websocket = self._websocket, None
        connection = websocket.taken_over(received, lost)
        for call in self._waiting:
            call(connection)
        return connection

    def send(self, data: bytes) -> None:
        self._waiting.append(lambda connection: connection.send(data))

    def close(self, code: int, reason: str) -> None:
        self._waiting.append(lambda connection: connection.close(code, reason))


class _End:
    """What has to be done when a connection that was taken over has ended."""

    __slots__ = ("_bookkeeping", "_connections", "_lost")

    def __init__(
        self, connections: set[Any], bookkeeping: Callable[[], None], lost: Callable[[str], None]
    ) -> None:
        self._connections, self._bookkeeping, self._lost = connections, bookkeeping, lost

    def __call__(self, connection: FrameConnection, reason: str) -> None:
        self._connections.discard(connection)
        self._bookkeeping()
        self._lost(reason)


class DirectWebsockets(WebSocketsSansIOProtocol):
    """An ordinary ASGI websocket until its endpoint takes the frames over."""

    _is_taken_over = False

    def handle_connect(self, event: Request) -> None:
        super().handle_connect(event)
        if self.response.status_code == HTTPStatus.SWITCHING_PROTOCOLS:
            extensions: Any = self.scope["extensions"]
            extensions[EXTENSION] = DirectFrames(self)

    async def run_asgi(self) -> None:
        """As uvicorn's, but a connection that was taken over stays open when its endpoint returns."""
        try:
            await self.app(self.scope, self.receive, self.send)
        except ClientDisconnected:
            pass
        except BaseException:
            self.logger.exception("Exception in ASGI application\n")
            self.send_500_response()
        else:
            if not self.handshake_complete:
                self.logger.error("ASGI callable returned without completing handshake.")
                self.send_500_response()
        if not self._is_taken_over and self.close_timer is None:
            self.transport.close()

    def end_bookkeeping(self) -> Callable[[], None]:
        """What has to be called when a connection that was taken over has ended; it keeps nothing of this."""
        return _nothing

    def taken_over(self, received: Callable[[bytes], None], lost: Callable[[str], None]) -> FrameConnection:
        self._is_taken_over = True
        self.stop_keepalive()
        watch = _watch(self.loop, self.config.ws_ping_interval or None)
        end = _End(self.connections, self.end_bookkeeping(), lost)
        connection = FrameConnection(self.transport, self.config.ws_max_size, watch, received, end)
        # The server's own list, by which it ends what is open.
        self.connections.discard(self)
        self.connections.add(connection)  # type: ignore[arg-type]
        self.transport.set_protocol(connection)
        if self.read_paused:
            self.read_paused = False
            self.transport.resume_reading()
        while not self.queue.empty():
            _hand_on(self.queue.get_nowait(), connection, received)
        return connection


def _hand_on(message: Any, connection: FrameConnection, received: Callable[[bytes], None]) -> None:
    """A message that came before the connection was taken over."""
    if message["type"] == "websocket.receive":
        text = message.get("text")
        received(message["bytes"] if text is None else text.encode())
    elif message["type"] == "websocket.disconnect":
        connection.connection_lost(None)


def _watch(loop: asyncio.AbstractEventLoop, quiet_s: float | None) -> QuietWatch | None:
    """The watch of all connections of the loop; None if quiet peers are not looked after."""
    if quiet_s is None:
        return None
    watches = _WATCHES.setdefault(loop, {})
    return watches.setdefault(quiet_s, QuietWatch(quiet_s))


def _nothing() -> None:
    return

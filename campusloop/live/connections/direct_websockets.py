"""uvicorn's websockets, from which an endpoint can take the frames over (docs/decisions/0015).

The handshake and every socket that stays with its endpoint are uvicorn's. A connection that was taken over is
a `FrameConnection`, and uvicorn's own object and the handshake are forgotten.
"""

from collections.abc import Callable
from functools import cache
from http import HTTPStatus
from typing import Any

from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.http11 import Request

from campusloop.live.connections.frame_connection import FrameConnection, FrameLimits
from server.api.sockets.frame_stream import EXTENSION


class DirectFrames:
    """A `server.api.sockets.frame_stream.FrameStream`: what is sent before the take-over waits for it."""

    __slots__ = ("_connection", "_waiting", "_websocket")

    def __init__(self, websocket: "DirectWebsockets") -> None:
        self._websocket: DirectWebsockets | None = websocket
        self._connection: FrameConnection | None = None
        self._waiting: list[Callable[[FrameConnection], None]] = []

    def take_over(self, received: Callable[[bytes], None], lost: Callable[[str], None]) -> None:
        assert self._websocket is not None, "taken over twice"
        websocket, self._websocket = self._websocket, None
        self._connection = websocket.taken_over(received, lost)
        waiting, self._waiting = self._waiting, []
        for call in waiting:
            call(self._connection)

    def send(self, data: bytes) -> None:
        if self._connection is None:
            self._waiting.append(lambda connection: connection.send(data))
        else:
            self._connection.send(data)

    def close(self, code: int, reason: str) -> None:
        if self._connection is None:
            self._waiting.append(lambda connection: connection.close(code, reason))
        else:
            self._connection.close(code, reason)

    def pause(self) -> None:
        if self._connection is not None:
            self._connection.pause()

    def resume(self) -> None:
        if self._connection is not None:
            self._connection.resume()


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
        connections, ended = self.connections, self.end_bookkeeping()

        def lost_connection(reason: str) -> None:
            connections.discard(connection)
            ended()
            lost(reason)

        limits = _limits(self.config.ws_max_size, self.config.ws_ping_interval or None)
        connection = FrameConnection(self.transport, limits, received, lost_connection)
        # The server's own list, by which it ends what is open.
        connections.discard(self)
        connections.add(connection)  # type: ignore[arg-type]
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


@cache
def _limits(message_bytes_max: int, quiet_s: float | None) -> FrameLimits:
    """One object for all connections."""
    return FrameLimits(message_bytes_max, quiet_s)


def _nothing() -> None:
    return

"""uvicorn's websockets with a short way for the frames of vehicles (docs/decisions/0015).

Nearly every frame that a vehicle sends is one short, unfragmented text frame. Such a frame is unmasked here
and handed on in the same call. Everything else (the handshake, control frames, fragments, errors) stays
with the parser of the library `websockets`, which is given whole frames only.
"""

import asyncio
import struct
from collections.abc import Callable
from http import HTTPStatus
from typing import Any

from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.http11 import Request
from websockets.speedups import apply_mask

from contract.wire.close_reasons import close_reason
from server.api.sockets.frame_stream import EXTENSION

# What may wait in our memory for a peer that does not read; the kernel's buffers hold some megabytes before
# that.
WAITING_BYTES_MAX = 1024 * 1024

_TEXT, _BINARY, _FIN, _MASKED = 0x81, 0x82, 0x80, 0x80
_FIRST_CONTROL = 0x08


class _NoQueue(asyncio.Queue[Any]):
    """Of a connection that was taken over: nothing is read from it."""

    def put_nowait(self, item: Any) -> None:
        return


_NO_QUEUE = _NoQueue()


class DirectFrames:
    """A `server.api.sockets.frame_stream.FrameStream` over one connection."""

    __slots__ = ("_connection",)

    def __init__(self, connection: "DirectWebsockets") -> None:
        self._connection = connection

    def take_over(self, received: Callable[[bytes], None], lost: Callable[[str], None]) -> None:
        self._connection.take_over(received, lost)

    def send(self, data: bytes) -> None:
        self._connection.send_frame(data)

    def close(self, code: int, reason: str) -> None:
        self._connection.send_close(code, reason)

    def pause(self) -> None:
        self._connection.pause()

    def resume(self) -> None:
        self._connection.resume()


class DirectWebsockets(WebSocketsSansIOProtocol):
    """An ordinary ASGI websocket until its endpoint takes the frames over."""

    _received: Callable[[bytes], None] | None = None
    _lost: Callable[[str], None] | None = None
    # The beginning of a frame whose end has not come yet, and whether a fragmented message is under way.
    _begun = b""
    _in_fragments = False

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
        if self._received is None and self.close_timer is None:
            self.transport.close()

    # ---------------------------------------------------------------- called by the endpoint and the link

    def take_over(self, received: Callable[[bytes], None], lost: Callable[[str], None]) -> None:
        self._received, self._lost = received, lost
        for _ in range(self.queue.qsize()):
            self._hand_on(self.queue.get_nowait())
        # The handshake is over: what only ASGI needs would be a third of the memory of a connection.
        self.queue = _NO_QUEUE
        self.scope, self.request, self.response = {}, None, None  # type: ignore[assignment,typeddict-item]
        self.resume()

    def send_frame(self, data: bytes) -> None:
        if self.close_sent or self.transport.is_closing():
            return
        size = len(data)
        if size < 126:
            head = bytes((_TEXT, size))
        elif size < 1 << 16:
            head = struct.pack("!BBH", _TEXT, 126, size)
        else:
            head = struct.pack("!BBQ", _TEXT, 127, size)
        self.transport.write(head + data)
        if not self.writable.is_set() and self.transport.get_write_buffer_size() > WAITING_BYTES_MAX:
            row = close_reason("too_slow")
            self.send_close(row.number, row.code)

    def send_close(self, code: int, reason: str) -> None:
        """What was sent before still goes out; a peer that does not answer is cut off."""
        if self.close_sent or self.transport.is_closing():
            return
        self.conn.send_close(code, reason)
        self.transport.write(b"".join(self.conn.data_to_send()))
        self.close_sent = True
        self.resume()
        self.close_timer = self.loop.call_later(self.close_timeout, self.transport.abort)

    def pause(self) -> None:
        if not self.read_paused:
            self.read_paused = True
            self.transport.pause_reading()

    def resume(self) -> None:
        if self.read_paused and not self.transport.is_closing():
            self.read_paused = False
            self.transport.resume_reading()

    # ---------------------------------------------------------------- what comes in

    def data_received(self, data: bytes) -> None:
        if self._received is None:
            super().data_received(data)
            return
        if self._begun:
            data, self._begun = self._begun + data, b""
        at = 0
        while at < len(data):
            end = self._frame_end(data, at)
            if end is None:
                self._begun = data[at:]
                return
            at = end

    def _frame_end(self, data: bytes, at: int) -> int | None:
        """Handle the frame that begins there. Returns where it ends; None if its end has not come yet."""
        if len(data) - at < 6:
            return None
        first, second = data[at], data[at + 1]
        begin, size = at + 6, second & 0x7F
        if size == 126:
            begin, size = at + 8, int.from_bytes(data[at + 2 : at + 4])
        elif size == 127:
            begin, size = at + 14, int.from_bytes(data[at + 2 : at + 10])
        end = begin + size
        if not second & _MASKED or size > self.config.ws_max_size:
            # The parser refuses it by its head.
            self._parse(data[at:])
            return len(data)
        if end > len(data):
            return None
        if first in (_TEXT, _BINARY) and not self._in_fragments:
            if not self.close_sent:
                assert self._received is not None
                self._received(apply_mask(data[begin:end], data[begin - 4 : begin]))
        else:
            if first & 0x0F < _FIRST_CONTROL:
                self._in_fragments = not first & _FIN
            self._parse(data[at:end])
        return end

    def _parse(self, data: bytes) -> None:
        super().data_received(data)

    def send_receive_event_to_app(self) -> None:
        if self._received is None:
            super().send_receive_event_to_app()
            return
        data, self.frames = b"".join(self.frames), []
        if not self.close_sent:
            self._received(data)

    def _hand_on(self, message: Any) -> None:
        """A message that came before the connection was taken over."""
        if message["type"] == "websocket.receive" and self._received is not None:
            text = message.get("text")
            self._received(message["bytes"] if text is None else text.encode())
        elif message["type"] == "websocket.disconnect":
            self._tell_lost("closed by the vehicle")

    # ---------------------------------------------------------------- the end

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self._tell_lost("connection lost")

    def _tell_lost(self, reason: str) -> None:
        lost, self._lost = self._lost, None
        if lost is not None:
            lost(reason)

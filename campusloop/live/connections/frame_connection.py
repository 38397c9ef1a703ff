"""A websocket whose frames go straight to a link, without a task, a queue or the handshake kept for it.

Nearly every frame that a vehicle sends is one short, unfragmented text frame. Such a frame is unmasked here
and handed on in the same call. For all else (control frames, fragments, errors, the close) a parser of the
library `websockets` is made, and dropped when it is between two messages again.
"""

import asyncio
import struct
from collections.abc import Callable
from typing import cast

from websockets.frames import CloseCode, Frame, Opcode
from websockets.protocol import OPEN, SEND_EOF, SERVER
from websockets.protocol import Protocol as Parser
from websockets.speedups import apply_mask

from contract.wire.close_reasons import close_reason

# What may wait in our memory for a peer that does not read; the kernel's buffers hold some megabytes before
# that.
WAITING_BYTES_MAX = 1024 * 1024
# A peer that does not answer our close, or does not read what is left for it, is cut off.
CLOSE_WITHIN_S = 10.0

_TEXT, _MASKED = 0x81, 0x80
# First bytes of a text and of a binary frame that is no fragment.
_WHOLE_DATA = (0x81, 0x82)
_DATA = (Opcode.TEXT, Opcode.BINARY, Opcode.CONT)


class FrameConnection(asyncio.Protocol):
    """A websocket after its handshake. There are thousands of it, so it holds little.

    message_bytes_max  of a frame, or of all fragments of a message
    watch              pings it while it is quiet; None: never
    received           gets the content of each message
    lost               is told once that the connection has ended, and why
    """

    __slots__ = (
        "_begun",
        "_cut_off",
        "_fragments",
        "_is_closing",
        "_is_heard",
        "_is_paused",
        "_is_pinged",
        "_is_writable",
        "_lost",
        "_message_bytes_max",
        "_parser",
        "_received",
        "_transport",
        "_watch",
    )

    def __init__(
        self,
        transport: asyncio.Transport,
        message_bytes_max: int,
        watch: "QuietWatch | None",
        received: Callable[[bytes], None],
        lost: "Callable[[FrameConnection, str], None]",
    ) -> None:
        self._transport = transport
        self._message_bytes_max = message_bytes_max
        self._watch = watch
        self._received = received
        self._lost = lost
        # The beginning of a frame whose end has not come yet.
        self._begun = b""
        # Present in the middle of a fragmented message and after our close.
        self._parser: Parser | None = None
        self._fragments: list[bytes] | None = None
        self._is_closing = False
        self._is_paused = False
        self._is_writable = True
        self._is_heard = self._is_pinged = False
        self._cut_off: asyncio.TimerHandle | None = None
        if watch is not None:
            watch.add(self)

    # ---------------------------------------------------------------- to the peer

    def send(self, data: bytes) -> None:
        """Send a text frame. A peer that does not read is closed with `too_slow`."""
        if self._is_closing or self._transport.is_closing():
            return
        size = len(data)
        if size < 126:
            head = bytes((_TEXT, size))
        elif size < 1 << 16:
            head = struct.pack("!BBH", _TEXT, 126, size)
        else:
            head = struct.pack("!BBQ", _TEXT, 127, size)
        self._transport.write(head + data)
        if not self._is_writable and self._transport.get_write_buffer_size() > WAITING_BYTES_MAX:
            row = close_reason("too_slow")
            self.close(row.number, row.code)

    def close(self, code: int, reason: str) -> None:
        """What was sent before still goes out first."""
        if self._is_closing or self._transport.is_closing():
            return
        parser = self._parser_here()
        parser.send_close(code, reason)
        self._end(parser, awaits_answer=True)

    def shutdown(self) -> None:
        """The server ends now (RFC 6455 7.4.1, 1012)."""
        if not self._is_closing:
            self.close(CloseCode.SERVICE_RESTART, "")
        self._transport.close()

    def pause(self) -> None:
        if not self._is_paused:
            self._is_paused = True
            self._transport.pause_reading()

    def resume(self) -> None:
        if self._is_paused and not self._transport.is_closing():
            self._is_paused = False
            self._transport.resume_reading()

    # ---------------------------------------------------------------- from the event loop

    def pause_writing(self) -> None:
        self._is_writable = False

    def resume_writing(self) -> None:
        self._is_writable = True

    def connection_lost(self, exc: Exception | None) -> None:
        self._is_closing = True
        self._unwatch()
        if self._cut_off is not None:
            self._cut_off.cancel()
        lost, self._lost = self._lost, _told
        lost(self, "connection lost")

    def data_received(self, data: bytes) -> None:
        self._is_heard = True
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
        if not second & _MASKED or size > self._message_bytes_max:
            # The parser refuses it by its head.
            self._parse(data[at:])
            return len(data)
        if end > len(data):
            return None
        if self._parser is None and first in _WHOLE_DATA:
            self._received(apply_mask(data[begin:end], data[begin - 4 : begin]))
        else:
            self._parse(data[at:end])
        return end

    # ---------------------------------------------------------------- what is rare

    def _parser_here(self) -> Parser:
        if self._parser is None:
            self._parser = Parser(SERVER, state=OPEN, max_size=self._message_bytes_max)
        return self._parser

    def _parse(self, data: bytes) -> None:
        parser = self._parser_here()
        parser.receive_data(data)
        for frame in parser.events_received():
            frame = cast(Frame, frame)
            if frame.opcode in _DATA and not self._is_closing:
                fragments = self._fragments or []
                fragments.append(bytes(frame.data))
                self._fragments = None if frame.fin else fragments
                if frame.fin:
                    self._received(b"".join(fragments))
        if parser.close_rcvd is not None or parser.parser_exc is not None:
            # The peer's close, or a frame that breaks the protocol.
            self._end(parser, awaits_answer=False)
            return
        self._write(parser)
        if parser.current_size is None and not self._is_closing:
            self._parser = None

    def _write(self, parser: Parser) -> None:
        for data in parser.data_to_send():
            if data != SEND_EOF and not self._transport.is_closing():
                self._transport.write(data)

    def _end(self, parser: Parser, *, awaits_answer: bool) -> None:
        """Send what the parser has to say, and close: at once, or when the peer has answered."""
        self._is_closing = True
        self._write(parser)
        self._unwatch()
        self.resume()
        self._cut_off = asyncio.get_running_loop().call_later(CLOSE_WITHIN_S, self._transport.abort)
        if not awaits_answer:
            self._transport.close()

    # ---------------------------------------------------------------- a peer that is quiet

    def _unwatch(self) -> None:
        if self._watch is not None:
            self._watch.discard(self)

    def look(self) -> None:
        """Ping a peer that has said nothing since the last look, and close it if it was pinged then."""
        if self._is_heard:
            self._is_heard = self._is_pinged = False
        elif self._is_pinged and not self._is_paused:
            parser = self._parser_here()
            parser.fail(CloseCode.INTERNAL_ERROR, "keepalive ping timeout")
            self._end(parser, awaits_answer=False)
        elif not self._transport.is_closing():
            self._is_pinged = True
            # An empty ping, from the server unmasked (RFC 6455 5.5.2).
            self._transport.write(bytes((0x89, 0)))


class QuietWatch:
    """Looks after the connections of one event loop, all with one timer.

    quiet_s  a peer that says nothing for so long is pinged, and closed after the same time again
    """

    def __init__(self, quiet_s: float) -> None:
        self._quiet_s = quiet_s
        self._connections: set[FrameConnection] = set()
        self._timer: asyncio.TimerHandle | None = None

    def add(self, connection: FrameConnection) -> None:
        self._connections.add(connection)
        if self._timer is None:
            self._timer = asyncio.get_running_loop().call_later(self._quiet_s, self._look)

    def discard(self, connection: FrameConnection) -> None:
        self._connections.discard(connection)

    def _look(self) -> None:
        self._timer = None
        for connection in tuple(self._connections):
            connection.look()
        if self._connections:
            self._timer = asyncio.get_running_loop().call_later(self._quiet_s, self._look)


def _told(_connection: FrameConnection, _reason: str) -> None:
    """The end has been told."""

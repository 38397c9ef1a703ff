"""Websocket frames (RFC 6455) of a client, as bytes: a load generator must cost less than its server."""

import os
import struct
from collections.abc import Iterator

from websockets.speedups import apply_mask

TEXT, CLOSE, PING, PONG = 0x1, 0x8, 0x9, 0xA
_FIN, _MASKED = 0x80, 0x80
# Drawn once: what a mask protects from (proxies) is not between us and the server, and unmasking costs the
# same.
_MASK = os.urandom(4)


def client_frame(payload: bytes, opcode: int = TEXT) -> bytes:
    """One masked frame."""
    length = len(payload)
    if length < 126:
        head = bytes((_FIN | opcode, _MASKED | length))
    elif length < 65536:
        head = struct.pack("!BBH", _FIN | opcode, _MASKED | 126, length)
    else:
        head = struct.pack("!BBQ", _FIN | opcode, _MASKED | 127, length)
    return head + _MASK + apply_mask(payload, _MASK)


class ServerFrames:
    """Cuts what a server sends into frames."""

    def __init__(self) -> None:
        self._rest = b""

    def received(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """(opcode, payload) of each frame that is complete now. Servers do not mask; ours do not fragment."""
        if self._rest:
            data = self._rest + data
        at, end = 0, len(data)
        while end - at >= 2:
            opcode, length = data[at] & 0x0F, data[at + 1]
            begin = at + 2
            if length == 126:
                begin, length = at + 4, int.from_bytes(data[at + 2 : at + 4])
            elif length == 127:
                begin, length = at + 10, int.from_bytes(data[at + 2 : at + 10])
            if end < begin + length:
                break
            yield opcode, data[begin : begin + length]
            at = begin + length
        self._rest = data[at:]


def upgrade_request(port: int, path: str, cookie: str = "") -> bytes:
    head = (
        f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
    )
    return (head + (f"Cookie: {cookie}\r\n" if cookie else "") + "\r\n").encode()

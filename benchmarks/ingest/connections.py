"""One connection of the load generator: dialled, upgraded, greeted, and then open. Sockets never block."""

import errno
import socket
from collections.abc import Callable
from typing import Protocol

import msgspec

from benchmarks.ingest.frames import CLOSE, PING, PONG, ServerFrames, client_frame, upgrade_request
from benchmarks.ingest.messages import BOOT
from contract.wire.messages import Welcome

_ACKNOWLEDGED = b"events_acknowledged"
_NEXT = b'"next_sequence":'
_CHUNK = 1 << 18


class Connection:
    """`data` is called when the socket can be read. greeted: the session is open."""

    def __init__(self, port: int, path: str, cookie: str = "") -> None:
        self.socket = socket.socket()
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.setblocking(False)
        self.ended = ""
        self._head: bytearray | None = bytearray()
        self._frames = ServerFrames()
        self._unsent = bytearray(upgrade_request(port, path, cookie))
        self.socket.connect_ex(("127.0.0.1", port))

    @property
    def has_unsent(self) -> bool:
        return bool(self._unsent)

    def send(self, payload: bytes) -> None:
        self._write(client_frame(payload))

    def flush(self) -> None:
        """The socket can be written again."""
        unsent, self._unsent = self._unsent, bytearray()
        self._write(bytes(unsent))

    def readable(self, now_s: float) -> None:
        try:
            data = self.socket.recv(_CHUNK)
        except BlockingIOError:
            return
        except OSError as error:
            self.ended = str(error)
            return
        if not data:
            self.ended = self.ended or "closed by the server"
            return
        if self._head is not None:
            self._head += data
            head, found, data = bytes(self._head).partition(b"\r\n\r\n")
            if not found:
                return
            self._head = None
            if not head.startswith(b"HTTP/1.1 101"):
                self.ended = head.split(b"\r\n", 1)[0].decode()
                return
            self.upgraded()
        for opcode, payload in self._frames.received(data):
            if opcode == PING:
                self._write(client_frame(payload, PONG))
            elif opcode == CLOSE:
                self.ended = f"close {int.from_bytes(payload[:2])} {payload[2:].decode()}"
            else:
                self.message(payload, now_s)

    def upgraded(self) -> None:
        """The websocket is open."""

    def message(self, payload: bytes, now_s: float) -> None:
        """A message has come."""

    def _write(self, data: bytes) -> None:
        if self._unsent:
            self._unsent += data
            return
        try:
            sent = self.socket.send(data)
        except OSError as error:
            if error.errno not in (errno.EAGAIN, errno.ENOTCONN, errno.EINPROGRESS):
                self.ended = str(error)
            sent = 0
        if sent < len(data):
            self._unsent += data[sent:]


class Acknowledgements(Protocol):
    """Takes what a server acknowledges: all events of a vehicle below a number."""

    def acknowledged(self, vehicle: int, next_sequence: int, now_s: float) -> None: ...


class VehicleConnection(Connection):
    """A vehicle's link: challenge, signed hello, welcome; then it sends, and reads acknowledgements."""

    def __init__(
        self,
        port: int,
        number: int,
        say_hello: Callable[[bytes], bytes] | None,
        acknowledgements: Acknowledgements,
        path: str = "/ws/vehicle",
    ) -> None:
        """say_hello: the answer to a challenge; None for a server without sessions"""
        super().__init__(port, path)
        self.number = number
        self.epoch = 0
        self.next_sequence = 0
        self.is_open = False
        self._say_hello = say_hello
        self._acknowledgements = acknowledgements

    def upgraded(self) -> None:
        self.is_open = self._say_hello is None

    def message(self, payload: bytes, now_s: float) -> None:
        if _ACKNOWLEDGED in payload:
            at = payload.rfind(_NEXT) + len(_NEXT)
            stored = int(payload[at : payload.find(b"}", at)].partition(b",")[0])
            self._acknowledgements.acknowledged(self.number, stored, now_s)
        elif not self.is_open:
            self._greet(payload)

    def _greet(self, payload: bytes) -> None:
        assert self._say_hello is not None
        if b'"type":"challenge"' in payload:
            self.send(self._say_hello(payload))
        elif b'"type":"welcome"' in payload:
            welcome = msgspec.json.decode(payload, type=Welcome)
            self.epoch = welcome.epoch
            known = {log.boot_id: log.first_unacknowledged for log in welcome.acknowledged}
            self.next_sequence = known.get(BOOT, 0)
            self.is_open = True
        else:
            self.ended = payload.decode()[:200]


class PostingConnection(VehicleConnection):
    """Reports over HTTP/1.1 on one persistent connection: a POST for each event."""

    def __init__(self, port: int, number: int, acknowledgements: Acknowledgements, path: str) -> None:
        super().__init__(port, number, None, acknowledgements, path)
        self.is_open = True
        self._unsent.clear()
        self._head_of_post = (
            f"POST {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Type: application/json\r\n"
            "Content-Length: "
        ).encode()
        self._answers = bytearray()

    def send(self, payload: bytes) -> None:
        self._write(b"%b%d\r\n\r\n%b" % (self._head_of_post, len(payload), payload))

    def readable(self, now_s: float) -> None:
        try:
            data = self.socket.recv(_CHUNK)
        except BlockingIOError:
            return
        if not data:
            self.ended = "closed by the server"
            return
        self._answers += data
        while (end := self._answers.find(b"\r\n\r\n")) >= 0:
            head = bytes(self._answers[:end]).lower()
            begin = head.index(b"content-length:") + len(b"content-length:")
            size = int(head[begin:].split(b"\r\n", 1)[0])
            if len(self._answers) < end + 4 + size:
                return
            body = bytes(self._answers[end + 4 : end + 4 + size])
            del self._answers[: end + 4 + size]
            if not head.startswith(b"http/1.1 200"):
                self.ended = f"{head[:40]!r} {body[:200]!r}"
                return
            self.message(body, now_s)

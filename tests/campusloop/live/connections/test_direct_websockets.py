"""Frames of vehicles on their short way: in whatever pieces they come, they are handed on whole."""

import asyncio
import struct
from collections.abc import Callable

import pytest
import uvicorn
from fastapi import FastAPI, WebSocket
from uvicorn.server import ServerState
from websockets.client import ClientProtocol
from websockets.frames import Frame, Opcode
from websockets.uri import parse_uri

from campusloop.live.connections import frame_connection
from campusloop.live.connections.direct_websockets import DirectWebsockets
from campusloop.live.connections.frame_connection import WAITING_BYTES_MAX, FrameConnection, QuietWatch
from server.api.sockets.frame_stream import Frames, frame_stream

SIZE_MAX = 100_000


class Wire(asyncio.Transport):
    """The server's end of a connection: what it writes is kept."""

    def __init__(self) -> None:
        super().__init__()
        self.written = bytearray()
        self.something_happened = asyncio.Event()
        self.is_paused = False
        self.is_aborted = False
        self.waiting_bytes = 0
        self._is_closing = False

    def set_protocol(self, protocol: asyncio.BaseProtocol) -> None:
        assert isinstance(protocol, asyncio.Protocol)
        self.protocol = protocol

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self.written += data
        self.something_happened.set()

    def close(self) -> None:
        self._is_closing = True
        self.something_happened.set()

    def abort(self) -> None:
        self._is_closing = self.is_aborted = True
        self.something_happened.set()

    def is_closing(self) -> bool:
        return self._is_closing

    def pause_reading(self) -> None:
        self.is_paused = True

    def resume_reading(self) -> None:
        self.is_paused = False

    def get_write_buffer_size(self) -> int:
        return self.waiting_bytes

    def get_extra_info(self, name: str, default: object = None) -> object:
        return default


class TakenOver:
    """A connection whose endpoint has taken the frames over, and the client at its other end."""

    def __init__(self) -> None:
        self.received: list[bytes] = []
        self.lost: list[str] = []
        self.lost_early = False
        self.frames: Frames | None = None
        self.sent_early: list[bytes] = []
        self.wire = Wire()
        app = FastAPI()

        @app.websocket("/ws")
        async def endpoint(websocket: WebSocket) -> None:
            await websocket.accept()
            stream = frame_stream(websocket)
            if self.lost_early:
                self.server.connection_lost(None)
            assert stream is not None
            for text in self.sent_early:
                stream.send(text)
            self.frames = stream.take_over(self.received.append, self.lost.append)

        config = uvicorn.Config(app, ws_max_size=SIZE_MAX, ws_per_message_deflate=False, lifespan="off")
        config.load()
        self.server = DirectWebsockets(config, ServerState(), {})
        self.client = ClientProtocol(parse_uri("ws://localhost/ws"), max_size=SIZE_MAX)

    async def open(self) -> None:
        self.server.connection_made(self.wire)
        self.client.send_request(self.client.connect())
        self.server.data_received(b"".join(self.client.data_to_send()))
        for _ in range(20):
            await asyncio.sleep(0)
        assert self.frames is not None
        if not self.lost_early:
            assert not self.wire.is_closing(), "the endpoint has returned, and the connection stays open"
        self.answers()

    def says(self, *frames: Frame) -> bytes:
        """The frames as the client's bytes, masked."""
        return b"".join(frame.serialize(mask=True) for frame in frames)

    def answers(self) -> list[Frame]:
        """What the server has sent since the last time."""
        data, self.wire.written = bytes(self.wire.written), bytearray()
        self.client.receive_data(data)
        return [event for event in self.client.events_received() if isinstance(event, Frame)]


def a_text(data: bytes) -> Frame:
    return Frame(Opcode.TEXT, data)


def taken_over(check: Callable[[TakenOver], None]) -> TakenOver:
    async def run() -> TakenOver:
        connection = TakenOver()
        await connection.open()
        check(connection)
        return connection

    return asyncio.run(run())


def test_frames_in_one_read_are_handed_on_in_order() -> None:
    texts = [b"one", b"", b"x" * 200, b"y" * 70_000, b"last"]
    connection = taken_over(lambda c: c.wire.protocol.data_received(c.says(*map(a_text, texts))))
    assert connection.received == texts


@pytest.mark.parametrize("piece", [1, 2, 5, 7, 64])
def test_frames_that_come_in_pieces_are_handed_on_whole(piece: int) -> None:
    texts = [b"one", b"x" * 300, b"last"]

    def in_pieces(connection: TakenOver) -> None:
        data = connection.says(*map(a_text, texts))
        for at in range(0, len(data), piece):
            connection.wire.protocol.data_received(data[at : at + piece])

    assert taken_over(in_pieces).received == texts


def test_a_fragmented_message_is_one_message_even_with_a_ping_between() -> None:
    def fragments(connection: TakenOver) -> None:
        frames = (
            Frame(Opcode.TEXT, b"be", fin=False),
            Frame(Opcode.PING, b"?"),
            Frame(Opcode.CONT, b"gin"),
            a_text(b"next"),
        )
        connection.wire.protocol.data_received(connection.says(*frames))
        assert [frame.opcode for frame in connection.answers()] == [Opcode.PONG]

    assert taken_over(fragments).received == [b"begin", b"next"]


def test_a_text_in_the_middle_of_a_fragmented_message_ends_the_connection() -> None:
    def intruding(connection: TakenOver) -> None:
        connection.wire.protocol.data_received(
            connection.says(Frame(Opcode.TEXT, b"be", fin=False), a_text(b"no"))
        )
        assert connection.wire.is_closing()

    assert taken_over(intruding).received == []


@pytest.mark.parametrize(
    "head",
    [
        struct.pack("!BB", 0x81, 3) + b"abcdef",
        struct.pack("!BBQ", 0x81, 0x80 | 127, SIZE_MAX + 1) + b"mask",
        struct.pack("!BB", 0x83, 0x80) + b"mask",
        struct.pack("!BB", 0xF1, 0x80) + b"mask",
    ],
    ids=["not masked", "too large", "unknown opcode", "reserved bits"],
)
def test_a_frame_that_breaks_the_websocket_protocol_ends_the_connection(head: bytes) -> None:
    def breaking(connection: TakenOver) -> None:
        connection.wire.protocol.data_received(head)
        assert connection.wire.is_closing()

    assert taken_over(breaking).received == []


def test_what_the_server_sends_arrives() -> None:
    texts = [b"a", b"b" * 125, b"c" * 126, b"d" * 70_000]

    def send(connection: TakenOver) -> None:
        assert connection.frames is not None
        for text in texts:
            connection.frames.send(text)
        assert [frame.data for frame in connection.answers()] == texts

    taken_over(send)


def test_what_the_endpoint_sends_before_it_hands_over_arrives() -> None:
    async def run() -> list[bytes]:
        connection = TakenOver()
        connection.sent_early = [b"challenge", b"x" * 200]
        connection.server.connection_made(connection.wire)
        connection.client.send_request(connection.client.connect())
        connection.server.data_received(b"".join(connection.client.data_to_send()))
        for _ in range(20):
            await asyncio.sleep(0)
        return [bytes(event.data) for event in connection.answers()]

    assert asyncio.run(run()) == [b"challenge", b"x" * 200]


def test_a_close_is_answered_and_told_once() -> None:
    def closing(connection: TakenOver) -> None:
        connection.wire.protocol.data_received(connection.says(Frame(Opcode.CLOSE, struct.pack("!H", 1000))))
        assert connection.wire.is_closing()
        connection.wire.protocol.connection_lost(None)

    assert taken_over(closing).lost == ["connection lost"]


def test_after_the_servers_close_nothing_more_is_handed_on() -> None:
    def closing(connection: TakenOver) -> None:
        assert connection.frames is not None
        connection.frames.close(4412, "superseded")
        connection.wire.protocol.data_received(connection.says(a_text(b"late")))
        (frame,) = connection.answers()
        assert frame.opcode is Opcode.CLOSE
        assert connection.client.close_rcvd is not None
        assert (connection.client.close_rcvd.code, connection.client.close_rcvd.reason) == (
            4412,
            "superseded",
        )

    assert taken_over(closing).received == []


def test_a_vehicle_that_does_not_read_is_closed_as_too_slow() -> None:
    def slow(connection: TakenOver) -> None:
        assert connection.frames is not None
        connection.wire.protocol.pause_writing()
        connection.wire.waiting_bytes = WAITING_BYTES_MAX + 1
        connection.frames.send(b"one more")
        connection.answers()
        assert connection.client.close_rcvd is not None
        assert connection.client.close_rcvd.reason == "too_slow"

    taken_over(slow)


def test_a_paused_connection_is_not_read() -> None:
    def pausing(connection: TakenOver) -> None:
        assert connection.frames is not None
        connection.frames.pause()
        assert connection.wire.is_paused
        connection.frames.resume()
        assert not connection.wire.is_paused

    taken_over(pausing)


def test_uvicorns_own_object_is_forgotten_and_the_connection_is_in_the_servers_list_until_it_ends() -> None:
    def ending(connection: TakenOver) -> None:
        listed = connection.server.connections
        assert listed == {connection.wire.protocol}
        connection.wire.protocol.connection_lost(None)
        assert listed == set()

    assert taken_over(ending).lost == ["connection lost"]


def test_a_server_that_ends_says_so_and_closes() -> None:
    def ending(connection: TakenOver) -> None:
        frames = connection.wire.protocol
        assert isinstance(frames, FrameConnection)
        frames.shutdown()
        connection.answers()
        assert connection.client.close_rcvd is not None
        assert connection.client.close_rcvd.code == 1012
        assert connection.wire.is_closing()

    taken_over(ending)


def quiet_connection(answer: Callable[[FrameConnection], None]) -> bytes:
    """What a connection writes to a peer that says nothing, until it has closed or was written to thrice."""

    async def run() -> bytes:
        wire = Wire()
        frames = FrameConnection(wire, SIZE_MAX, QuietWatch(0.001), lambda _: None, lambda *_: None)
        written = b""
        for _ in range(3):
            if wire.is_closing():
                break
            await wire.something_happened.wait()
            wire.something_happened.clear()
            written += bytes(wire.written)
            wire.written.clear()
            if not wire.is_closing():
                answer(frames)
        frames.connection_lost(None)
        return written

    return asyncio.run(asyncio.wait_for(run(), 10.0))


def test_a_quiet_peer_is_pinged_and_then_closed() -> None:
    written = quiet_connection(lambda _: None)
    assert written[:2] == b"\x89\x00"
    assert written[2:4] == bytes((0x88, len(written) - 4)), "one ping, then the close"
    assert b"keepalive" in written


def test_a_quiet_peer_that_answers_pings_stays_connected() -> None:
    pong = Frame(Opcode.PONG, b"").serialize(mask=True)
    assert quiet_connection(lambda frames: frames.data_received(pong)) == b"\x89\x00" * 3


def test_a_peer_that_closes_and_does_not_read_the_rest_is_cut_off(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(frame_connection, "CLOSE_WITHIN_S", 0.001)

    async def run() -> None:
        wire = Wire()
        frames = FrameConnection(wire, SIZE_MAX, None, lambda _: None, lambda *_: None)
        frames.data_received(Frame(Opcode.CLOSE, struct.pack("!H", 1000)).serialize(mask=True))
        while not wire.is_aborted:
            wire.something_happened.clear()
            await wire.something_happened.wait()

    asyncio.run(asyncio.wait_for(run(), 10.0))


def test_a_connection_that_is_lost_before_it_is_taken_over_is_told() -> None:
    async def run() -> list[str]:
        connection = TakenOver()
        connection.lost_early = True
        await connection.open()
        return connection.lost

    assert asyncio.run(run()) == ["connection lost"]

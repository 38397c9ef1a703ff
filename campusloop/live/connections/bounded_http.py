"""uvicorn's protocols with limits that they lack: length of a head, slow senders, connections of a client."""

import asyncio
from collections.abc import Callable
from functools import partial
from http import HTTPStatus

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from campusloop.live.connections.direct_websockets import DirectWebsockets
from server.api.security.connection_counts import ConnectionCounts

# Request line and headers together: browsers send 1 to 4 KiB; other servers allow 8 to 64.
HEAD_BYTES_MAX = 32 * 1024
# A head has to be complete so soon after the connection or the request began.
HEAD_WITHIN_S = 10.0
# A body that stops for longer is given up.
BODY_PAUSE_S_MAX = 20.0


class BoundedHttp(HttpToolsProtocol):
    """A connection that sends an endless head, half a head, or half a body is answered and closed.

    counts  None for no limit of connections
    """

    counts: ConnectionCounts | None = None
    _is_counted = False
    _in_head = True
    _head_bytes = 0
    _deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)  # type: ignore[arg-type]
        if self.counts is not None and self.client is not None:
            self._is_counted = self.counts.opened(self.client[0])
            if not self._is_counted:
                # Without an answer: who opens hundreds does not read it.
                transport.abort()  # type: ignore[attr-defined]
                return
        self._expect_more_within(HEAD_WITHIN_S)

    def connection_lost(self, exc: Exception | None) -> None:
        self._expect_nothing()
        self._end_count()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        # Only what did not complete a head counts: a body may come with its head in one piece.
        if self._in_head:
            self._head_bytes += len(data)
            if self._head_bytes > HEAD_BYTES_MAX:
                self._refuse(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE)

    def on_message_begin(self) -> None:
        self._in_head, self._head_bytes = True, 0
        self._expect_more_within(HEAD_WITHIN_S)
        super().on_message_begin()

    def on_headers_complete(self) -> None:
        self._in_head = False
        self._expect_more_within(BODY_PAUSE_S_MAX)
        super().on_headers_complete()

    def on_body(self, body: bytes) -> None:
        self._expect_more_within(BODY_PAUSE_S_MAX)
        super().on_body(body)

    def on_message_complete(self) -> None:
        self._expect_nothing()
        super().on_message_complete()

    def handle_websocket_upgrade(self) -> None:
        self._expect_nothing()
        # From here on the websocket's protocol has the connection.
        self._end_count()
        super().handle_websocket_upgrade()

    def _end_count(self) -> None:
        if self._is_counted and self.counts is not None and self.client is not None:
            self._is_counted = False
            self.counts.closed(self.client[0])

    def _expect_more_within(self, seconds: float) -> None:
        self._expect_nothing()
        self._deadline = self.loop.call_later(seconds, self._waited)

    def _expect_nothing(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _waited(self) -> None:
        """Nothing more came in time; unless it is this server that does not read."""
        if self.flow.read_paused:
            self._expect_more_within(BODY_PAUSE_S_MAX)
        else:
            self._refuse(HTTPStatus.REQUEST_TIMEOUT)

    def _refuse(self, status: HTTPStatus) -> None:
        self._expect_nothing()
        if not self.transport.is_closing():
            lines = (f"HTTP/1.1 {status.value} {status.phrase}", "content-length: 0", "connection: close")
            self.transport.write("".join(f"{line}\r\n" for line in (*lines, "")).encode())
            self.transport.close()


class CountedWebSocket(DirectWebsockets):
    """Counted together with the client's other connections."""

    counts: ConnectionCounts | None = None
    _is_counted = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        if self.counts is not None and self.client is not None:
            self._is_counted = self.counts.opened(self.client[0])

    def connection_lost(self, exc: Exception | None) -> None:
        if self._is_counted and self.counts is not None and self.client is not None:
            self._is_counted = False
            self.counts.closed(self.client[0])
        super().connection_lost(exc)

    def end_bookkeeping(self) -> Callable[[], None]:
        if not self._is_counted or self.counts is None or self.client is None:
            return super().end_bookkeeping()
        self._is_counted = False
        return partial(self.counts.closed, self.client[0])


def counted_protocols(counts: ConnectionCounts) -> tuple[type[BoundedHttp], type[CountedWebSocket]]:
    """The protocols of one server, which makes them itself and gives them nothing of ours."""
    return (
        type("ServerHttp", (BoundedHttp,), {"counts": counts}),
        type("ServerWebSocket", (CountedWebSocket,), {"counts": counts}),
    )

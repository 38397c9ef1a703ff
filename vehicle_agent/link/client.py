"""The websocket shell around vehicle sessions: dials, moves bytes, waits, and dials again.

One process may serve any number of vehicles; each has its own desk, connection and patience.
"""

import asyncio
import ssl
from collections.abc import Callable

import structlog
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidURI

from contract.wire.codec import MAX_MESSAGE_BYTES, WireError
from vehicle_agent.link.bridge import LinkBridge
from vehicle_agent.signals import LinkMessage

log = structlog.get_logger()

FIRST_WAIT_S = 0.5
LONGEST_WAIT_S = 15.0
ELAPSED_EVERY_S = 1.0

Monotonic = Callable[[], int]
Deliver = Callable[[LinkMessage], None]


class LinkClient:
    """Keeps one vehicle connected. `deliver` takes what the vehicle has to learn, in order."""

    def __init__(
        self,
        url: str,
        desk: LinkBridge,
        deliver: Deliver,
        now_ns: Monotonic,
        tls: ssl.SSLContext | None = None,
    ) -> None:
        self._url = url
        self._desk = desk
        self._deliver = deliver
        self._now_ns = now_ns
        self._tls = tls
        self._to_send = asyncio.Event()
        self._redial = False

    def wake(self) -> None:
        """The desk has something to send."""
        self._to_send.set()

    def redial(self) -> None:
        """Give up the connection for a new one, whose hello says what the vehicle holds by then."""
        self._redial = True
        self._to_send.set()

    async def run(self) -> None:
        """Until cancelled. Waits longer after each failure, and starts over after a good connection."""
        wait_s = FIRST_WAIT_S
        vehicle_id = self._desk.session.identity.vehicle_id
        while True:
            welcomed = False
            try:
                async with connect(
                    self._url, ssl=self._tls, compression=None, max_size=MAX_MESSAGE_BYTES, open_timeout=10
                ) as socket:
                    welcomed = await self._converse(socket)
            except (OSError, TimeoutError, InvalidHandshake, InvalidURI) as error:
                log.warning("link.unreachable", vehicle_id=vehicle_id, url=self._url, error=str(error))
            self._ended(vehicle_id)
            wait_s = next_wait_s(wait_s, welcomed=welcomed)
            await asyncio.sleep(wait_s)

    def _ended(self, vehicle_id: str) -> None:
        session = self._desk.session
        refusal = session.refusal
        session.disconnected(self._now_ns())
        self._deliver_words()
        if refusal is not None:
            log.error("link.refused", vehicle_id=vehicle_id, code=refusal.code, detail=refusal.detail)

    async def _converse(self, socket: ClientConnection) -> bool:
        """One connection from its first byte to its last; whether the server welcomed us on it."""
        session = self._desk.session
        session.connected(self._now_ns())
        sender = asyncio.create_task(self._send_all(socket))
        welcomed = False
        try:
            async for data in socket:
                session.received(data, self._now_ns())
                welcomed = welcomed or session.is_open
                self._deliver_words()
                self.wake()
        except ConnectionClosed as closed:
            log.info("link.closed", vehicle_id=session.identity.vehicle_id, reason=str(closed))
        except WireError as error:
            log.error("link.not_understood", vehicle_id=session.identity.vehicle_id, detail=error.detail)
        finally:
            sender.cancel()
            await asyncio.gather(sender, return_exceptions=True)
        return welcomed

    async def _send_all(self, socket: ClientConnection) -> None:
        """Send whatever the session has, when woken and once a second."""
        session = self._desk.session
        self._redial = False
        while True:
            if self._redial:
                await socket.close(1000, "the vehicle has started anew")
                return
            session.elapsed(self._now_ns())
            if session.is_silent(self._now_ns()):
                await socket.close(1001, "nothing heard")
                return
            for frame in session.take_outgoing():
                await socket.send(frame.decode())
            self._to_send.clear()
            try:
                async with asyncio.timeout(ELAPSED_EVERY_S):
                    await self._to_send.wait()
            except TimeoutError:
                continue

    def _deliver_words(self) -> None:
        for word in self._desk.take_words():
            self._deliver(word)


def next_wait_s(wait_s: float, *, welcomed: bool) -> float:
    """How long to wait before the next connection: twice as long after a failure, short after a welcome."""
    return FIRST_WAIT_S if welcomed else min(2.0 * wait_s, LONGEST_WAIT_S)

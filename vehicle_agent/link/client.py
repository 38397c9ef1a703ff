"""The websocket shell around a vehicle session: connects, moves bytes, waits, and connects again.

One process may serve any number of vehicles; each has its own bridge, connection and waiting time.
"""

import asyncio
import random
import ssl
from collections.abc import Callable

import structlog
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidURI

from contract.wire.close_reasons import Retry, retry_after
from contract.wire.codec import MAX_MESSAGE_BYTES, WireError
from contract.wire.messages import LocalizationMapPublished, MapPublished, ScansRequested
from vehicle_agent.link.bridge import LinkBridge
from vehicle_agent.link.redial import Redial
from vehicle_agent.signals import LinkMessage

log = structlog.get_logger()

ELAPSED_EVERY_S = 1.0

Monotonic = Callable[[], int]
Deliver = Callable[[LinkMessage], None]


class LinkClient:
    """Keeps one vehicle connected. `deliver` receives the messages for the vehicle, in order."""

    def __init__(
        self,
        url: str,
        bridge: LinkBridge,
        deliver: Deliver,
        now_ns: Monotonic,
        tls: ssl.SSLContext | None = None,
        redial: Redial | None = None,
        map_published: Callable[[MapPublished], None] | None = None,
        localization_map_published: Callable[[LocalizationMapPublished], None] | None = None,
        scans_requested: Callable[[ScansRequested], None] | None = None,
    ) -> None:
        """redial: None for waits that the operating system's chance spreads

        map_published, localization_map_published: take the server's announcements; None for a vehicle whose
        map never changes, or that has none
        scans_requested: takes the requests for scans; None for a vehicle that keeps none
        """
        self._map_published = map_published
        self._localization_map_published = localization_map_published
        self._scans_requested = scans_requested
        self._url = url
        self._redial = redial or Redial(random.random)
        self._bridge = bridge
        self._deliver = deliver
        self._now_ns = now_ns
        self._tls = tls
        self._has_outgoing = asyncio.Event()
        self._must_reconnect = False
        self._was_welcomed = False

    def wake(self) -> None:
        """Wakes the sender: the bridge has something to send."""
        self._has_outgoing.set()

    def reconnect(self) -> None:
        """Closes the connection and opens a new one, whose hello has the vehicle's present state."""
        self._must_reconnect = True
        self._has_outgoing.set()

    async def run(self) -> None:
        """Runs until cancelled. Waits longer after each failure, and starts over after a good connection."""
        vehicle_id = self._bridge.session.identity.vehicle_id
        while True:
            was_welcomed, failure = False, ""
            try:
                async with connect(
                    self._url, ssl=self._tls, compression=None, max_size=MAX_MESSAGE_BYTES, open_timeout=10
                ) as socket:
                    was_welcomed = await self._run_connection(socket)
            except (OSError, TimeoutError, InvalidHandshake, InvalidURI) as error:
                failure = str(error) or type(error).__name__
            retry = self._end_session(vehicle_id)
            wait_s = self._redial.wait_s(was_welcomed=was_welcomed, retry=retry)
            if failure:
                log.warning(
                    "link.unreachable", vehicle_id=vehicle_id, url=self._url, error=failure, retry_s=wait_s
                )
            await asyncio.sleep(wait_s)

    def _end_session(self, vehicle_id: str) -> Retry:
        """What the server advised when it closed the connection; "later" if it said nothing."""
        session = self._bridge.session
        refusal = session.refusal
        session.disconnected(self._now_ns())
        self._deliver_messages()
        if refusal is None:
            return "later"
        retry = retry_after(refusal.code)
        tell = log.info if retry == "at_once" else log.error
        tell("link.refused", vehicle_id=vehicle_id, code=refusal.code, detail=refusal.detail)
        return retry

    async def _run_connection(self, socket: ClientConnection) -> bool:
        """Runs one connection to its end; True if the server welcomed the vehicle on it."""
        session = self._bridge.session
        session.connected(self._now_ns())
        self._was_welcomed = False
        both = {
            asyncio.create_task(self._send_all(socket)),
            asyncio.create_task(self._receive_all(socket)),
        }
        try:
            # A connection on which one direction has ended is of no use to the other one.
            ended, _ = await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in both:
                task.cancel()
            await asyncio.wait(both)
        vehicle_id = session.identity.vehicle_id
        for task in ended:
            try:
                task.result()
            except ConnectionClosed as closed:
                log.info("link.closed", vehicle_id=vehicle_id, reason=str(closed))
            except WireError as error:
                log.error("link.not_understood", vehicle_id=vehicle_id, detail=error.detail)
        return self._was_welcomed

    async def _receive_all(self, socket: ClientConnection) -> None:
        session = self._bridge.session
        async for data in socket:
            session.received(data, self._now_ns())
            self._was_welcomed = self._was_welcomed or session.is_open
            self._deliver_messages()
            self.wake()

    async def _send_all(self, socket: ClientConnection) -> None:
        """Sends the session's frames, when woken and once a second."""
        session = self._bridge.session
        self._must_reconnect = False
        while True:
            if self._must_reconnect:
                await socket.close(1000, "the vehicle has started anew")
                return
            session.advance(self._now_ns())
            if session.is_silent(self._now_ns()):
                await socket.close(1001, "nothing heard")
                return
            for frame in session.take_outgoing():
                await socket.send(frame.decode())
            self._has_outgoing.clear()
            try:
                async with asyncio.timeout(ELAPSED_EVERY_S):
                    await self._has_outgoing.wait()
            except TimeoutError:
                continue

    def _deliver_messages(self) -> None:
        for message in self._bridge.session.take_messages():
            self._deliver(message)
        published = self._bridge.session.take_published_map()
        if published is not None and self._map_published is not None:
            self._map_published(published)
        scans = self._bridge.session.take_scan_requests()
        if scans is not None and self._scans_requested is not None:
            self._scans_requested(scans)
        by_scans = self._bridge.session.take_published_localization_map()
        if by_scans is not None and self._localization_map_published is not None:
            self._localization_map_published(by_scans)

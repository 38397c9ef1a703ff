"""Presence reports on their way to the server, and to vehicles on their own network."""

import asyncio
import contextlib
import socket
import ssl
from collections.abc import Callable

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidMessage

from contract.wire.codec import encode
from contract.wire.messages import PresenceReport

REDIAL_S = 2.0
# Older words say nothing about a crossing any more; two seconds of seven cameras at 5 Hz.
WAITING_MAX = 70


class ReportLink:
    """Sends reports to the server's /ws/infrastructure until cancelled, and dials again when it must.

    A report that finds no connection is lost: an old one would be wrong.
    """

    def __init__(
        self, origin: str, token: str, tls: ssl.SSLContext | None, tell: Callable[[str], None]
    ) -> None:
        """origin: of the server, http or https; token: with the scope `infrastructure`; tell: failures."""
        self._url = origin.rstrip("/").replace("http", "ws", 1) + "/ws/infrastructure"
        self._token, self._tls, self._tell = token, tls, tell
        self._waiting: asyncio.Queue[PresenceReport] = asyncio.Queue(WAITING_MAX)

    def put(self, report: PresenceReport) -> None:
        """Send a report; the oldest one that waits is dropped when there are too many."""
        with contextlib.suppress(asyncio.QueueEmpty):
            if self._waiting.full():
                self._waiting.get_nowait()
        self._waiting.put_nowait(report)

    async def run(self) -> None:
        while True:
            await self._forward()
            await asyncio.sleep(REDIAL_S)

    async def _forward(self) -> None:
        """One connection, until it ends."""
        try:
            async with connect(
                self._url, ssl=self._tls, additional_headers={"Authorization": f"Bearer {self._token}"}
            ) as connection:
                await self._send(connection)
        except (OSError, TimeoutError, ConnectionClosed, InvalidHandshake, InvalidMessage) as error:
            self._tell(f"the crossings' cameras cannot reach the server: {error}")

    async def _send(self, connection: ClientConnection) -> None:
        refusals = asyncio.create_task(self._tell_refusals(connection))
        try:
            while True:
                await connection.send(encode(await self._waiting.get()).decode())
        finally:
            refusals.cancel()
            await asyncio.gather(refusals, return_exceptions=True)

    async def _tell_refusals(self, connection: ClientConnection) -> None:
        async for refusal in connection:
            self._tell(f"the server refused a camera's report: {refusal!r}")


class VehicleDatagrams:
    """Sends each report to one vehicle as a datagram (docs/vehicle/world.md, Infrastructure)."""

    def __init__(self, address: str) -> None:
        """address: HOST:PORT. Raises ValueError for another form."""
        host, _, port = address.rpartition(":")
        if not host or not port.isdecimal() or not 0 < int(port) < 65536:
            raise ValueError(f"give HOST:PORT of the vehicle, not {address!r}")
        self._address = (host, int(port))
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)

    def put(self, report: PresenceReport) -> None:
        """Send a report; one that cannot be sent now is lost, and the next one follows soon."""
        with contextlib.suppress(OSError):
            self._socket.sendto(encode(report), self._address)

    def close(self) -> None:
        self._socket.close()

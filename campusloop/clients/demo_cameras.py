"""The demo's cameras: what the simulated ones see at crossings goes to the server as from real ones."""

import asyncio
import ssl
from collections.abc import Callable
from typing import Any

import httpx

from campusloop.clients.operator_client import OperatorClient, OperatorError
from campusloop.crossing_cameras.report_link import ReportLink
from contract.wire.messages import PresenceReport
from simulator.control import CameraReported, Subscribe, decode_from_simulation, encode

HOST = "127.0.0.1"
# The name of the token that they share.
CAMERA_TOKEN = "cameras-at-crossings"
SUBSCRIBE_EVERY_S = 5.0
TOKEN_EVERY_S = 10.0


async def camera_token(
    operator: OperatorClient, report: Callable[[str], None], every_s: float = TOKEN_EVERY_S
) -> str:
    """The secret that the cameras share, asked for until the server gives it.

    Without it they see nothing, and the shuttles are slow at crossings; that is no reason to stop them.
    """
    while True:
        try:
            return await operator.make_token(CAMERA_TOKEN, "infrastructure")
        except (httpx.TransportError, OperatorError) as error:
            report(f"the crossings' cameras wait, for the server gives them no token: {error}")
        await asyncio.sleep(every_s)


class DemoCameras:
    """Forwards reports until cancelled. A report that finds no connection is lost, as a real camera's."""

    def __init__(
        self, origin: str, token: str, tls: ssl.SSLContext | None, port: int, report: Callable[[str], None]
    ) -> None:
        """origin: of the server; port: the simulation's control port; report: is called with each failure."""
        self._link = ReportLink(origin, token, tls, report)
        self._port = port

    async def run(self) -> None:
        loop = asyncio.get_running_loop()
        transport, _ = await loop.create_datagram_endpoint(
            lambda: _CameraReceiver(self._link), remote_addr=(HOST, self._port)
        )
        subscribing = asyncio.create_task(_subscribe(transport))
        try:
            await self._link.run()
        finally:
            subscribing.cancel()
            await asyncio.gather(subscribing, return_exceptions=True)
            transport.close()


async def _subscribe(transport: asyncio.DatagramTransport) -> None:
    """Repeated, because a restarted simulation has lost the subscription."""
    while True:
        transport.sendto(encode(Subscribe()))
        await asyncio.sleep(SUBSCRIBE_EVERY_S)


class _CameraReceiver(asyncio.DatagramProtocol):
    def __init__(self, link: ReportLink) -> None:
        self._link = link

    def datagram_received(self, data: bytes, addr: tuple[str | Any, int]) -> None:
        message = decode_from_simulation(data)
        if isinstance(message, CameraReported):
            self._link.put(PresenceReport(message.area_id, message.count, message.age_s))

    def error_received(self, exc: Exception) -> None:
        """The simulation is not there yet, or has gone; the subscription is repeated."""

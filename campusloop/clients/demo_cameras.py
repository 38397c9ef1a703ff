"""The demo's cameras: what the simulated ones see at crossings goes to the server as from real ones."""

import asyncio
import contextlib
import ssl
from collections.abc import Callable
from typing import Any

import httpx
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidMessage

from campusloop.clients.operator_client import OperatorClient, OperatorError
from contract.wire.codec import encode as encode_wire
from contract.wire.messages import PresenceReport
from simulator.control import CameraReported, Subscribe, decode_from_simulation, encode

HOST = "127.0.0.1"
# The name of the token that they share.
CAMERA_TOKEN = "cameras-at-crossings"
SUBSCRIBE_EVERY_S = 5.0
REDIAL_S = 2.0
TOKEN_EVERY_S = 10.0
# Older words say nothing about a crossing any more; two seconds of seven cameras at 5 Hz.
WAITING_MAX = 70


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
        self._url = origin.replace("http", "ws", 1) + "/ws/infrastructure"
        self._token, self._tls, self._port, self._report = token, tls, port, report
        self._waiting: asyncio.Queue[PresenceReport] = asyncio.Queue(WAITING_MAX)

    async def run(self) -> None:
        loop = asyncio.get_running_loop()
        transport, _ = await loop.create_datagram_endpoint(
            lambda: _CameraReceiver(self._waiting), remote_addr=(HOST, self._port)
        )
        subscribing = asyncio.create_task(_subscribe(transport))
        try:
            while True:
                await self._forward()
                await asyncio.sleep(REDIAL_S)
        finally:
            subscribing.cancel()
            await asyncio.gather(subscribing, return_exceptions=True)
            transport.close()

    async def _forward(self) -> None:
        """One connection, until it ends."""
        try:
            async with connect(
                self._url, ssl=self._tls, additional_headers={"Authorization": f"Bearer {self._token}"}
            ) as socket:
                await self._send(socket)
        except (OSError, TimeoutError, ConnectionClosed, InvalidHandshake, InvalidMessage) as error:
            self._report(f"the crossings' cameras cannot reach the server: {error}")

    async def _send(self, socket: ClientConnection) -> None:
        refusals = asyncio.create_task(self._tell_refusals(socket))
        try:
            while True:
                await socket.send(encode_wire(await self._waiting.get()).decode())
        finally:
            refusals.cancel()
            await asyncio.gather(refusals, return_exceptions=True)

    async def _tell_refusals(self, socket: ClientConnection) -> None:
        async for refusal in socket:
            self._report(f"the server refused a camera's report: {refusal!r}")


async def _subscribe(transport: asyncio.DatagramTransport) -> None:
    """Repeated, because a restarted simulation has lost the subscription."""
    while True:
        transport.sendto(encode(Subscribe()))
        await asyncio.sleep(SUBSCRIBE_EVERY_S)


class _CameraReceiver(asyncio.DatagramProtocol):
    def __init__(self, waiting: "asyncio.Queue[PresenceReport]") -> None:
        self._waiting = waiting

    def datagram_received(self, data: bytes, addr: tuple[str | Any, int]) -> None:
        message = decode_from_simulation(data)
        if not isinstance(message, CameraReported):
            return
        with contextlib.suppress(asyncio.QueueEmpty):
            if self._waiting.full():
                self._waiting.get_nowait()
        self._waiting.put_nowait(PresenceReport(message.area_id, message.count, message.age_s))

    def error_received(self, exc: Exception) -> None:
        """The simulation is not there yet, or has gone; the subscription is repeated."""

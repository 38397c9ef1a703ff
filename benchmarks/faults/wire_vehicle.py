"""A vehicle on the real link: it stands at a resting place, and may say what no vehicle should say."""

import asyncio
import base64
from dataclasses import dataclass, field

import msgspec
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from benchmarks.faults.installation import Installation
from contract.geometry import Pose2
from contract.roads.network import RoadNetwork
from contract.wire.codec import decode_from_server, encode
from contract.wire.messages import (
    Challenge,
    EventReport,
    EventsAcknowledged,
    Goodbye,
    Hello,
    Message,
    ModeChanged,
    Order,
    OrderAccepted,
    ServerMessage,
    Status,
    VehicleEvent,
    Welcome,
    signed_hello,
)

STATUS_EVERY_S = 0.2
REDIAL_AFTER_S = 0.5
SESSION_WITHIN_S = 60.0


@dataclass
class WireVehicle:
    """`run` keeps it connected.

    orders        as they came; goodbyes: the codes with which the server closed; hellos: how many it said
    acknowledged  so many of its events, the first ones
    port          that it dials; None: the server's
    """

    installation: Installation
    network: RoadNetwork
    vehicle_id: str
    resting_place: int
    boot_id: str = "boot-1"
    key: Ed25519PrivateKey = field(default_factory=Ed25519PrivateKey.generate)
    seats: int = 6
    orders: list[Order] = field(default_factory=list)
    goodbyes: list[str] = field(default_factory=list)
    epoch: int = 0
    sequence: int = 0
    acknowledged: int = 0
    hellos: int = 0
    events: list[VehicleEvent] = field(default_factory=lambda: [ModeChanged("autonomous", detail="resumed")])
    port: int | None = None
    _socket: ClientConnection | None = None

    async def enrol(self) -> None:
        public = base64.b64encode(self.key.public_key().public_bytes_raw()).decode()
        await self.installation.enrol(self.vehicle_id, public)

    async def run(self) -> None:
        while True:
            try:
                url = f"ws://127.0.0.1:{self.port or self.installation.port}/ws/vehicle"
                async with connect(url, open_timeout=10) as socket:
                    await self._converse(socket)
            except (OSError, TimeoutError, ConnectionClosed, EOFError):
                pass
            self._socket, self.epoch = None, 0
            await asyncio.sleep(REDIAL_AFTER_S)

    async def until_served(self, within_s: float = 60.0) -> None:
        """Until the operator's list says that it is connected, placed and not held."""
        async with asyncio.timeout(within_s):
            while True:
                vehicle = await self.installation.ask("GET", f"/vehicles/{self.vehicle_id}")
                if vehicle["connected"] and vehicle["placed"] and not vehicle["held"]:
                    return
                await asyncio.sleep(0.2)

    async def say(self, message: Message) -> None:
        await self.say_raw(encode(message))

    async def say_raw(self, data: bytes) -> None:
        """Waits for an open session. What is lost with a connection is not said again."""
        await (await self._open_socket()).send(data.decode())

    async def cut(self) -> None:
        """Cut the connection without a farewell; `run` dials again."""
        (await self._open_socket()).transport.abort()
        self._socket = None

    async def redial(self) -> None:
        """Cut the connection, and wait until a new one is served."""
        await self.cut()
        self.epoch = 0
        await self._open_socket()
        await self.until_served()

    async def freeze(self, seconds: float) -> None:
        """Read nothing for so long."""
        transport = (await self._open_socket()).transport
        transport.pause_reading()
        await asyncio.sleep(seconds)
        if not transport.is_closing():
            transport.resume_reading()

    def report(self, event: VehicleEvent) -> None:
        """Kept, in order, until the server has acknowledged it."""
        self.events.append(event)

    async def send_events(self, socket: ClientConnection | None = None) -> None:
        """Those that are not sent yet. socket: None for the present one"""
        socket = socket or await self._open_socket()
        for event in self.events[self.sequence :]:
            report = EventReport(self.epoch, self.boot_id, self.sequence, self.sequence + 1, event)
            self.sequence += 1
            await socket.send(encode(report).decode())

    def status(self) -> Status:
        place = self.network.road_map.resting_places[self.resting_place]
        pose = Pose2(*self.network.pose(place.lane_id, place.s_m))
        return Status(
            self.epoch, 1, pose, 0.0, 0.0, 0.0, "autonomous", 0.9, False, place.lane_id, place.s_m, "", 0, ""
        )

    def sign(self, text: bytes) -> str:
        return base64.b64encode(self.key.sign(text)).decode()

    def hello(self, nonce: str) -> Hello:
        text = signed_hello(nonce, self.vehicle_id, self.boot_id, 1)
        return Hello(
            protocol=1,
            vehicle_id=self.vehicle_id,
            boot_id=self.boot_id,
            nonce=nonce,
            signature=self.sign(text),
            software="faults",
            stack="none",
            map_version=self.network.map_version,
            vehicle_ns=1,
            seats=self.seats,
        )

    async def _open_socket(self) -> ClientConnection:
        async with asyncio.timeout(SESSION_WITHIN_S):
            while self._socket is None or not self.epoch:  # noqa: ASYNC110 - it comes over a socket
                await asyncio.sleep(0.05)
        return self._socket

    async def _converse(self, socket: ClientConnection) -> None:
        reporting = asyncio.create_task(self._report_status(socket))
        try:
            async for data in socket:
                await self._heard(socket, decode_from_server(data))
        finally:
            reporting.cancel()

    async def _heard(self, socket: ClientConnection, message: ServerMessage) -> None:
        if isinstance(message, Challenge):
            await socket.send(encode(self.hello(message.nonce)).decode())
            self.hellos += 1
        elif isinstance(message, Welcome):
            stored = {log.boot_id: log.first_unacknowledged for log in message.acknowledged}
            self.epoch, self.sequence = message.epoch, stored.get(self.boot_id, 0)
            self.acknowledged = max(self.acknowledged, self.sequence)
            self._socket = socket
        elif isinstance(message, Order):
            self.orders.append(message)
            await socket.send(encode(OrderAccepted(self.epoch, message.order_id, message.revision)).decode())
        elif isinstance(message, EventsAcknowledged):
            self.acknowledged = max(self.acknowledged, message.next_sequence)
        elif isinstance(message, Goodbye):
            self.goodbyes.append(message.code)

    async def _report_status(self, socket: ClientConnection) -> None:
        while True:
            await asyncio.sleep(STATUS_EVERY_S)
            if self._socket is not socket:
                continue
            await self.send_events(socket)
            await socket.send(encode(self.status()).decode())


def with_value(message: Message, field_name: str, value: bytes) -> bytes:
    """The message with another JSON value in one field, which no encoder would write."""
    fields = msgspec.json.decode(encode(message), type=dict[str, msgspec.Raw])
    return msgspec.json.encode(fields | {field_name: msgspec.Raw(value)})

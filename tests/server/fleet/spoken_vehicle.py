"""A vehicle that says what the test tells it to, over an in-memory pipe."""

from typing import TypeVar

import msgspec

from campusloop.virtual.pipes import Pipe
from contract.geometry import Pose2
from contract.wire.codec import decode_from_server, encode
from contract.wire.messages import (
    LATER_KINDS,
    Challenge,
    EventLogState,
    EventReport,
    EventsAcknowledged,
    Goodbye,
    Message,
    ServerMessage,
    Status,
    VehicleEvent,
    Welcome,
)
from server.fleet.hub import Hub
from server.fleet.link import Link
from tests.server.api.server_under_test import ServerUnderTest, snow_lion
from tests.server.fleet.vehicle_key import VehicleKeyPair, a_hello

M = TypeVar("M", bound=Message)


class PipeTransport:
    def __init__(self, pipe: Pipe) -> None:
        self._pipe = pipe

    def send(self, data: bytes) -> None:
        self._pipe.right.send(data)

    def close(self, code: int, reason: str) -> None:
        self._pipe.right.close(f"{code} {reason}")


class SpokenVehicle:
    """One connection of one boot."""

    def __init__(
        self, server: ServerUnderTest, vehicle_id: str = "shuttle-1", boot_id: str = "boot-1"
    ) -> None:
        self.vehicle_id, self.boot_id = vehicle_id, boot_id
        self.heard: list[ServerMessage] = []
        self.closed = ""
        self._server = server
        self._pipes = getattr(server, "pipes_made", 0) + 1
        server.pipes_made = self._pipes  # type: ignore[attr-defined]
        self.pipe = Pipe(server.conductor, f"{vehicle_id}/{boot_id}/{self._pipes}")
        self.pipe.left.on_message = lambda data: self.heard.append(decode_from_server(data))
        self.pipe.left.on_close = self._on_close

    def dial(self) -> "SpokenVehicle":
        server = self._server
        self.link: Link = server.run(_attach(server.hub, PipeTransport(self.pipe)))
        self.pipe.right.on_message = self.link.received
        self.pipe.right.on_close = self.link.closed
        server.elapse(0.2)
        return self

    def hello(
        self,
        logs: tuple[EventLogState, ...] = (),
        protocol: int = 1,
        understands: tuple[str, ...] = LATER_KINDS,
        **fields: object,
    ) -> "SpokenVehicle":
        """fields: of the hello, which its signature does not cover"""
        hello = a_hello(
            self.last(Challenge).nonce,
            self.vehicle_id,
            self.boot_id,
            VehicleKeyPair(self.vehicle_id),
            protocol,
            snow_lion().map_version,
            logs,
            understands,
        )
        self.say(msgspec.structs.replace(hello, **fields))
        return self

    def say(self, message: Message | bytes) -> None:
        self.pipe.left.send(message if isinstance(message, bytes) else encode(message))
        self._server.elapse(0.4)

    @property
    def epoch(self) -> int:
        return self.last(Welcome).epoch

    def event(self, sequence: int, body: VehicleEvent, boot_id: str = "") -> None:
        self.say(EventReport(self.epoch, boot_id or self.boot_id, sequence, 1_000 + sequence, body))

    def status(self, x_m: float, y_m: float, yaw_rad: float, **changes: object) -> None:
        fields: dict[str, object] = {
            "speed_mps": 0.0,
            "accel_mps2": 0.0,
            "steer_rad": 0.0,
            "mode": "autonomous",
            "battery_ratio": 0.9,
            "doors_open": False,
            "lane_id": "",
            "s_m": 0.0,
            "order_id": "",
            "revision": 0,
            "visit_id": "",
        }
        fields |= changes
        self.say(Status(epoch=self.epoch, stamp_ns=5, pose_map=Pose2(x_m, y_m, yaw_rad), **fields))  # type: ignore[arg-type]

    def all(self, kind: type[M]) -> list[M]:
        return [message for message in self.heard if isinstance(message, kind)]

    def last(self, kind: type[M]) -> M:
        return self.all(kind)[-1]

    @property
    def goodbye(self) -> str:
        """The code of the goodbye, "" when there was none."""
        said = self.all(Goodbye)
        return said[-1].code if said else ""

    @property
    def acknowledged(self) -> list[tuple[str, int]]:
        return [(ack.boot_id, ack.next_sequence) for ack in self.all(EventsAcknowledged)]

    def _on_close(self, reason: str) -> None:
        self.closed = reason


async def _attach(hub: Hub, transport: PipeTransport) -> Link:
    return hub.attach(transport)

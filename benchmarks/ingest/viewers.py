"""Operators' screens: each one watches the whole campus, and reads what comes."""

import time
from array import array

import msgspec

from benchmarks.ingest.connections import Connection
from benchmarks.ingest.load import Sockets
from benchmarks.ingest.served import Served

_WATCH = b'{"type":"watch"}'


class _VehicleHeard(msgspec.Struct):
    vehicle_id: str
    heard_ms: int = 0


class _Delta(msgspec.Struct):
    type: str
    at_ms: int = 0
    vehicles: tuple[_VehicleHeard, ...] = ()


_decoder = msgspec.json.Decoder(_Delta)


class ViewerConnection(Connection):
    """ages_s  of each vehicle in each message that was read closely: since the server heard its status"""

    def __init__(self, port: int, cookie: str, reads_closely: bool) -> None:
        super().__init__(port, "/ws/live", cookie)
        self.messages = 0
        self.bytes = 0
        self.ages_s = array("d")
        self._reads_closely = reads_closely
        self._heard_ms: dict[str, int] = {}

    def upgraded(self) -> None:
        self.send(_WATCH)

    def message(self, payload: bytes, now_s: float) -> None:
        self.messages += 1
        self.bytes += len(payload)
        if not self._reads_closely or b'"delta"' not in payload[:20]:
            return
        now_ms = time.time() * 1e3
        for vehicle in _decoder.decode(payload).vehicles:
            if vehicle.heard_ms and self._heard_ms.get(vehicle.vehicle_id) != vehicle.heard_ms:
                self._heard_ms[vehicle.vehicle_id] = vehicle.heard_ms
                self.ages_s.append((now_ms - vehicle.heard_ms) / 1e3)


def open_viewers(sockets: Sockets, served: Served, count: int) -> list[ViewerConnection]:
    """The first one reads what it is sent; the others count it."""
    viewers = [ViewerConnection(served.port, served.cookie, number == 0) for number in range(count)]
    for viewer in viewers:
        sockets.add(viewer)
    return viewers

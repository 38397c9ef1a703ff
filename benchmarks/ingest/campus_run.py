"""The campus under load: a fleet that reports events and statuses, and the screens that show it."""

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.ingest.city import Place
from benchmarks.ingest.connections import VehicleConnection
from benchmarks.ingest.fleet_keys import vehicle_key, vehicle_name
from benchmarks.ingest.ledger import AckLedger
from benchmarks.ingest.load import Beat, Sockets, open_all, run_beats
from benchmarks.ingest.messages import EventFrames, hello_payload, status_payload
from benchmarks.ingest.served import Served, Usage
from benchmarks.ingest.viewers import ViewerConnection, open_viewers

_OPEN_WITHIN_S = 180.0
_DRAIN_S = 10.0
# So many events are followed by a repeat of the same: it has to be acknowledged, and stored once.
_REPEAT_EVERY = 100


@dataclass(frozen=True, slots=True)
class Load:
    vehicles: int
    events_hz: float
    status_hz: float
    viewers: int
    warm_up_s: float
    seconds: float


@dataclass(frozen=True, slots=True)
class CampusRun:
    """Of the measured window; idle and loaded: the server before the fleet and at the end."""

    wall_s: float
    events: int
    acknowledged: int
    latencies_ms: np.ndarray
    begin: Usage
    end: Usage
    idle: Usage
    viewers: list[ViewerConnection]
    unacknowledged: int
    open_s: float

    @property
    def cpu_us(self) -> float:
        """For each acknowledged event."""
        return 1e6 * (self.end.cpu_s - self.begin.cpu_s) / max(1, self.acknowledged)


class CampusFleet:
    """The vehicles of one run and everything that they send."""

    def __init__(self, sockets: Sockets, served: Served, places: list[Place], map_version: str) -> None:
        self.ledger = AckLedger(len(places))
        self._sockets, self._served = sockets, served
        self._places, self._map_version = places, map_version
        self._frames = [EventFrames(place) for place in places]
        self.connections: list[VehicleConnection] = []

    def open(self) -> None:
        self.connections = open_all(self._sockets, self._dial, len(self._places), _OPEN_WITHIN_S)
        for connection in self.connections:
            self._frames[connection.number].begin(connection.epoch)
            self.ledger.begin(connection.number, connection.next_sequence)

    def send_event(self, number: int, due_s: float) -> None:
        vehicle = number % len(self.connections)
        sequence = self.ledger.send(vehicle, due_s)
        payload = self._frames[vehicle].payload(sequence)
        self._sockets.send(self.connections[vehicle], payload)
        if number % _REPEAT_EVERY == 0:
            self._sockets.send(self.connections[vehicle], payload)

    def send_status(self, number: int, _due_s: float) -> None:
        vehicle = number % len(self.connections)
        connection = self.connections[vehicle]
        self._sockets.send(connection, status_payload(self._places[vehicle], connection.epoch, number))

    def _dial(self, number: int) -> VehicleConnection:
        def say_hello(challenge: bytes) -> bytes:
            return hello_payload(challenge, vehicle_name(number), vehicle_key(number), self._map_version)

        return VehicleConnection(self._served.port, number, say_hello, self.ledger)


def run_campus(
    served: Served, load: Load, places: list[Place], map_version: str
) -> tuple[CampusRun, AckLedger]:
    sockets = Sockets()
    fleet = CampusFleet(sockets, served, places, map_version)
    idle = served.usage()
    begun_s = time.perf_counter()
    fleet.open()
    open_s = time.perf_counter() - begun_s
    viewers = open_viewers(sockets, served, load.viewers)
    now_s = time.perf_counter()
    beats = [
        Beat(now_s, load.vehicles * load.events_hz, fleet.send_event),
        Beat(now_s, load.vehicles * load.status_hz, fleet.send_status),
    ]
    run_beats(sockets, beats, now_s + load.warm_up_s)
    begin, from_s, sent = served.usage(), time.perf_counter(), fleet.ledger.sent
    acknowledged = sum(fleet.ledger.acknowledged_below)
    fleet.ledger.count(from_s, from_s + load.seconds)
    run_beats(sockets, beats, from_s + load.seconds)
    end, wall_s = served.usage(), time.perf_counter() - from_s
    events = fleet.ledger.sent - sent
    acknowledged = sum(fleet.ledger.acknowledged_below) - acknowledged
    until_s = time.perf_counter() + _DRAIN_S
    while fleet.ledger.unacknowledged and time.perf_counter() < until_s:
        sockets.turn(2)
    sockets.close()
    latencies_ms = 1e3 * np.array(fleet.ledger.latencies_s)
    unacknowledged = fleet.ledger.unacknowledged
    run = CampusRun(
        wall_s, events, acknowledged, latencies_ms, begin, end, idle, viewers, unacknowledged, open_s
    )
    return run, fleet.ledger


def database_of(folder: Path) -> str:
    """The URL of the server's database."""
    return f"sqlite:///{folder / 'campusloop.db'}"

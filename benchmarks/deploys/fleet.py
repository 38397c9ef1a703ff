"""Vehicles that keep their links while servers come and go: they dial again as the agent does."""

import heapq
import random
import time
from collections.abc import Callable
from threading import Event

import msgspec

from benchmarks.ingest.city import Place
from benchmarks.ingest.connections import Connection, VehicleConnection
from benchmarks.ingest.fleet_keys import vehicle_key, vehicle_name
from benchmarks.ingest.ledger import AckLedger
from benchmarks.ingest.load import Beat, Sockets
from benchmarks.ingest.messages import EventFrames, hello_payload, status_payload
from contract.wire.close_reasons import Retry, retry_after
from contract.wire.codec import encode
from contract.wire.messages import Goodbye, Order, OrderAccepted
from vehicle_agent.link.redial import Redial

# As many as the agent: then it gives up an attempt that leads to no session.
_OPEN_WITHIN_S = 10.0
_FIRST_DIALS_PER_S = 100.0


class DeployedConnection(VehicleConnection):
    """It also accepts orders, and keeps what the server advised at the end.

    dialled_s, heard_s  when it began, and when its last frame came
    """

    def __init__(
        self, port: int, number: int, say_hello: Callable[[bytes], bytes], ledger: AckLedger
    ) -> None:
        super().__init__(port, number, say_hello, ledger)
        self.dialled_s = self.heard_s = time.perf_counter()
        self.retry: Retry = "later"

    def message(self, payload: bytes, now_s: float) -> None:
        self.heard_s = now_s
        if b'"type":"goodbye"' in payload:
            self.retry = retry_after(msgspec.json.decode(payload, type=Goodbye).code)
        elif b'"type":"order"' in payload:
            order = msgspec.json.decode(payload, type=Order)
            self.send(encode(OrderAccepted(self.epoch, order.order_id, order.revision)))
        else:
            super().message(payload, now_s)


class _Vehicle:
    def __init__(self, number: int, place: Place, seed: int) -> None:
        self.number, self.place = number, place
        self.frames = EventFrames(place)
        self.redial = Redial(random.Random(f"{seed} {number}").random)
        self.connection: DeployedConnection | None = None
        self.last_heard_s: float | None = None


class Fleet:
    """gaps_s: times without a live link, each from the last frame of a session to the next welcome."""

    def __init__(self, port: int, places: list[Place], serving: int, map_version: str, seed: int) -> None:
        """serving: so many of the first vehicles take rides, and so report their status"""
        self._serving = serving
        self.ledger = AckLedger(len(places))
        self.gaps_s: list[float] = []
        self.failed_dials = 0
        self._port, self._map_version = port, map_version
        self._vehicles = [_Vehicle(number, place, seed) for number, place in enumerate(places)]
        self._sockets = Sockets(self._ended)
        self._dials: list[tuple[float, int]] = []
        self._opening: set[DeployedConnection] = set()

    @property
    def connected(self) -> int:
        return sum(one.connection is not None and one.connection.is_open for one in self._vehicles)

    def run(self, stopped: Event, events_hz: float, status_hz: float, drain_s: float) -> None:
        """Until `stopped`; then without new events until all are acknowledged, or for drain_s."""
        now_s = time.perf_counter()
        count = len(self._vehicles)
        self._dials = [(now_s + number / _FIRST_DIALS_PER_S, number) for number in range(count)]
        beats = [
            Beat(now_s, count * events_hz, self._send_event),
            Beat(now_s, self._serving * status_hz, self._send_status),
        ]
        while not stopped.is_set():
            for beat in beats:
                beat.catch_up(time.perf_counter())
            self._turn()
        until_s = time.perf_counter() + drain_s
        while time.perf_counter() < until_s and (
            self.ledger.unacknowledged or self.connected < len(self._vehicles)
        ):
            self._turn()
        self._sockets.close()

    def _turn(self) -> None:
        now_s = time.perf_counter()
        while self._dials and self._dials[0][0] <= now_s:
            self._dial(self._vehicles[heapq.heappop(self._dials)[1]])
        self._sockets.turn(2)
        for connection in list(self._opening):
            if connection.is_open:
                self._opening.discard(connection)
                self._opened(self._vehicles[connection.number], connection)
            elif now_s - connection.dialled_s > _OPEN_WITHIN_S:
                connection.ended = "no session in time"
                self._ended(connection)

    def _dial(self, vehicle: _Vehicle) -> None:
        number = vehicle.number

        def say_hello(challenge: bytes) -> bytes:
            return hello_payload(challenge, vehicle_name(number), vehicle_key(number), self._map_version)

        vehicle.connection = DeployedConnection(self._port, number, say_hello, self.ledger)
        self._opening.add(vehicle.connection)
        self._sockets.add(vehicle.connection)

    def _opened(self, vehicle: _Vehicle, connection: DeployedConnection) -> None:
        if vehicle.last_heard_s is not None:
            self.gaps_s.append(connection.heard_s - vehicle.last_heard_s)
        number = vehicle.number
        vehicle.frames.begin(connection.epoch)
        self.ledger.acknowledged(number, connection.next_sequence, connection.heard_s)
        for sequence in range(connection.next_sequence, self.ledger.next_sequence[number]):
            self._sockets.send(connection, vehicle.frames.payload(sequence))

    def _ended(self, connection: Connection) -> None:
        assert isinstance(connection, DeployedConnection)
        vehicle = self._vehicles[connection.number]
        if vehicle.connection is not connection:
            return
        self._sockets.remove(connection)
        self._opening.discard(connection)
        vehicle.connection = None
        if connection.epoch:
            vehicle.last_heard_s = connection.heard_s
        else:
            self.failed_dials += 1
        wait_s = vehicle.redial.wait_s(was_welcomed=bool(connection.epoch), retry=connection.retry)
        heapq.heappush(self._dials, (time.perf_counter() + wait_s, vehicle.number))

    def _send_event(self, number: int, due_s: float) -> None:
        """Made in any case, as on a vehicle's disk; sent if there is a link."""
        vehicle = self._vehicles[number % len(self._vehicles)]
        sequence = self.ledger.send(vehicle.number, due_s)
        connection = vehicle.connection
        if connection is not None and connection not in self._opening:
            self._sockets.send(connection, vehicle.frames.payload(sequence))

    def _send_status(self, number: int, _due_s: float) -> None:
        vehicle = self._vehicles[number % self._serving]
        connection = vehicle.connection
        if connection is not None and connection not in self._opening:
            payload = status_payload(vehicle.place, connection.epoch, number, "autonomous", speed_mps=0.0)
            self._sockets.send(connection, payload)

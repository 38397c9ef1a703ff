"""A virtual hour: two vehicles that only send events, a lossy wire and a server that records them.

Run as a program it prints the hashes of both run logs and of the server's event log.
"""

import hashlib
import sys

import msgspec

from campusloop.virtual.conductor import Conductor
from campusloop.virtual.pipes import Pipe, PipeEnd
from contract.wire.codec import decode_from_server, decode_from_vehicle, encode
from contract.wire.messages import EventReport, EventsAcknowledged, ModeChanged
from contract.wire.sequence import EventLog, SequenceGap
from server.domain.record.events import RecordedEvent
from server.usecases.fleet.events import store_event


class MemoryEvents:
    def __init__(self) -> None:
        self.rows: list[RecordedEvent] = []

    def count(self, vehicle_id: str, boot_id: str) -> int:
        return sum(1 for row in self.rows if (row.vehicle_id, row.boot_id) == (vehicle_id, boot_id))

    def add(self, event: RecordedEvent) -> None:
        self.rows.append(event)


class EventSource:
    """A vehicle without rooms: it drains and records its inbox, and sends an event now and then."""

    def __init__(self, name: str, conductor: Conductor, wire: PipeEnd) -> None:
        self.name, self.wire = name, wire
        self.log = EventLog(f"{name}-boot")
        self.run_log = hashlib.sha256()
        self.inbox: list[bytes] = []
        self.rng = conductor.rng(f"vehicle/{name}")
        wire.on_message = self.inbox.append

    def step(self, now_ns: int) -> None:
        for data in self.inbox:
            acknowledged = decode_from_server(data)
            assert isinstance(acknowledged, EventsAcknowledged)
            self.log.acknowledge(acknowledged.boot_id, acknowledged.next_sequence)
        self.run_log.update(msgspec.msgpack.encode((now_ns, self.inbox)))
        self.inbox.clear()
        if self.rng.random() < 0.004:
            self.log.append(now_ns, ModeChanged("held", detail=f"thought {self.rng.integers(1000)}"))
        if now_ns % 1_000_000_000 == 0:
            for event in self.log.pending():
                report = EventReport(1, event.boot_id, event.sequence, event.stamp_ns, event.body)
                self.wire.send(encode(report))


class RecordingServer:
    """The server with its one use case. Loses one frame in ten, as networks do."""

    def __init__(self, conductor: Conductor) -> None:
        self.conductor = conductor
        self.events = MemoryEvents()
        self.rng = conductor.rng("server/loss")

    def attach(self, vehicle_id: str, wire: PipeEnd) -> None:
        def received(data: bytes) -> None:
            self.conductor.loop.create_task(self.handle(vehicle_id, wire, data))

        wire.on_message = received

    async def handle(self, vehicle_id: str, wire: PipeEnd, data: bytes) -> None:
        if self.rng.random() < 0.1:
            return
        report = decode_from_vehicle(data)
        assert isinstance(report, EventReport)
        event = RecordedEvent(
            vehicle_id, report.boot_id, report.sequence, report.stamp_ns, self.conductor.now_ns, report.body
        )
        try:
            store_event(self.events, event)
        except SequenceGap as gap:
            wire.send(encode(EventsAcknowledged(1, gap.boot_id, gap.expected)))
            return
        known = self.events.count(vehicle_id, report.boot_id)
        wire.send(encode(EventsAcknowledged(1, report.boot_id, known)))


def conducted_hour(seed: int, duration_s: float = 3600.0) -> dict[str, str]:
    conductor = Conductor(seed)
    server = RecordingServer(conductor)
    vehicles = []
    for name in ("shuttle-2", "shuttle-1"):
        pipe = Pipe(conductor, name)
        vehicle = EventSource(name, conductor, pipe.left)
        server.attach(name, pipe.right)
        conductor.add(name, vehicle)
        vehicles.append(vehicle)
    conductor.run_for(duration_s)
    hashes = {vehicle.name: vehicle.run_log.hexdigest() for vehicle in vehicles}
    body = msgspec.json.encode(
        [msgspec.to_builtins(row.body) | {"at": row.received_ns} for row in server.events.rows]
    )
    hashes["events"] = f"{len(server.events.rows)}:{hashlib.sha256(body).hexdigest()}"
    return dict(sorted(hashes.items()))


if __name__ == "__main__":
    print(msgspec.json.encode(conducted_hour(int(sys.argv[1]), float(sys.argv[2]))).decode())

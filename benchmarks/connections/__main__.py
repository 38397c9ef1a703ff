"""How many vehicles one server holds, with what memory, and how fresh screens are meanwhile.

    python -m benchmarks.connections [--vehicles 5000] [--status-hz 1] [--viewers 20] [--seconds 20] [--json
    FILE]

The server is that of `benchmarks.ingest`. Each vehicle has a session of its own, opened by a signed hello,
and reports its status `--status-hz` times a second; one in ten also reports an event a second. Memory is
what the process has for itself (USS), and what it has with the libraries that it shares (RSS), at the end
of the run; `idle_mb` is its USS before the first vehicle. Children (the solvers) are not counted. A
screen's age of a position is counted from the moment at which the server received the status until a screen
has received it.
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.ingest.campus_run import Load, database_of, run_campus
from benchmarks.ingest.city import places, write_city
from benchmarks.ingest.fleet_keys import enrol_fleet
from benchmarks.ingest.readback import read_back
from benchmarks.ingest.served import allow_many_files, environment, served_campus
from benchmarks.reporting.report import RunReport
from contract.roads.load import load_map

# Two vehicles on each lane within the 60 m in which they are told of each other, and one on the opposite one.
_APART_M = 48.0
_EVENTS_HZ = 0.1
_WARM_UP_S = 10.0


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--vehicles", type=int, default=5000)
    parser.add_argument("--status-hz", type=float, default=1.0)
    parser.add_argument("--viewers", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--apart-m", type=float, default=_APART_M, help="from vehicle to vehicle on a lane")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    report = RunReport()
    allow_many_files()
    load = Load(args.vehicles, _EVENTS_HZ, args.status_hz, args.viewers, _WARM_UP_S, args.seconds)
    with tempfile.TemporaryDirectory(prefix="campusloop-connections-") as name:
        folder = Path(name)
        write_city(folder / "city.json", load.vehicles, args.apart_m)
        road_map = load_map(folder / "city.json")
        variables = environment(folder, folder / "city.json")
        enrol_fleet(variables, load.vehicles)
        where = places(road_map, load.vehicles)
        with served_campus(variables) as served:
            run, ledger = run_campus(served, load, where, road_map.map_version)
        found = read_back(database_of(folder), ledger.acknowledged_below, where)
    ages_ms = 1e3 * np.array(run.viewers[0].ages_s)
    row = {
        "vehicles": load.vehicles,
        "memory_mb": round(run.end.memory_mb, 1),
        "memory_rss_mb": round(run.end.rss_mb, 1),
        "idle_mb": round(run.idle.memory_mb, 1),
        "kb_a_vehicle": round(1e3 * (run.end.memory_mb - run.idle.memory_mb) / load.vehicles, 2),
        "viewer_p50_ms": round(float(np.percentile(ages_ms, 50)), 1),
        "viewer_p99_ms": round(float(np.percentile(ages_ms, 99)), 1),
        "ack_p99_ms": round(float(np.percentile(run.latencies_ms, 99)), 1),
        "cpu_cores": round((run.end.cpu_s - run.begin.cpu_s) / run.wall_s, 3),
        "opened_in_s": round(run.open_s, 1),
        "lost": found.lost,
        "load_average": round(os.getloadavg()[0], 2),
    }
    arguments = {name: str(value) for name, value in vars(args).items() if name != "json"}
    summary = {name: row[name] for name in ("memory_mb", "viewer_p99_ms", "lost")}
    report.write(args.json, "connections", arguments, [row], summary)
    if found.lost or found.doubled or run.unacknowledged:
        sys.exit(f"events were lost or not acknowledged: {found}, {run.unacknowledged}")


if __name__ == "__main__":
    main()

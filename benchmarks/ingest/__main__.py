"""A first form."""

import argparse
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.ingest.campus_run import Load, database_of, run_campus
from benchmarks.ingest.city import places, write_city
from benchmarks.ingest.fleet_keys import enrol_fleet
from benchmarks.ingest.readback import read_back
from benchmarks.ingest.served import allow_many_files, environment, served_campus
from contract.roads.load import load_map


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--vehicles", type=int, default=1000)
    parser.add_argument("--hz", type=float, default=10.0)
    parser.add_argument("--status-hz", type=float, default=1.0)
    parser.add_argument("--viewers", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=20.0)
    args = parser.parse_args()
    allow_many_files()
    with tempfile.TemporaryDirectory(prefix="campusloop-ingest-") as name:
        folder = Path(name)
        write_city(folder / "city.json", args.vehicles, 96.0)
        road_map = load_map(folder / "city.json")
        variables = environment(folder, folder / "city.json")
        enrol_fleet(variables, args.vehicles)
        where = places(road_map, args.vehicles)
        load = Load(args.vehicles, args.hz, args.status_hz, args.viewers, 3.0, args.seconds)
        with served_campus(variables) as served:
            run, ledger = run_campus(served, load, where, road_map.map_version)
        ms = run.latencies_ms
        cpu = run.end.cpu_s - run.begin.cpu_s
        print("open_s", run.open_s, "sent/s", run.events / run.wall_s, "acked/s", run.acknowledged / run.wall_s)
        print("p50 p99 max", *np.percentile(ms, [50, 99, 100]) if len(ms) else "")
        print("cpu_s", cpu, "of", run.wall_s, "us/event", 1e6 * cpu / max(1, run.acknowledged))
        print("memory", run.idle, run.begin, run.end)
        if run.viewers and len(run.viewers[0].ages_s):
            print("viewer p50 p99", np.percentile(run.viewers[0].ages_s, [50, 99]), run.viewers[0].messages, run.viewers[0].bytes)
        print(run.unacknowledged, read_back(database_of(folder), ledger, where))


if __name__ == "__main__":
    main()

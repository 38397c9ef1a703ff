"""What screens that stop reading cost: half of them freeze while the fleet reports.

    python -m benchmarks.connections.slow_readers [--vehicles 1000] [--viewers 100] [--seconds 20]
        [--json FILE]

The server is that of `benchmarks.ingest`; each vehicle reports its status once a second. Memory is what the
server's process has for itself (USS): the highest while all screens read, and the highest after half of
them have stopped to read without closing. A frozen screen is closed by its unanswered ping after 20 to 40
s, so the time is shorter than that.
"""

import argparse
import os
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.ingest.campus_run import CampusFleet
from benchmarks.ingest.city import places, write_city
from benchmarks.ingest.fleet_keys import enrol_fleet
from benchmarks.ingest.load import Beat, Sockets, run_beats
from benchmarks.ingest.served import Served, allow_many_files, environment, served_campus
from benchmarks.ingest.viewers import open_viewers
from benchmarks.reporting.report import RunReport
from contract.roads.load import load_map

_APART_M = 96.0
_WARM_UP_S = 10.0
_SAMPLE_S = 1.0


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--vehicles", type=int, default=1000)
    parser.add_argument("--viewers", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    report = RunReport()
    allow_many_files()
    with tempfile.TemporaryDirectory(prefix="campusloop-slow-readers-") as name:
        row = _measure(Path(name), args.vehicles, args.viewers, args.seconds)
    arguments = {name: str(value) for name, value in vars(args).items() if name != "json"}
    summary = {name: row[name] for name in ("memory_growth_pct", "viewer_p99_ms")}
    report.write(args.json, "slow_readers", arguments, [row], summary)


def _measure(folder: Path, vehicles: int, count: int, seconds: float) -> dict[str, float | int]:
    write_city(folder / "city.json", vehicles, _APART_M)
    road_map = load_map(folder / "city.json")
    variables = environment(folder, folder / "city.json")
    enrol_fleet(variables, vehicles)
    with served_campus(variables) as served:
        sockets = Sockets()
        fleet = CampusFleet(sockets, served, places(road_map, vehicles), road_map.map_version)
        fleet.open()
        viewers = open_viewers(sockets, served, count)
        beats = [Beat(time.perf_counter(), float(vehicles), fleet.send_status)]
        run_beats(sockets, beats, time.perf_counter() + _WARM_UP_S)
        reading_mb = _highest_mb(served, sockets, beats, seconds)
        seen = len(viewers[0].ages_s)
        for viewer in viewers[count // 2 :]:
            sockets.freeze(viewer)
        frozen_mb = _highest_mb(served, sockets, beats, seconds)
        ages_ms = 1e3 * np.array(viewers[0].ages_s[seen:])
        sockets.close()
    return {
        "viewers": count,
        "frozen": count - count // 2,
        "reading_mb": round(reading_mb, 1),
        "frozen_mb": round(frozen_mb, 1),
        "memory_growth_pct": round(100.0 * (frozen_mb / reading_mb - 1.0), 2),
        "viewer_p99_ms": round(float(np.percentile(ages_ms, 99)), 1),
        "load_average": round(os.getloadavg()[0], 2),
    }


def _highest_mb(served: Served, sockets: Sockets, beats: Sequence[Beat], seconds: float) -> float:
    highest, until_s = 0.0, time.perf_counter() + seconds
    while time.perf_counter() < until_s:
        run_beats(sockets, beats, time.perf_counter() + _SAMPLE_S)
        highest = max(highest, served.usage().memory_mb)
    return highest


if __name__ == "__main__":
    main()

"""Maps from files: seconds of an import, stops that reach each other, and how far a round trip moves a map.

    python -m benchmarks.maps [--generated 6] [--json FILE] [OSM FILE ...]

Each OpenStreetMap file is imported, written as GeoJSON and as Lanelet2, and read back from both. Generated
campuses stand in for files that nobody has seen before; the shipped extract is measured too.
"""

import argparse
import math
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row, RunReport
from campusloop.shipped import DEFAULT_MAP
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.roads.travel_times import travel_time_matrix
from contract.roads.validate import problems
from server.feeds.roads.exchange.formats import EXPORTS, ExportFormat, import_map
from server.feeds.roads.generated import generated_osm

_FORMATS: tuple[ExportFormat, ...] = ("geojson", "lanelet2")
_SHIPPED = DEFAULT_MAP.parent / "shanghai-university-baoshan.osm.pbf"
_FIRST_SEED = 101


def main() -> None:
    report = RunReport()
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--generated", type=int, default=6, help="generated campuses")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rows: list[Row] = []
    with tempfile.TemporaryDirectory(prefix="campusloop-maps-") as folder:
        made = []
        for seed in range(_FIRST_SEED, _FIRST_SEED + args.generated):
            made.append(Path(folder) / f"generated-{seed}.osm")
            made[-1].write_bytes(generated_osm(seed))
        # The first import compiles the numerical kernels, which is no part of an import.
        import_map(made[0] if made else _SHIPPED)
        rows += [measured(path, Path(folder)) for path in (_SHIPPED, *args.files, *made)]
    summary = {
        "import_s_max": max(float(row["import_s"]) for row in rows),
        "reachable_share_min": min(float(row["reachable_share"]) for row in rows),
        "round_trip_m_max": max(float(row[f"{kind}_m"]) for row in rows for kind in _FORMATS),
        "same_version_share": float(np.mean([row[f"{kind}_same"] for row in rows for kind in _FORMATS])),
    }
    arguments = {"files": [path.name for path in args.files], "generated": args.generated}
    report.write(args.json, "maps", arguments, rows, summary)


def measured(path: Path, folder: Path) -> Row:
    """One file imported, and its map sent through both formats."""
    began_s = time.perf_counter()
    road_map = import_map(path).map
    row: Row = {
        "file": path.name,
        "import_s": time.perf_counter() - began_s,
        "lanes": len(road_map.lanes),
        "stops": len(road_map.stops),
        "problems": len(problems(road_map)),
        "reachable_share": reachable_share(road_map),
    }
    for kind in _FORMATS:
        out = folder / f"round-trip.{kind}"
        began_s = time.perf_counter()
        out.write_bytes(EXPORTS[kind](road_map))
        row[f"{kind}_export_s"] = time.perf_counter() - began_s
        row[f"{kind}_mb"] = out.stat().st_size / 1e6
        began_s = time.perf_counter()
        back = import_map(out).map
        row[f"{kind}_import_s"] = time.perf_counter() - began_s
        row[f"{kind}_m"] = moved_m(road_map, back)
        row[f"{kind}_same"] = back.map_version == road_map.map_version
    return row


def reachable_share(road_map: RoadMap) -> float:
    """The share of ordered pairs of stops with a way between them."""
    network = RoadNetwork(road_map)
    times, _ = travel_time_matrix(network, [(stop.lane_id, stop.s_m) for stop in road_map.stops])
    return float(np.isfinite(times).mean())


def moved_m(one: RoadMap, other: RoadMap) -> float:
    """The farthest that a point of a lane or a stop has moved; infinite for another topology."""
    before = {lane.lane_id: lane for lane in one.lanes}
    after = {lane.lane_id: lane for lane in other.lanes}
    if {k: lane.successors for k, lane in before.items()} != {
        k: lane.successors for k, lane in after.items()
    }:
        return math.inf
    networks = RoadNetwork(one), RoadNetwork(other)
    moved = [
        math.dist(a, b)
        for name, lane in before.items()
        for a, b in zip(lane.points, after[name].points, strict=True)
    ]
    moved += [
        math.dist(networks[0].pose(a.lane_id, a.s_m)[:2], networks[1].pose(b.lane_id, b.s_m)[:2])
        for a, b in zip(one.stops, other.stops, strict=True)
    ]
    return max(moved)


if __name__ == "__main__":
    main()

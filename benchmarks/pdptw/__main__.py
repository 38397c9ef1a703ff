"""Pickup and delivery with windows, fewest vehicles first, on Li and Lim's instances (2001).

    python -m benchmarks.pdptw DIR --seconds 30 [--peers] [--best-known FILE] [--solutions DIR] [--json FILE]

Each instance gets the seconds of wall time on one core: a part to need fewer vehicles, the rest to drive
less. Every solution is scored again from the instance's rows (instances/rescore.py). gap_pct is the
distance's, where the number of vehicles is the best known one; optimal: no vehicle and no distance more than
the best known. --peers gives OR-tools and PyVRP the same seconds, where they are installed
(benchmarks/pdptw/peers.py).
"""

import time
from pathlib import Path

from benchmarks.instances.published import (
    arguments,
    best_known,
    instances_in,
    write_routes,
)
from benchmarks.instances.rescore import RouteBroken, rescored
from benchmarks.pdptw.peers import (
    PEERS,
    Routes,
    missing_peers,
    peer_routes,
)
from benchmarks.reporting.report import Row, RunReport, Value
from campusloop.studies.instances.instance import Instance
from campusloop.studies.instances.task import node_routes, task_of
from server.dispatch.engine.search.fleet import FleetSearch
from server.dispatch.engine.search.optimise import Optimiser, Settings

_OPTIMAL_WITHIN = 0.006
# Shares of the time: for fewer vehicles, and what is kept for the last set partitioning.
_FLEET = 0.4
_RESERVE = 0.05
# The plans with fewest vehicles lie far apart: each cycle starts from another one, and the pool of routes
# joins them.
_SETTINGS = Settings(cycle=15, growth=1.2, longest_cycle=2.7, afresh_every=1, hot=0.2)


def main() -> None:
    report = RunReport()
    parser = arguments(__doc__)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--peers", action="store_true", help="run OR-tools and PyVRP as well")
    args = parser.parse_args()
    instances = instances_in(args.folder)
    vehicles = best_known(args.folder, args.best_known, "vehicles")
    distances = best_known(args.folder, args.best_known, "distance")
    solve(instances[0], 0.0, args.seed)
    missing = missing_peers() if args.peers else []
    for name in missing:
        print(f"{name} is not installed: its columns are missing")
    rows = []
    for instance in instances:
        name = instance.name
        known = (vehicles[name], distances[name]) if name in distances else None
        rows.append(measured(instance, args.seconds, args.seed, known, args.solutions, args.peers))
        print(rows[-1], flush=True)
    report.write(
        args.json,
        "pdptw",
        {
            "folder": str(args.folder),
            "seconds": args.seconds,
            "seed": args.seed,
            "peers": args.peers,
            "peers_missing": missing,
        },
        rows,
        summary_of(rows, args.peers),
    )


def solve(instance: Instance, seconds: float, seed: int) -> tuple[Routes, int]:
    """Routes in node numbers, and how many slices were run."""
    began = time.perf_counter()
    fleet = FleetSearch(task_of(instance), seed)
    fleet.run_slice()
    while time.perf_counter() - began < _FLEET * seconds:
        fleet.run_slice()
    optimiser = Optimiser(fleet.task, seed, _SETTINGS, start=fleet.best, afresh=fleet.another)
    reserve = _RESERVE * seconds
    while True:
        slice_began = time.perf_counter()
        optimiser.run_slice()
        took = time.perf_counter() - slice_began
        if optimiser.at_rest:
            reserve = max(reserve, took)
        if time.perf_counter() - began + took + reserve > seconds:
            break
    optimiser.put_together()
    return node_routes(instance, optimiser.best), fleet.slices + optimiser.slices


def measured(
    instance: Instance,
    seconds: float,
    seed: int,
    known: tuple[float, float] | None,
    solutions: Path | None,
    peers: bool,
) -> Row:
    wall, cpu = time.perf_counter(), time.process_time()
    routes, slices = solve(instance, seconds, seed)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    write_routes(solutions, instance.name, routes)
    vehicles, distance, broken = scored(instance, routes)
    same = known is not None and vehicles == known[0]
    gap = None if known is None or distance is None or not same else 100.0 * (distance / known[1] - 1.0)
    row: dict[str, Value] = {
        "instance": instance.name,
        "requests": len(instance.pairs),
        "vehicles": vehicles,
        "distance": None if distance is None else round(distance, 4),
        "best_known_vehicles": None if known is None else int(known[0]),
        "best_known_distance": None if known is None else known[1],
        "gap_pct": None if gap is None else round(gap, 4),
        "optimal": None
        if known is None
        else distance is not None and (vehicles, distance) <= (known[0], known[1] + _OPTIMAL_WITHIN),
        "feasible": distance is not None,
        "broken": broken,
        "slices": slices,
        "wall_s": round(wall, 2),
        "cpu_s": round(cpu, 2),
    }
    if peers:
        row |= _against_peers(instance, seconds, seed, (vehicles, distance))
    return row


def scored(instance: Instance, routes: Routes) -> tuple[int, float | None, str]:
    """(vehicles, distance, "") or (vehicles, None, the broken rule)."""
    vehicles = sum(1 for route in routes if route)
    try:
        return vehicles, rescored(instance, routes), ""
    except RouteBroken as error:
        return vehicles, None, str(error)


def _against_peers(
    instance: Instance, seconds: float, seed: int, ours: tuple[int, float | None]
) -> dict[str, Value]:
    """Each peer's vehicles and distance (None without a feasible solution), and whether we are behind one."""
    row: dict[str, Value] = {}
    behind = False
    missing = missing_peers()
    for name in PEERS:
        if name in missing:
            continue
        vehicles, distance, _ = scored(instance, peer_routes(name, instance, seconds, seed))
        row[f"{name}_vehicles"] = None if distance is None else vehicles
        row[f"{name}_distance"] = None if distance is None else round(distance, 4)
        if distance is not None:
            behind |= ours[1] is None or (vehicles, distance + _OPTIMAL_WITHIN) < (ours[0], ours[1])
    row["behind_a_peer"] = behind
    return row


def summary_of(rows: list[Row], peers: bool) -> Row:
    gaps = [float(str(row["gap_pct"])) for row in rows if row["gap_pct"] is not None]
    known = [row for row in rows if row["best_known_vehicles"] is not None]
    fewest = sum(
        row["feasible"] is True and int(str(row["vehicles"])) <= int(str(row["best_known_vehicles"]))
        for row in known
    )
    summary: dict[str, Value] = {
        "mean_gap_pct": sum(gaps) / len(gaps) if gaps else None,
        "worst_gap_pct": max(gaps) if gaps else None,
        "vehicles_as_best_known_pct": 100.0 * fewest / len(known) if known else None,
        "optimal": sum(row["optimal"] is True for row in rows),
        "feasible": sum(row["feasible"] is True for row in rows),
        "instances": len(rows),
    }
    if peers:
        level = sum(row.get("behind_a_peer") is False for row in rows)
        summary["not_behind_a_peer_pct"] = 100.0 * level / len(rows)
    return summary


if __name__ == "__main__":
    main()

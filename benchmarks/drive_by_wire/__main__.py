"""Faults between tick and wheels: `python -m benchmarks.drive_by_wire --injections 5000 --json F`.

Faults are injected while the shuttle drives, in virtual time, into the real chain: tick outputs -> gate ->
bus -> by-wire module -> plant, and back. Sets of commands are lost, late, repeated or corrupted; frames are
lost and corrupted on the bus, in both directions; the steering sticks, the tick dies, clocks jump. Measured
from the first missing frame: the time until a brake is on the bus, the stopping distance, and whether the
vehicle moves again without an operator's resume. A stuck wheel counts from an angle error of 0.05 rad.
Harmless faults (one or two lost sets) must not stop the vehicle. With a dead gate or bus no process can brake
by wire; these are evaluated by the profile's fail action.

`--processes N`: N times SIGKILL or SIGSTOP on real gate and tick processes, with a simulation in real time.
`--hours H`: fault-free hours in virtual time among people on a campus; a nuisance stop is any stop by guard
or gate without a reason. `--traces DIR` writes every run for re-scoring.
"""

import argparse
import csv
import os
from pathlib import Path

import msgspec
import numpy as np

from benchmarks.drive_by_wire.fault_free import fault_free_hours
from benchmarks.drive_by_wire.faults import catalogue
from benchmarks.drive_by_wire.injection import TRACE_COLUMNS, inject
from benchmarks.drive_by_wire.processes import process_faults
from benchmarks.reporting.report import Row, RunReport
from campusloop.scenes.faulted_drive import winding_course
from vehicle_agent.config import Profile, load_profile

_PROFILE = Path(__file__).resolve().parents[2] / "vehicle_agent" / "profiles" / "campus-shuttle.toml"
SPEEDS_KMH = (15.0, 10.0, 15.0, 6.0)


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    profile = load_profile(arguments.profile)
    rows: list[Row] = []
    summary: dict[str, float | int | None] = {}
    if arguments.injections:
        cores = os.sched_getaffinity(0)
        os.sched_setaffinity(0, {min(cores)})
        injected = virtual(profile, arguments.injections, arguments.seed, arguments.traces)
        os.sched_setaffinity(0, cores)
        rows += by_kind(injected)
        summary |= virtual_summary(injected)
    if arguments.hours > 0.0:
        free = fault_free_hours(profile, arguments.hours, arguments.seed)
        rows += free
        summary |= nuisance_summary(free)
    if arguments.processes:
        real = process_faults(arguments.processes, profile, arguments.traces)
        rows += real
        summary |= process_summary(real)
    shown = {
        "injections": arguments.injections,
        "processes": arguments.processes,
        "hours": arguments.hours,
        "seed": arguments.seed,
        "profile": str(arguments.profile),
    }
    report.write(arguments.json, "drive_by_wire", shown, rows, summary)


def virtual(profile: Profile, injections: int, seed: int, traces: Path | None) -> list[Row]:
    """All kinds in turn, at each of the speeds; the fail action alternates with the spring brake."""
    kinds = catalogue()
    sprung = msgspec.structs.replace(profile, fail_action="spring_brake")
    courses = {
        (kmh, action): winding_course(kind_of, kmh / 3.6)
        for kmh in set(SPEEDS_KMH)
        for action, kind_of in ((0, profile), (1, sprung))
    }
    rows = []
    for number in range(injections):
        kind = kinds[number % len(kinds)]
        turn = number // len(kinds)
        course = courses[SPEEDS_KMH[turn % len(SPEEDS_KMH)], turn // len(SPEEDS_KMH) % 2]
        row, result = inject(course, kind, number, seed)
        rows.append(row)
        if traces is not None:
            _write_trace(traces / f"{kind.name.replace(' ', '-')}.csv", result.trace)
        if not row["right"] or row["crash"]:
            print(row, flush=True)
    if traces is not None:
        _write_rows(traces / "injections.csv", rows)
    return rows


def virtual_summary(rows: list[Row]) -> Row:
    """The maxima over all injections that braked. A flipped bit may disable by-wire (the enable bit itself,
    past the bus's checks); then the fail action applies, as with a dead bus."""
    lost = [row for row in rows if row["must"] == "either" and _lost_by_wire(row)]
    braked = [row for row in rows if row["latency_ms"] is not None and not _lost_by_wire(row)]
    released = [row["released"] for row in rows if row["released"] is not None]
    return {
        "injections": len(rows),
        "brake_latency_max_ms": _most(braked, "latency_ms"),
        "stop_distance_max_m": _most(braked, "stop_m"),
        "restarts": sum(bool(row["restarts"]) for row in rows),
        "wrong": sum(not row["right"] for row in rows),
        "harmless_stops": sum(row["must"] == "go on" and not row["right"] for row in rows),
        "flips_that_lost_by_wire": len(lost),
        "tick_crashes": sum(bool(row["crash"]) for row in rows),
        "resumes_tried": len(released),
        "resumes_failed": released.count(False),
    }


def _lost_by_wire(row: Row) -> bool:
    return row["must"] == "fail action" or (row["must"] == "either" and row["by_wire_lost_ms"] is not None)


def by_kind(rows: list[Row]) -> list[Row]:
    """A row of the report for each kind and fail action."""
    out: list[Row] = []
    for name in dict.fromkeys(str(row["kind"]) for row in rows):
        mine = [row for row in rows if row["kind"] == name]
        # If by-wire is lost, a brake on the bus has no effect.
        braked = [row for row in mine if row["latency_ms"] is not None and not _lost_by_wire(row)]
        latencies = [_number(row["latency_ms"]) for row in braked]
        out.append(
            {
                "part": "virtual time",
                "kind": name,
                "must": mine[0]["must"],
                "count": len(mine),
                "right": sum(bool(row["right"]) for row in mine),
                "braked": len(latencies),
                "latency_p50_ms": float(np.median(latencies)) if latencies else None,
                "latency_max_ms": max(latencies, default=None),
                "stop_max_m": _most(braked, "stop_m"),
                "restarts": sum(bool(row["restarts"]) for row in mine),
            }
        )
    return out


def nuisance_summary(rows: list[Row]) -> Row:
    hours = sum(_number(row["hours"]) for row in rows)
    stops = sum(_number(row["nuisance_stops"]) for row in rows)
    return {"fault_free_hours": hours, "nuisance_stops_per_10h": 10.0 * stops / hours if hours else None}


def process_summary(rows: list[Row]) -> Row:
    braked = [row for row in rows if row["must"] == "brake"]
    return {
        "process_faults": len(rows),
        "process_brake_latency_max_ms": _most(braked, "latency_ms"),
        "process_stop_distance_max_m": _most(braked, "stop_m"),
        "process_restarts": sum(bool(row["restarts"]) for row in rows),
        "process_wrong": sum(not row["right"] for row in rows),
    }


def _most(rows: list[Row], key: str) -> float | None:
    return max((_number(row[key]) for row in rows if row[key] is not None), default=None)


def _number(value: object) -> float:
    assert isinstance(value, int | float)
    return float(value)


def _write_trace(path: Path, trace: list[tuple[float, ...]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    begins = not path.exists()
    with path.open("a", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        if begins:
            out.writerow(TRACE_COLUMNS)
        out.writerows([f"{value:.4g}" if k else int(value) for k, value in enumerate(row)] for row in trace)


def _write_rows(path: Path, rows: list[Row]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.DictWriter(file, list(rows[0]))
        out.writeheader()
        out.writerows(rows)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="benchmarks.drive_by_wire",
        description=__doc__,
        formatter_class=argparse.RawTextHelpFormatter,
    )
    parser.add_argument("--injections", type=int, default=950, help="in virtual time")
    parser.add_argument("--processes", type=int, default=0, help="signals to real processes")
    parser.add_argument("--hours", type=float, default=0.2, help="fault-free, in virtual time")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--profile", type=Path, default=_PROFILE)
    parser.add_argument("--json", type=Path, help="where to write the report")
    parser.add_argument("--traces", type=Path, help="an empty folder for CSV files")
    return parser.parse_args()


if __name__ == "__main__":
    main()

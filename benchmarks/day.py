"""A real day of ride requests, revealed as they were announced, on our engine and on a greedy insertion.

    python -m benchmarks.day FILE.csv [--vehicles 300] [--seats 6] [--speed-mps 8] [--solutions DIR]
                             [--json FILE]

Columns: Announcementtime, Earliesttime, Latesttime (seconds, h:mm:ss or ISO), Origin_Latitude,
Origin_Longitude, Destination_Latitude, Destination_Longitude (degrees), and Passengers where there is one.
Driving is straight at the given speed, nobody walks, getting on and off takes no time. Where nearly every
ride could be driven between its earliest and its latest time, the latest time is that of arrival; otherwise
it is that of the pickup, and a ride may take twice the direct one or ten minutes more.
Vehicles begin at the origins of rides spread evenly over the day. A request is answered when it is announced
and never dropped after that. The greedy peer takes the cheapest insertion and never reconsiders; the
engine also searches, around one vehicle after the other.
Solutions: one line a vehicle; number 2k - 1 is the pickup and 2k the drop-off of the k-th row.
"""

import argparse
import csv
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np

from benchmarks.instances.published import write_routes
from benchmarks.reporting.report import Row, RunReport
from contract.geometry import Array
from server.dispatch.decide import offers_for, take
from server.dispatch.improve import improve_around
from server.dispatch.problem import CostWeights, Plane, Problem, Request, VehicleState
from server.dispatch.schedule.schedule import CompletedCall, Schedule

_EARTH_M = 6_371_008.8
_TRIP_SHARE = 0.9
_DETOUR_RATIO, _DETOUR_S = 2.0, 600.0
_VISITS_MAX = 200


@dataclass(frozen=True, slots=True)
class DispatchPolicy:
    """Every `every_s` seconds, `vehicles` around one are searched with `attempts`; 0 vehicles for no search.

    departure_slack  as in `Schedule`
    """

    name: str
    departure_slack: float
    every_s: float = 30.0
    vehicles: int = 0
    attempts: int = 0


_GREEDY = DispatchPolicy("greedy", 0.0)


def main() -> None:
    report = RunReport()
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("file", type=Path, metavar="FILE.csv")
    parser.add_argument("--vehicles", type=int, default=300)
    parser.add_argument("--seats", type=int, default=6)
    parser.add_argument("--speed-mps", type=float, default=8.0)
    parser.add_argument("--departure-slack", type=float, default=0.0)
    parser.add_argument("--every", type=float, default=7.0, metavar="S")
    parser.add_argument("--around", type=int, default=24, metavar="VEHICLES")
    parser.add_argument("--attempts", type=int, default=200)
    parser.add_argument("--solutions", type=Path)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    if args.vehicles < 1 or args.seats < 1 or args.speed_mps <= 0.0:
        parser.error("there must be a vehicle with a seat, and a speed above 0")
    requests = read_rides(args.file, args.speed_mps)
    print(f"{len(requests.rides)} rides; the latest time is that of {requests.latest_is}", flush=True)
    searching = DispatchPolicy("engine", args.departure_slack, args.every, args.around, args.attempts)
    rows, days = [], {}
    for policy in (_GREEDY, searching):
        day = driven(requests, args.vehicles, args.seats, args.speed_mps, policy)
        rows.append(day.row(policy.name, requests, args.speed_mps))
        print(rows[-1], flush=True)
        days[policy.name] = day
    write_routes(args.solutions, args.file.stem, days["engine"].routes)
    greedy, ours = rows
    report.write(
        args.json,
        "day",
        {k: str(v) if isinstance(v, Path) else v for k, v in vars(args).items() if k != "json"},
        rows,
        {
            "seconds": ours["wall_s"],
            "served_pct": ours["served_pct"],
            "vehicle_km": ours["vehicle_km"],
            "greedy_served_pct": greedy["served_pct"],
            "greedy_vehicle_km": greedy["vehicle_km"],
            "rides": len(requests.rides),
        },
    )


# ---------------------------------------------------------------- reading


@dataclass(frozen=True, slots=True)
class DayRequest:
    """rides in the order of the file, (n,) when each was announced, xy_m (2n, 2) of pickups and drop-offs."""

    rides: list[Request]
    announced_s: Array
    xy_m: Array
    latest_is: str


def read_rides(path: Path, speed_mps: float) -> DayRequest:
    """The file's rides; a file without a column, or with a row that cannot be, ends the program."""
    if not path.is_file():
        sys.exit(f"{path}: there is no such file")
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        sys.exit(f"{path}: no rides in this file")
    names = {name.strip().lower(): name for name in rows[0] if name}

    def column(name: str) -> list[str]:
        if name.lower() not in names:
            sys.exit(f"{path}: column {name} is missing; there are {', '.join(names.values())}")
        return [row[names[name.lower()]] for row in rows]

    try:
        announced, earliest, latest = (
            np.array([_seconds(text) for text in column(name)])
            for name in ("Announcementtime", "Earliesttime", "Latesttime")
        )
        degrees = np.array(
            [
                [float(text) for text in column(f"{end}_{side}")]
                for end in ("Origin", "Destination")
                for side in ("Latitude", "Longitude")
            ]
        )
        party = [int(text) for text in column("Passengers")] if "passengers" in names else [1] * len(rows)
    except ValueError as error:
        sys.exit(f"{path}: {error}")
    wrong = np.flatnonzero((latest < earliest) | ~np.isfinite(degrees).all(axis=0) | (np.array(party) < 1))
    if len(wrong):
        sys.exit(f"{path}: row {wrong[0] + 2} ends before it begins, is nowhere, or carries nobody")
    xy_m = _plane(degrees)
    direct_s = np.linalg.norm(xy_m[0::2] - xy_m[1::2], axis=1) / speed_mps
    of_arrival = bool(np.mean(earliest + direct_s <= latest) >= _TRIP_SHARE)
    rides = [
        Request(
            request_id=str(k),
            pickup=2 * k,
            dropoff=2 * k + 1,
            party=party[k],
            wheelchairs=0,
            pickup_from_s=float(earliest[k]),
            pickup_to_s=float(latest[k]),
            arrive_by_s=float(latest[k]) if of_arrival else np.inf,
            ride_s_max=np.inf
            if of_arrival
            else max(_DETOUR_RATIO * float(direct_s[k]), float(direct_s[k]) + _DETOUR_S),
        )
        for k in range(len(rows))
    ]
    return DayRequest(rides, np.minimum(announced, earliest), xy_m, "arrival" if of_arrival else "the pickup")


def _seconds(text: str) -> float:
    """A time of day or an instant, in seconds. Raises ValueError."""
    try:
        return float(text)
    except ValueError:
        pass
    if text.count(":") in (1, 2) and "-" not in text:
        parts = [float(part) for part in text.split(":")]
        return sum(part * unit for part, unit in zip(parts, (3600.0, 60.0, 1.0), strict=False))
    return datetime.fromisoformat(text).timestamp()


def _plane(degrees: Array) -> Array:
    """(2n, 2) metres, pickups and drop-offs by turns, from rows of origin and destination latitude and
    longitude: equirectangular about the middle."""
    lat = np.radians(degrees[[0, 2]].T.ravel())
    lon = np.radians(degrees[[1, 3]].T.ravel())
    x_m = (lon - lon.mean()) * np.cos(lat.mean()) * _EARTH_M
    return np.stack([x_m, (lat - lat.mean()) * _EARTH_M], axis=1)


# ---------------------------------------------------------------- driving


@dataclass(slots=True)
class Day:
    """routes: visits of each vehicle as driven; waits and rides of those served, in seconds."""

    routes: list[list[int]]
    picked_s: dict[int, float]
    arrived_s: dict[int, float]
    driven_s: float
    wall_s: float
    cpu_s: float
    answers_s: list[float]

    def row(self, name: str, requests: DayRequest, speed_mps: float) -> Row:
        waits = [at - requests.rides[k].pickup_from_s for k, at in self.picked_s.items()]
        broken = sum(
            self.picked_s[k] > requests.rides[k].pickup_to_s + 1e-3
            or self.picked_s[k] < requests.rides[k].pickup_from_s - 1e-3
            or at > requests.rides[k].arrive_by_s + 1e-3
            for k, at in self.arrived_s.items()
        )
        return {
            "engine": name,
            "served_pct": round(100.0 * len(self.arrived_s) / len(requests.rides), 3),
            "vehicle_km": round(self.driven_s * speed_mps / 1000.0, 1),
            "median_wait_s": round(float(np.median(waits)), 1),
            "broken": broken,
            "answer_p99_ms": round(1e3 * float(np.percentile(self.answers_s, 99)), 3),
            "wall_s": round(self.wall_s, 1),
            "cpu_s": round(self.cpu_s, 1),
        }


def driven(requests: DayRequest, vehicles: int, seats: int, speed_mps: float, policy: DispatchPolicy) -> Day:
    """The whole day in announcement order."""
    schedule = _schedule(requests, vehicles, seats, speed_mps, policy.departure_slack)
    order = np.argsort(requests.announced_s, kind="stable")
    routes: dict[str, list[int]] = {name: [] for name in schedule.vehicle_ids}
    day = Day([], {}, {}, 0.0, 0.0, 0.0, [])
    wall, cpu = time.perf_counter(), time.process_time()
    searched_s, turn = float(requests.announced_s[order[0]]), 0
    for k in order:
        now_s = float(requests.announced_s[k])
        while policy.vehicles and searched_s + policy.every_s <= now_s:
            searched_s += policy.every_s
            _note(day, routes, schedule.advance(searched_s))
            improve_around(schedule, (turn * 7919) % vehicles, policy.vehicles, policy.attempts, turn)
            turn += 1
        _note(day, routes, schedule.advance(now_s))
        began = time.perf_counter()
        _answer(schedule, requests.rides[k])
        day.answers_s.append(time.perf_counter() - began)
    _note(day, routes, schedule.advance(float(requests.announced_s.max()) + 1e6))
    day.wall_s, day.cpu_s = time.perf_counter() - wall, time.process_time() - cpu
    day.driven_s = schedule.driven_s
    day.routes = list(routes.values())
    return day


def _answer(schedule: Schedule, ride: Request) -> None:
    schedule.add(ride)
    best = offers_for(schedule, ride.request_id).best
    if best is None:
        schedule.remove(ride.request_id)
    else:
        take(schedule, best)
        schedule.keep(ride.request_id)


def _note(day: Day, routes: dict[str, list[int]], visits: Sequence[CompletedCall]) -> None:
    for made in visits:
        k = int(made.request_id)
        routes[made.vehicle_id].append(2 * k + 1 + made.alights)
        (day.arrived_s if made.alights else day.picked_s)[k] = made.at_s


def _schedule(
    requests: DayRequest, vehicles: int, seats: int, speed_mps: float, departure_slack: float
) -> Schedule:
    spread = np.linspace(0, len(requests.rides) - 1, vehicles).astype(int)
    begins_s = float(requests.announced_s.min())
    fleet = tuple(
        VehicleState(
            f"v{v}", np.zeros(0), begins_s, seats, 0, at_xy=(requests.xy_m[2 * k, 0], requests.xy_m[2 * k, 1])
        )
        for v, k in enumerate(spread)
    )
    problem = Problem(
        fleet,
        {},
        np.zeros((0, 0)),
        weights=CostWeights(wait=0.0, walk=0.0, ride=0.0),
        plane=Plane(requests.xy_m, 1.0 / speed_mps),
    )
    return Schedule(problem, spare=len(requests.rides), departure_slack=departure_slack, visits=_VISITS_MAX)


if __name__ == "__main__":
    main()

"""Dynamic dial-a-ride: requests become known while the vehicles drive, and are accepted or refused at once.

    python -m benchmarks.dynamic_darp DIR [--best-known FILE] [--slices N] [--solutions DIR] [--json FILE]

The vehicles drive by the dispatcher's schedule; a visit to which a vehicle is driving stays. An accepted
request is served within every rule, which is checked from the driven routes (instances/rescore.py). The cost
is compared with the best known one of the static instance, where all requests are known beforehand.
Budgets are counts: slices of attempts after each request.
"""

import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.instances.published import (
    arguments,
    best_known,
    instances_in,
    write_routes,
)
from benchmarks.instances.rescore import RouteBroken, rescored
from benchmarks.reporting.report import Row, RunReport
from campusloop.studies.instances.instance import Instance
from server.dispatch.decide import offers_for, take
from server.dispatch.improve import CoolingSchedule, improve
from server.dispatch.problem import CostWeights, Plane, Problem, Request, VehicleState
from server.dispatch.schedule.schedule import Schedule
from server.dispatch.solve import without_deadline

_ATTEMPTS = 50
# A request that fits nowhere at first is tried so many times harder.
_INSISTENCE = 5
# Between setting out at once and as late as possible.
_DEPARTURE_SLACK = 0.75


def main() -> None:
    report = RunReport()
    parser = arguments(__doc__)
    parser.add_argument("--slices", type=int, default=20, help="of improvement after each request")
    args = parser.parse_args()
    instances = [instance for instance in instances_in(args.folder) if instance.revealed is not None]
    known = best_known(args.folder, args.best_known, "cost")
    rows = []
    for instance in instances:
        rows.append(measured(instance, args.slices, args.seed, known, args.solutions))
        print(rows[-1], flush=True)
    report.write(
        args.json,
        "dynamic_darp",
        {"folder": str(args.folder), "slices": args.slices, "seed": args.seed},
        rows,
        _summary(rows)
        | {f"{kind}_{k}": v for kind in ("ab", "pr") for k, v in _summary(_of(rows, kind)).items()},
    )


def measured(
    instance: Instance, slices: int, seed: int, known: dict[str, float], solutions: Path | None
) -> Row:
    wall, cpu = time.perf_counter(), time.process_time()
    day = _driven(instance, slices, seed)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    write_routes(solutions, instance.name, day.routes)
    n = len(instance.pairs)
    served = sum(len(route) for route in day.routes) // 2
    try:
        cost, broken = rescored(instance, day.routes, partial=True), ""
    except RouteBroken as error:
        cost, broken = 0.0, str(error)
    best = known.get(instance.name)
    over = None if best is None or broken else 100.0 * (cost / best - 1.0)
    return {
        "instance": instance.name,
        "requests": n,
        "served": served,
        "served_pct": round(100.0 * served / n, 3),
        "cost": round(cost, 3),
        "hindsight": best,
        "over_hindsight_pct": None if over is None else round(over, 3),
        "feasible": not broken,
        "broken": broken,
        "longest_decision_ms": round(1e3 * day.longest_s, 1),
        "wall_s": round(wall, 2),
        "cpu_s": round(cpu, 2),
    }


@dataclass(slots=True)
class _Day:
    """routes: node numbers of each vehicle's visits as driven; longest_s: the slowest answer."""

    routes: list[list[int]]
    longest_s: float


def _driven(instance: Instance, slices: int, seed: int) -> _Day:
    revealed = instance.revealed
    if revealed is None:
        raise ValueError(f"{instance.name} does not say when its requests become known")
    schedule = _schedule(instance)
    node_of = {f"r{k}": pair for k, pair in enumerate(instance.pairs)}
    routes: dict[str, list[int]] = {name: [] for name in schedule.vehicle_ids}
    longest_s = 0.0
    for number, k in enumerate(np.argsort(revealed, kind="stable")):
        for made in schedule.advance(float(revealed[k])):
            routes[made.vehicle_id].append(int(instance.nodes[node_of[made.request_id][int(made.alights)]]))
        began = time.perf_counter()
        _answer(schedule, _request(instance, int(k)), slices, seed + number)
        longest_s = max(longest_s, time.perf_counter() - began)
        improve(schedule, CoolingSchedule(slices, _ATTEMPTS), seed + number, slices, without_deadline)
    for made in schedule.advance(float(instance.late.max()) + 1e6):
        routes[made.vehicle_id].append(int(instance.nodes[node_of[made.request_id][int(made.alights)]]))
    return _Day(list(routes.values()), longest_s)


def _answer(schedule: Schedule, request: Request, slices: int, seed: int) -> bool:
    """Accept the request if anybody can take it, perhaps after some rearranging."""
    name = request.request_id
    schedule.add(request)
    best = offers_for(schedule, name).best
    if best is not None:
        take(schedule, best)
    else:
        many = slices * _INSISTENCE
        improve(schedule, CoolingSchedule(many, _ATTEMPTS), seed, many, without_deadline)
        if not schedule.carried([name]):
            schedule.remove(name)
            return False
    schedule.keep(name)
    return True


def _schedule(instance: Instance) -> Schedule:
    depot = (float(instance.xy[0, 0]), float(instance.xy[0, 1]))
    vehicle = VehicleState(
        vehicle_id="",
        to_places_s=np.zeros(0),
        ready_s=float(instance.early[0]),
        seats=instance.capacity,
        wheelchair_places=0,
        on_duty_to_s=float(instance.late[0]),
        at_xy=depot,
        ends_at=0,
        duty_s_max=float(instance.duration_max),
    )
    problem = Problem(
        tuple(replace(vehicle, vehicle_id=f"v{k}") for k in range(instance.vehicles)),
        {},
        np.zeros((0, 0)),
        weights=CostWeights(wait=0.0, walk=0.0, ride=0.0),
        plane=Plane(instance.xy.astype(float), 1.0),
        together=False,
    )
    return Schedule(problem, spare=len(instance.pairs), departure_slack=_DEPARTURE_SLACK)


def _request(instance: Instance, k: int) -> Request:
    p, d = (int(node) for node in instance.pairs[k])
    return Request(
        request_id=f"r{k}",
        pickup=p,
        dropoff=d,
        party=int(instance.load[p]),
        wheelchairs=0,
        pickup_from_s=float(instance.early[p]),
        pickup_to_s=float(instance.late[p]),
        arrive_by_s=float(instance.late[d]),
        ride_s_max=float(instance.ride_max),
        arrive_from_s=float(instance.early[d]),
        dwell_s=float(instance.service[p]),
    )


def _of(rows: list[Row], kind: str) -> list[Row]:
    return [row for row in rows if str(row["instance"]).startswith("pr") == (kind == "pr")]


def _summary(rows: list[Row]) -> dict[str, float | int | None]:
    over = [float(str(row["over_hindsight_pct"])) for row in rows if row["over_hindsight_pct"] is not None]
    asked = sum(int(str(row["requests"])) for row in rows)
    served = sum(int(str(row["served"])) for row in rows)
    return {
        "served_pct": round(100.0 * served / asked, 3) if asked else None,
        "over_hindsight_pct": round(sum(over) / len(over), 3) if over else None,
        "feasible": sum(row["feasible"] is True for row in rows),
        "instances": len(rows),
    }


if __name__ == "__main__":
    main()

"""A part of the fleet with its requests as a task of its own, small enough to be searched in a moment."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.plan import ABSENT, Plan, empty_plan, refresh, scratch_for
from server.dispatch.engine.task import Task
from server.dispatch.schedule.schedule import Schedule

# A route of a part may grow by so many visits.
_ROOM = 40


class _Rows(NamedTuple):
    """Rows of the schedule: vehicles (V,), requests (R,), and the node for each node of the part (N,)."""

    vehicles: AnyArray
    requests: AnyArray
    nodes: AnyArray


@dataclass(frozen=True, slots=True)
class Subproblem:
    """task, plan  of the part alone, with numbers of its own; `put_back` needs the rest."""

    task: Task
    plan: Plan
    rows: _Rows


def part_of(schedule: Schedule, vehicles: AnyArray, absent: AnyArray) -> Subproblem:
    """These vehicles (rows of the schedule) with everything in their routes and aboard, and some requests
    without a vehicle."""
    whole, plan = schedule.task, schedule.plan
    inside = np.zeros(whole.vehicles + 1, np.bool_)
    inside[vehicles] = True
    carried = np.flatnonzero(inside[plan.vehicle_of])
    requests = np.concatenate([carried, absent]).astype(np.int64)
    first_fixed = 2 * (whole.requests + whole.vehicles)
    routes = [plan.route[v, : plan.length[v]] for v in vehicles]
    visited = np.concatenate(routes)
    fixed = np.sort(visited[visited >= first_fixed])
    ends = 2 * (whole.requests + vehicles)
    nodes = np.concatenate(
        [
            np.stack([2 * requests, 2 * requests + 1], axis=1).ravel(),
            np.stack([ends, ends + 1], axis=1).ravel(),
            np.stack([fixed, fixed + 1], axis=1).ravel(),
        ]
    ).astype(np.int64)
    task = whole._replace(
        place=whole.place[nodes],
        early_s=whole.early_s[nodes],
        late_s=whole.late_s[nodes],
        service_s=whole.service_s[nodes],
        load=whole.load[nodes],
        ride_s_max=whole.ride_s_max[nodes],
        delay_cost=whole.delay_cost[nodes],
        capacity=whole.capacity[vehicles],
        kind=np.arange(len(vehicles), dtype=np.int32),
        drive_s_max=whole.drive_s_max[vehicles],
        vehicle_cost=whole.vehicle_cost[vehicles],
        absent_cost=whole.absent_cost[requests],
        travel_time_factor=whole.travel_time_factor[nodes],
    )
    room = max(len(route) for route in routes) + _ROOM
    part = empty_plan(task, min(room, plan.route.shape[1]))
    number = np.zeros(len(whole.place), np.int32)
    number[nodes] = np.arange(len(nodes), dtype=np.int32)
    scratch = scratch_for(task, part.route.shape[1])
    for k, (v, route) in enumerate(zip(vehicles, routes, strict=True)):
        part.route[k, : len(route)] = number[route]
        part.length[k], part.locked[k] = len(route), plan.locked[v]
    home = np.full(whole.vehicles + 1, ABSENT, np.int32)
    home[vehicles] = np.arange(len(vehicles), dtype=np.int32)
    part.vehicle_of[:] = home[plan.vehicle_of[requests]]
    part.movable[:] = plan.movable[requests]
    for k in range(len(vehicles)):
        refresh(task, part, scratch, k)
    return Subproblem(task, part, _Rows(vehicles, requests, nodes))


def put_back(schedule: Schedule, part: Subproblem, plan: Plan) -> None:
    """Take over the routes that the part's vehicles have in this plan."""
    rows = part.rows
    taken = plan.vehicle_of >= 0
    schedule.plan.vehicle_of[rows.requests[taken]] = rows.vehicles[plan.vehicle_of[taken]]
    schedule.plan.vehicle_of[rows.requests[~taken]] = ABSENT
    for k, v in enumerate(rows.vehicles):
        length = int(plan.length[k])
        schedule.plan.route[v, :length] = rows.nodes[plan.route[k, :length]]
        schedule.plan.length[v] = length
        refresh(schedule.task, schedule.plan, schedule.scratch, int(v))

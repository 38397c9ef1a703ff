"""The engine's arrays for a new schedule, and its first requests."""

from collections.abc import Sequence

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.task import SEATS, WHEELCHAIRS, Task
from server.dispatch.problem import CUT_OFF_S, Problem, Request


def finite(times: AnyArray) -> AnyArray:
    """Times with CUT_OFF_S where no road leads."""
    return np.where(np.isfinite(times), times, CUT_OFF_S)


def blank_task(problem: Problem, requests: int, nodes: int) -> Task:
    """Rows for so many requests and nodes, none in use; rows of travel for places, then for vehicles."""
    places, vehicles = len(problem.times), len(problem.vehicles)
    travel_s: AnyArray = np.zeros((0, 0))
    xy: AnyArray = np.zeros((0, 2))
    if problem.plane is None:
        travel_s = np.zeros((places + vehicles, places))
        travel_s[:places] = finite(problem.times)
    else:
        xy = np.concatenate([problem.plane.xy, np.zeros((vehicles, 2))])
    return Task(
        place=np.zeros(nodes, np.int32),
        early_s=np.zeros(nodes),
        late_s=np.zeros(nodes),
        service_s=np.zeros(nodes),
        load=np.zeros((nodes, 2), np.int32),
        ride_s_max=np.full(nodes, np.inf),
        delay_cost=np.zeros(nodes),
        capacity=np.zeros((vehicles, 2), np.int32),
        kind=np.arange(vehicles, dtype=np.int32),
        drive_s_max=np.full(vehicles, np.inf),
        vehicle_cost=np.zeros(vehicles),
        absent_cost=np.zeros(requests),
        travel_s=travel_s,
        xy=xy,
        slowness=0.0 if problem.plane is None else problem.plane.slowness,
        joined=problem.together,
        travel_time_factor=np.ones(nodes),
    )


def fill_rows(task: Task, requests: Sequence[Request], problem: Problem, origin_s: float) -> None:
    """Make the first rows of a blank task these requests: what `Schedule.write` does for one, for all at
    once.

    absent_cost is their people, to be multiplied.
    """
    p, d = slice(0, 2 * len(requests), 2), slice(1, 2 * len(requests), 2)
    weights = problem.weights
    rows = np.array(
        [
            (
                r.pickup_from_s,
                r.arrive_from_s,
                r.pickup_to_s,
                r.arrive_by_s,
                r.ride_s_max,
                r.travel_time_factor,
            )
            for r in requests
        ]
    )
    people = np.array([(r.party, r.wheelchairs) for r in requests])
    dwell_s = [problem.dwell_s if r.dwell_s is None else r.dwell_s for r in requests]
    task.place[p], task.place[d] = [r.pickup for r in requests], [r.dropoff for r in requests]
    task.early_s[p] = rows[:, 0] - origin_s
    task.early_s[d] = np.maximum(task.early_s[p], rows[:, 1] - origin_s)
    task.late_s[p] = rows[:, 2] - origin_s
    task.late_s[d] = np.minimum(rows[:, 3] - origin_s, 0.5 * CUT_OFF_S)
    task.ride_s_max[p] = rows[:, 4]
    task.load[p, SEATS], task.load[p, WHEELCHAIRS] = people[:, 0], people[:, 1]
    task.load[d] = -task.load[p]
    task.delay_cost[p] = (weights.wait - weights.ride) * people[:, 0]
    task.delay_cost[d] = weights.ride * people[:, 0]
    task.service_s[p], task.service_s[d] = dwell_s, dwell_s
    task.travel_time_factor[p], task.travel_time_factor[d] = rows[:, 5], rows[:, 5]
    task.absent_cost[: len(requests)] = people[:, 0]

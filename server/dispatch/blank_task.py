"""The engine's arrays for a board, with nothing in them yet."""

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.task import Task
from server.dispatch.problem import CUT_OFF_S, Problem


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
        pace=np.ones(nodes),
    )

"""The task of the engine, as flat arrays.

Nodes are numbered so that a partner is one bit away: node 2r picks request r up and node 2r + 1 sets it down;
with R requests, node 2(R + v) is where vehicle v starts and 2(R + v) + 1 where it ends. So the test for the
longest ride also keeps a vehicle's longest duty. Even numbers from 2(R + V) on are timed calls, which belong
to no request.
"""

from typing import NamedTuple

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.compiled import inlined

SEATS, WHEELCHAIRS = 0, 1
LOAD_KINDS = 2
# Times are compared with this tolerance. Sums of Euclidean legs differ by far less.
EPSILON_S = 1e-6
NOWHERE = -1


class Task(NamedTuple):
    """Arrays over N nodes, R requests, V vehicles and P places. Seconds; float64 and int32 unless said.

    place       (N,) row of the travel table, NOWHERE for an end that may be anywhere
    early_s, late_s   (N,) window in which the visit begins; waiting is allowed
    service_s   (N,) how long the vehicle stands from the visit's beginning on
    load        (N, 2) change of occupied seats and wheelchair places
    ride_s_max  (N,) at even nodes: longest time from the end of service there to the beginning at the partner
    delay_cost  (N,) cost of each second after early_s
    capacity    (V, 2)
    kind        (V,) vehicles of one kind are the same while they are empty
    drive_s_max (V,) driving left in the battery
    vehicle_cost (V,) for having any visit at all
    absent_cost (R,) for leaving a request out
    travel_s    (P, P) between places; empty where coordinates are used instead
    travel_time_factor  (N,) of driving to the node, on travel_s: roads are slower at some hours
    has_travel_time_factors  whether any is not 1; a detour may then be quicker than the direct way
    xy          (P, 2) used with `slowness` (seconds per unit) where travel_s is empty
    joined      whether visits at one place that follow each other share one dwell
    plain       whether windows and loads are the only rules, and driving the only cost
    """

    place: AnyArray
    early_s: AnyArray
    late_s: AnyArray
    service_s: AnyArray
    load: AnyArray
    ride_s_max: AnyArray
    delay_cost: AnyArray
    capacity: AnyArray
    kind: AnyArray
    drive_s_max: AnyArray
    vehicle_cost: AnyArray
    absent_cost: AnyArray
    travel_s: AnyArray
    xy: AnyArray
    slowness: float
    joined: bool
    travel_time_factor: AnyArray
    plain: bool = False
    has_travel_time_factors: bool = False

    @property
    def requests(self) -> int:
        return len(self.absent_cost)

    @property
    def vehicles(self) -> int:
        return len(self.kind)


@inlined
def drive_s(task: Task, a: int, b: int) -> float:
    """Driving from node a to node b."""
    p, q = task.place[a], task.place[b]
    if p < 0 or q < 0:
        return 0.0
    if task.travel_s.shape[0] > 0:
        if task.has_travel_time_factors:
            return float(task.travel_s[p, q] * task.travel_time_factor[b])
        return float(task.travel_s[p, q])
    x = task.xy[p, 0] - task.xy[q, 0]
    y = task.xy[p, 1] - task.xy[q, 1]
    return float(task.slowness * np.sqrt(x * x + y * y))


@inlined
def stand_s(task: Task, a: int, b: int) -> float:
    """Standing at node a before going on to node b. Riders at one place board and alight together."""
    if task.joined and task.place[a] == task.place[b]:
        return float(max(0.0, task.service_s[a] - task.service_s[b]))
    return float(task.service_s[a])


def typical_drive_s(task: Task) -> float:
    """Median direct drive from pickup to drop-off."""
    pickups, dropoffs = task.place[0 : 2 * task.requests : 2], task.place[1 : 2 * task.requests : 2]
    if len(task.travel_s):
        return float(np.median(task.travel_s[pickups, dropoffs]))
    return float(np.median(task.slowness * np.linalg.norm(task.xy[pickups] - task.xy[dropoffs], axis=1)))


def freedom(task: Task) -> float:
    """Mean window of a visit over what a typical visit takes: how many other visits may precede or follow
    it."""
    visits = 2 * task.requests
    if visits == 0:
        return 0.0
    window_s = float((task.late_s[:visits] - task.early_s[:visits]).mean())
    return max(0.0, window_s) / max(EPSILON_S, typical_drive_s(task) + float(task.service_s[:visits].mean()))

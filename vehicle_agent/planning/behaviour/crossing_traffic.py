"""Yielding to crossing traffic at a stop line (Snow Lion, unprotected intersections), and slowing at
crossings.

Predictions alone are too noisy to thread through crossing traffic. The vehicle stops at the stop line for
every moving road user in an observation area whose way may meet its own there at about the same time.
"""

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array
from contract.roads.areas import AreaAhead
from vehicle_agent.signals import Corridor, PlanJob, WatchedArea


class CrossingRules(msgspec.Struct, frozen=True):
    """Rules at observation areas.

    apart_s           to go, both ways through the area must be this far apart in time
    resume_apart_s    the same to drive on, once the vehicle has stopped or begun to
    beside_m          a road user this near to the line is on it
    front_m           from the rear axle to the bumper
    decel_mps2        the vehicle stops at a stop line as long as this deceleration is enough
    pass_mps          assumed speed through the area
    occupied_mps, reported_mps  speed at a crossing with tracked people, with people seen by its camera only
    """

    front_m: float
    apart_s: float = 1.5
    resume_apart_s: float = 2.5
    beside_m: float = 2.2
    decel_mps2: float = 1.6
    pass_mps: float = 2.5
    occupied_mps: float = 2.2
    reported_mps: float = 1.5


class YieldDecision(msgspec.Struct, frozen=True):
    """end_s_m: where the rear axle stops for an area, inf for nowhere.

    to            ids of the tracks that the vehicle yields to
    stopping_for  see `PlanMemory`
    slow          (from_s_m, to_s_m, speed_mps) where it drives slower
    """

    end_s_m: float
    to: tuple[int, ...]
    stopping_for: tuple[str, ...]
    slow: tuple[tuple[float, float, float], ...]


def yielding(job: PlanJob, s_m: float, rules: CrossingRules) -> YieldDecision:
    """s_m: of the start state on the line."""
    watched = {area.area_id: area for area in job.watched}
    end_s_m, to, stopping, slow = np.inf, set[int](), [], []
    for area in job.areas:
        seen = watched.get(area.area_id)
        if seen is None or s_m > area.leave_s_m:
            continue
        if area.kind == "crossing":
            if seen.track_ids or seen.reported:
                speed_mps = rules.occupied_mps if seen.track_ids else rules.reported_mps
                slow.append((area.enter_s_m - rules.front_m - 2.0, area.leave_s_m, speed_mps))
            continue
        stop_s_m = area.stop_s_m - rules.front_m
        braking_m = job.speed_mps**2 / (2.0 * rules.decel_mps2)
        if s_m + braking_m > stop_s_m + 0.3:
            continue
        ids = _conflicts(job, area, seen, s_m, rules)
        if ids:
            end_s_m = min(end_s_m, max(stop_s_m, s_m))
            to.update(ids)
            stopping.append(area.area_id)
    return YieldDecision(float(end_s_m), tuple(sorted(to)), tuple(stopping), tuple(slow))


def _conflicts(
    job: PlanJob, area: AreaAhead, seen: WatchedArea, s_m: float, rules: CrossingRules
) -> tuple[int, ...]:
    """Ids of the tracks that are on our way through the area at about the same time."""
    apart_s = rules.resume_apart_s if area.area_id in job.memory.stopping_for else rules.apart_s
    speed_mps = max(job.speed_mps, rules.pass_mps)
    enter_s = max(0.0, area.enter_s_m - rules.front_m - s_m) / speed_mps - apart_s
    leave_s = max(0.0, area.leave_s_m - s_m) / speed_mps + apart_s
    corridor, predictions = job.corridor, job.predictions
    way = _stations(corridor, area)
    if not len(way):
        return ()
    late_s = (job.stamp_ns - predictions.stamp_ns) * 1e-9
    found = []
    for number in seen.track_ids:
        i = int(np.flatnonzero(job.tracks.ids == number)[0])
        beside_m = rules.beside_m + 0.5 * float(job.tracks.sizes_m[i, 1])
        times_s = predictions.times_s - late_s
        if is_on_way(way, predictions.poses_map[i], times_s, enter_s, leave_s, beside_m):
            found.append(number)
    return tuple(found)


def _stations(corridor: Corridor, area: AreaAhead) -> Array:
    kept = (corridor.s_m >= area.enter_s_m) & (corridor.s_m <= area.leave_s_m)
    places: Array = np.ascontiguousarray(corridor.points_map[kept][::2])
    return places


@njit(cache=True)
def is_on_way(way: Array, poses: Array, times: Array, from_s: float, to_s: float, beside_m: float) -> bool:
    """One of the predicted poses (k, 3) of the times between comes within beside_m of the places (m, 2)."""
    for j in range(poses.shape[0]):
        if times[j] < from_s or times[j] > to_s:
            continue
        for i in range(way.shape[0]):
            dx, dy = poses[j, 0] - way[i, 0], poses[j, 1] - way[i, 1]
            if dx * dx + dy * dy < beside_m * beside_m:
                return True
    return False

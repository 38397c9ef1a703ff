"""The s-t graph of an answer, as small as people can still read it."""

import numpy as np

from contract.geometry import Array
from contract.wire.reasons import SpeedLimitReason
from vehicle_agent.planning.motion.path.path_samples import PathSamples
from vehicle_agent.planning.motion.request import MotionRequest
from vehicle_agent.planning.motion.speed.speed_limits import CAUSES, LIMIT
from vehicle_agent.planning.motion.speed.speed_step import SpeedSolution
from vehicle_agent.signals import UNBOUNDED_CM, PathGraph, PathLimit

# Stretches of limits that are told, the nearest first.
LIMITS_MAX = 12


def path_graph(speed: SpeedSolution, samples: PathSamples, rows: Array, request: MotionRequest) -> PathGraph:
    """rows (k, 8): the trajectory that was chosen, which may be a stop instead of the plan."""
    graph, corridor = speed.graph, speed.corridor
    knots = len(corridor.high_m)
    times = graph.dt_s * np.arange(knots)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(rows[:, 1:3], axis=0).T))])
    return PathGraph(
        dt_s=graph.dt_s,
        way_cm=_cm(np.interp(times, rows[:, 0], way)),
        low_cm=_cm(np.where(corridor.low_m > 0.0, corridor.low_m, -np.inf)),
        high_cm=_cm(np.minimum(corridor.high_m, speed.stop_m)),
        ids=request.agents.ids[graph.who],
        from_cm=_cm(graph.low_m),
        to_cm=_cm(graph.high_m),
        limits=_limits(speed, samples, request),
    )


def _cm(way_m: Array) -> np.ndarray:
    most = UNBOUNDED_CM / 100.0
    return np.round(np.clip(way_m, -most, most) * 100.0).astype(np.int16)


def _limits(speed: SpeedSolution, samples: PathSamples, request: MotionRequest) -> tuple[PathLimit, ...]:
    """Stretches of one cause; each with its lowest speed."""
    reasons = _reasons(speed, samples, request)
    found: list[PathLimit] = []
    first = 0
    for j in range(1, len(reasons) + 1):
        if j < len(reasons) and reasons[j] == reasons[first]:
            continue
        last = min(j, len(reasons) - 1)
        slowest = float(speed.limits.speed_mps[first:j].min())
        stretch = (round(float(samples.u_m[first]), 2), round(float(samples.u_m[last]), 2))
        found.append(PathLimit(*stretch, round(slowest, 2), reasons[first]))
        first = j
        if len(found) == LIMITS_MAX:
            break
    return tuple(found)


def _reasons(speed: SpeedSolution, samples: PathSamples, request: MotionRequest) -> list[SpeedLimitReason]:
    """The cause at each sample, as the behaviour names it where it has set the limit."""
    places = request.speed_reasons
    if not places:
        return [CAUSES[cause] for cause in speed.limits.cause]
    stations = np.searchsorted(request.corridor.s_m, samples.s_m)
    last = len(places) - 1
    return [
        places[min(int(station), last)] if cause == LIMIT else CAUSES[cause]
        for cause, station in zip(speed.limits.cause, stations, strict=True)
    ]

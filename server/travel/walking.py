"""Which stops can be walked to from each other."""

import numpy as np

from contract.roads.network import RoadNetwork
from server.dispatch.problem import Walk

# Paths are longer than the straight line.
_WALKING_DETOUR = 1.3
_WALKS_MAX = 3


def on_foot_s(apart_m: float, walk_mps: float) -> float:
    """Seconds on foot between places so far apart in a straight line."""
    return apart_m * _WALKING_DETOUR / walk_mps


def walks_between_stops(
    network: RoadNetwork, walk_m_max: float, walk_mps: float
) -> tuple[tuple[Walk, ...], ...]:
    """For each stop the nearest others on foot, the nearest first."""
    xy = np.array([network.pose(stop.lane_id, stop.s_m)[:2] for stop in network.road_map.stops])
    apart_m = np.linalg.norm(xy[:, None, :] - xy[None, :, :], axis=2)
    return tuple(
        tuple(
            Walk(int(other), on_foot_s(float(row[other]), walk_mps))
            for other in np.argsort(row, kind="stable")
            if other != number and row[other] <= walk_m_max
        )[:_WALKS_MAX]
        for number, row in enumerate(apart_m)
    )

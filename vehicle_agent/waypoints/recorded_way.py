"""The waypoint file that a vehicle drives: the one of its speed, checked against the campus map."""

import itertools
from pathlib import Path

import numpy as np

from contract.geometry import Array
from contract.roads.model import RoadMap
from vehicle_agent.planning.waypoint.recorded import BESIDE_M_MAX, GAP_M_MAX, RecordedWay
from vehicle_agent.planning.waypoint.waypoints import WaypointRules
from vehicle_agent.waypoints.files import WaypointFileError, file_name, read_waypoints

_LANE_STEP_M = 1.0


def recorded_way(route: Path, road_map: RoadMap, rules: WaypointRules) -> RecordedWay:
    """The recording of `route` (a folder and the prefix of its files) for the rules' highest speed.

    Raises WaypointFileError: no file for this speed (the message names the speeds that there are), a line at
    fault, a hole, or a place that is not on a lane of the map.
    """
    path = route.parent / file_name(route.name, rules.speed_mps_max)
    if not path.is_file():
        others = sorted(file.name for file in route.parent.glob(f"{route.name}-*mps.csv"))
        there_are = ", ".join(others) or "none"
        raise WaypointFileError(
            f"no waypoint file {path} for {rules.speed_mps_max:.1f} m/s; there are: {there_are}"
        )
    waypoints = read_waypoints(path, road_map.origin, rules)
    points = waypoints.points_map
    gaps = np.hypot(*np.diff(points, axis=0).T)
    lanes = _lane_points(road_map)
    away = np.array([np.hypot(*(lanes - point).T).min() for point in points])
    reach_m = BESIDE_M_MAX + 0.5 * _LANE_STEP_M
    if np.all(away > reach_m):
        raise WaypointFileError(
            f"{path}: recorded on another campus: no waypoint is on a lane of {road_map.campus_id}"
        )
    if np.any(gaps > GAP_M_MAX):
        first = int(np.argmax(gaps > GAP_M_MAX))
        raise WaypointFileError(
            f"{path}: a hole of {gaps[first]:.1f} m after waypoint {first + 1}, of at most {GAP_M_MAX} m"
        )
    if np.any(away > reach_m):
        first = int(np.argmax(away > reach_m))
        raise WaypointFileError(
            f"{path}: waypoint {first + 1} is {away[first]:.1f} m from every lane of {road_map.campus_id}"
        )
    return RecordedWay(points, waypoints.speeds_mps)


def _lane_points(road_map: RoadMap) -> Array:
    """(n, 2) points of all lanes, at most a metre apart."""
    dense = []
    for lane in road_map.lanes:
        points = np.array(lane.points)
        for start, end in itertools.pairwise(points):
            count = max(1, int(np.ceil(np.hypot(*(end - start)) / _LANE_STEP_M)))
            dense.append(start + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (end - start))
        dense.append(points[-1:])
    return np.vstack(dense)

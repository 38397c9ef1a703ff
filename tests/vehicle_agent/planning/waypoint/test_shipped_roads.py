"""Nothing that stands for good stops a shuttle anywhere on the shipped campus."""

import math

import numpy as np
import shapely

from contract.geometry import Array
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from tests.server.feeds.roads.shipped import CAMPUS_MAP
from tests.vehicle_agent.planning.builders import ROOM
from vehicle_agent.planning.waypoint.obstacle import sweep_line

STEP_M = 0.2
# Localization and steering move the body this far aside.
ASIDE_M = 0.15


def wall_points(network: RoadNetwork) -> Array:
    """(n, 2) along every wall."""
    walls = [shapely.LinearRing(building.outline) for building in network.road_map.buildings]
    return np.concatenate([shapely.get_coordinates(shapely.segmentize(wall, STEP_M)) for wall in walls])


def test_no_wall_is_an_obstacle_on_any_lane_of_the_shipped_campus() -> None:
    network = RoadNetwork(load_map(CAMPUS_MAP))
    walls = wall_points(network)
    rule = ROOM.obstacle
    stopped = []
    for lane_id, line in network.lines.items():
        low, high = line.points.min(axis=0) - 6.0, line.points.max(axis=0) + 6.0
        near = walls[np.all((walls > low) & (walls < high), axis=1)]
        for aside_m in (-ASIDE_M, 0.0, ASIDE_M):
            sweep = sweep_line(line.points, line.s, 0.0, aside_m, line.length_m)
            if not math.isinf(rule.free_m(near, sweep, rule.clearance_m)):
                stopped.append(lane_id)
    assert stopped == []

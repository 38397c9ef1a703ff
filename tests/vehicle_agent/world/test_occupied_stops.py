"""Which stops are taken: where another vehicle stands in the place that this one would have."""

import math

import numpy as np
import pytest

from contract.geometry import Pose2
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from tests.server.feeds.roads.shipped import SNOW_LION_MAP
from tests.vehicle_agent.world.builders import some_tracks
from vehicle_agent.signals import PEDESTRIAN, VEHICLE, Detections, Ego
from vehicle_agent.world.observed import ObservedWorld
from vehicle_agent.world.surroundings import Surroundings
from vehicle_agent.world.view import VisibilityParams

S = 1_000_000_000
NETWORK = RoadNetwork(load_map(SNOW_LION_MAP))
STOP = NETWORK.road_map.stops[0]
ROOM = ObservedWorld(NETWORK, Surroundings(3.5, 0.85, 0.815), VisibilityParams(0.0))


def taken(kind: int, ahead_m: float, left_m: float, speed_mps: float = 0.0, far_m: float = 12.0) -> bool:
    """With one track there, seen from the lane far_m before the stop."""
    x_m, y_m, yaw_rad = NETWORK.pose(STOP.lane_id, STOP.s_m)
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    ego = Ego(S, Pose2(x_m - far_m * cos, y_m - far_m * sin, yaw_rad), 0, 0, 0, 0, 0.02, S, True)
    row = (
        kind, x_m + ahead_m * cos - left_m * sin, y_m + ahead_m * sin + left_m * cos,
        (speed_mps or 1e-6) * cos, (speed_mps or 1e-6) * sin,
    )  # fmt: skip
    seen = Detections(S, np.empty((0, 2)), False, some_tracks(row, stamp_ns=S))
    world, _ = ROOM.step(ROOM.initial(), ego, seen, (), S)
    return STOP.stop_id in world.occupied_stops


@pytest.mark.parametrize(("ahead_m", "left_m"), [(1.3, 0.0), (5.0, 0.0), (-2.5, 0.0), (1.3, 1.5)])
def test_a_vehicle_that_stands_in_the_docked_place_takes_the_stop(ahead_m: float, left_m: float) -> None:
    assert taken(VEHICLE, ahead_m, left_m)


@pytest.mark.parametrize(("ahead_m", "left_m"), [(6.5, 0.0), (-4.0, 0.0), (1.3, 2.5), (1.3, -2.5)])
def test_one_before_it_behind_it_or_beside_it_does_not(ahead_m: float, left_m: float) -> None:
    assert not taken(VEHICLE, ahead_m, left_m)


def test_neither_who_drives_through_nor_somebody_on_foot_takes_it() -> None:
    assert not taken(VEHICLE, 1.3, 0.0, speed_mps=3.0)
    assert not taken(PEDESTRIAN, 1.3, 0.0)


def test_of_stops_out_of_sight_nothing_is_said() -> None:
    assert not taken(VEHICLE, 1.3, 0.0, far_m=60.0)

"""What of the scan is an obstacle and what is somebody who moves, and fleet mates that no sensor sees."""

import math

import msgspec
import numpy as np
import pytest

from contract.geometry import Array, Pose2
from contract.roads.model import Building
from contract.roads.network import RoadNetwork
from tests.vehicle_agent.mission.ring import NETWORK
from tests.vehicle_agent.world.builders import some_tracks
from vehicle_agent.signals import PEDESTRIAN, VEHICLE, Detections, Ego, FleetVehicle, Tracks
from vehicle_agent.world.observed import ObservedWorld, without_tracks
from vehicle_agent.world.surroundings import Surroundings
from vehicle_agent.world.view import VisibilityParams

S = 1_000_000_000
BODY = Surroundings(3.5, 0.85, 0.815)
ROOM = ObservedWorld(NETWORK, BODY, VisibilityParams(0.0))
MARGIN_M = 0.35


def left(points: list[tuple[float, float]], tracks: Tracks) -> list[tuple[float, float]]:
    kept = without_tracks(
        np.array(points), tracks.poses_map, tracks.sizes_m, MARGIN_M, tracks.velocities_map_mps
    )
    return [(float(x), float(y)) for x, y in kept]


def world_of(tracks: Tracks, *mates: FleetVehicle, points: Array | None = None) -> Tracks:
    ego = Ego(S, Pose2(0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.02, S, True)
    seen = Detections(S, np.empty((0, 2)) if points is None else points, False, tracks)
    world, _ = ROOM.step(ROOM.initial(), ego, seen, mates, S)
    return world.tracks


@pytest.mark.parametrize(("length_m", "aside"), [(4.5, False), (1.8, True)])
def test_returns_within_a_third_of_a_metre_of_a_parked_car_are_the_car(length_m: float, aside: bool) -> None:
    car = some_tracks((VEHICLE, 20.0, 5.0, 0.0, 0.0))
    for sign in (1.0, -1.0):
        inside, outside = (sign * (0.5 * length_m + MARGIN_M + step) for step in (-0.02, 0.02))
        theirs, not_theirs = ((20.0, 5.0 + off) if aside else (20.0 + off, 5.0) for off in (inside, outside))
        assert left([theirs, not_theirs], car) == [not_theirs]


def test_a_car_that_drives_takes_returns_before_and_behind_it_for_its_own_but_not_beside_it() -> None:
    """At 4 m/s the scan may be of a moment in which it was 0.6 m elsewhere."""
    car = some_tracks((VEHICLE, 20.0, 5.0, 0.0, 4.0))
    before, beyond = (20.0, 5.0 + 2.25 + MARGIN_M + 0.58), (20.0, 5.0 + 2.25 + MARGIN_M + 0.62)
    behind, beside = (20.0, 5.0 - 2.25 - MARGIN_M - 0.58), (20.0 + 0.9 + MARGIN_M + 0.02, 5.0)
    assert left([before, beyond, behind, beside], car) == [beyond, beside]


def test_returns_of_the_last_of_many_road_users_are_theirs() -> None:
    parked = [(VEHICLE, 20.0, 8.0 * number, 0.0, 0.0) for number in range(5)]
    assert left([(20.0, 32.0), (20.0, 36.0)], some_tracks(*parked)) == [(20.0, 36.0)]


def test_a_return_of_nobody_stays_an_obstacle() -> None:
    points = [(3.0, 4.0), (-2.0, 1.0)]
    assert left(points, some_tracks()) == points
    assert left(points, some_tracks((PEDESTRIAN, 30.0, 0.0, 0.0, 0.0))) == points


def test_a_mate_that_no_sensor_sees_takes_part_as_a_vehicle_with_our_own_body() -> None:
    yaw = 0.5 * math.pi
    mate = FleetVehicle(S, "b", Pose2(20.0, 10.0, yaw), 2.0)
    tracks = world_of(some_tracks((PEDESTRIAN, 5.0, 5.0, 1.0, 0.0)), mate)
    assert tracks.ids.tolist() == [0, -1]
    assert tracks.kinds.tolist() == [PEDESTRIAN, VEHICLE]
    assert tracks.poses_map[1].tolist() == pytest.approx([20.0, 10.0 + 0.5 * (3.5 - 0.85), yaw])
    assert tracks.velocities_map_mps[1].tolist() == pytest.approx([0.0, 2.0])
    assert tracks.sizes_m[1].tolist() == pytest.approx([4.35, 1.63])


@pytest.mark.parametrize(("apart_m", "ids"), [(2.4, [0]), (2.6, [0, -1])])
def test_a_mate_that_is_tracked_where_it_says_it_is_counts_once(apart_m: float, ids: list[int]) -> None:
    mate = FleetVehicle(S, "b", Pose2(20.0, 10.0, 0.0), 0.0)
    seen = some_tracks((VEHICLE, 20.0 + 0.5 * (3.5 - 0.85) + apart_m, 10.0, 0.0, 0.0))
    assert world_of(seen, mate).ids.tolist() == ids


def test_two_unseen_mates_have_ids_of_their_own() -> None:
    mates = [FleetVehicle(S, name, Pose2(20.0, y, 0.0), 0.0) for name, y in (("b", 10.0), ("c", 30.0))]
    assert world_of(some_tracks(), *mates).ids.tolist() == [-1, -2]


def test_a_scan_is_judged_once_and_the_next_one_anew() -> None:
    ego = Ego(S, Pose2(0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.02, S, True)
    cell = np.array([[10.0, 0.0]])
    world, state = ROOM.step(ROOM.initial(), ego, Detections(S, cell, False, some_tracks()), (), S)
    assert len(world.points_map) == 1
    again, state = ROOM.step(state, ego, Detections(S, cell, False, some_tracks()), (), S + 20_000_000)
    assert again.points_map is world.points_map
    gone = Detections(2 * S, np.empty((0, 2)), False, some_tracks())
    world, _ = ROOM.step(state, ego, gone, (), 2 * S)
    assert len(world.points_map) == 0


@pytest.mark.parametrize("walls_from_map", [True, False])
def test_only_a_vehicle_without_lidar_takes_the_maps_walls_for_obstacles(walls_from_map: bool) -> None:
    house = Building(((10.0, -6.0), (20.0, -6.0), (20.0, -9.0), (10.0, -9.0)), 9.0)
    network = RoadNetwork(msgspec.structs.replace(NETWORK.road_map, buildings=(house,)))
    room = ObservedWorld(network, BODY, VisibilityParams(40.0), walls_from_map=walls_from_map)
    ego = Ego(S, Pose2(0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.02, S, True)
    world, _ = room.step(room.initial(), ego, Detections(S, np.empty((0, 2)), False, some_tracks()), (), S)
    near_side = np.abs(world.points_map - np.array([15.0, -6.0])).max(axis=1, initial=0.0) < 5.01
    assert bool(near_side.any()) is walls_from_map

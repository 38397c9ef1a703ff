"""The world model: obstacles without fleet mates, fleet mates without the silent."""

import numpy as np

from contract.geometry import Pose2
from vehicle_agent.signals import Detections, Ego, FleetVehicle, PedestrianPresence
from vehicle_agent.world.surroundings import Surroundings

ROOM = Surroundings(3.5, 0.85, 0.815)
S = 1_000_000_000
EGO = Ego(S, Pose2(0, 0, 0), 0.0, 0.0, 0.0, 0.0, 0.02, S, True)


def seen(*points: tuple[float, float], stamp_ns: int = S) -> Detections:
    return Detections(stamp_ns, np.array(points).reshape(-1, 2), False)


def test_a_fleet_mates_own_returns_are_not_obstacles() -> None:
    mate = FleetVehicle(S, "b", Pose2(20.0, 0.0, 0.0), 0.0)
    world, _ = ROOM.step(ROOM.initial(), EGO, seen((19.2, 0.5), (23.4, -0.8), (20.0, 3.0)), (mate,), S)
    np.testing.assert_allclose(world.points_map, [[20.0, 3.0]], atol=1e-8)


def test_returns_within_the_margin_all_around_a_mate_are_its_own_and_those_beyond_are_obstacles() -> None:
    """It heads north: 3.5 m ahead of its rear axle, 0.85 m behind, 0.815 m to the sides, and 0.4 m more."""
    mate = FleetVehicle(S, "b", Pose2(20.0, 10.0, np.pi / 2), 0.0)
    reach = ((0.0, 3.9), (0.0, -1.25), (1.215, 0.0), (-1.215, 0.0))
    own = [(20.0 + 0.99 * x, 10.0 + 0.99 * y) for x, y in reach]
    beyond = [(20.0 + 1.01 * x, 10.0 + 1.01 * y) for x, y in reach]
    world, _ = ROOM.step(ROOM.initial(), EGO, seen(*own, *beyond), (mate,), S)
    np.testing.assert_allclose(world.points_map, beyond, atol=1e-8)


def test_a_moving_mate_is_carried_along_its_heading() -> None:
    mate = FleetVehicle(S, "b", Pose2(20.0, 0.0, 0.0), 2.0)
    _, state = ROOM.step(ROOM.initial(), EGO, seen(), (mate,), S)
    world, _ = ROOM.step(state, EGO, seen((25.2, 0.0), stamp_ns=2 * S), (), 2 * S)
    assert world.fleet_vehicles[0].pose_map.x_m == 22.0
    assert len(world.points_map) == 0


def test_a_mate_that_falls_silent_is_dropped() -> None:
    mate = FleetVehicle(S, "b", Pose2(20.0, 0.0, 0.0), 0.0)
    _, state = ROOM.step(ROOM.initial(), EGO, seen(), (mate,), S)
    world, _ = ROOM.step(state, EGO, seen((20.0, 0.0), stamp_ns=3 * S), (), 3 * S)
    assert world.fleet_vehicles == ()
    assert len(world.points_map) == 1


def test_a_newer_word_replaces_an_older_one() -> None:
    words = (PedestrianPresence(S, "zebra", 2), PedestrianPresence(S, "zebra", 0))
    world, _ = ROOM.step(ROOM.initial(), EGO, seen(), words, S)
    assert [word.count for word in world.presence] == [0]


def test_what_was_seen_last_counts_whichever_way_it_came() -> None:
    words = (PedestrianPresence(S, "zebra", 2), PedestrianPresence(S // 2, "zebra", 0))
    world, _ = ROOM.step(ROOM.initial(), EGO, seen(), words, S)
    assert [word.count for word in world.presence] == [2]


def test_a_stale_word_of_a_camera_counts_as_nothing() -> None:
    _, state = ROOM.step(ROOM.initial(), EGO, seen(), (PedestrianPresence(S, "zebra", 2),), S)
    world, _ = ROOM.step(state, EGO, seen(), (), S + ROOM.presence_age_ns_max + 1)
    assert world.presence == ()


def test_a_word_from_the_future_does_not_outlive_its_time() -> None:
    _, state = ROOM.step(ROOM.initial(), EGO, seen(), (PedestrianPresence(60 * S, "zebra", 2),), S)
    world, _ = ROOM.step(state, EGO, seen(), (), S + ROOM.presence_age_ns_max + 1)
    assert world.presence == ()

"""Who follows the shuttle keeps to a place about it, touches it at most, and walks off in the end."""

from dataclasses import replace

import numpy as np
import pytest

from simulator.traffic.crowd import clearance_m
from simulator.traffic.dense.followers import FollowerRole, Followers
from vehicle_agent.signals import CYCLIST

DT_S = 0.02
BEHIND = FollowerRole((0.0, 4.0), ((-2.5, 0.3),), 3.0, from_s=1.0, for_s=30.0)


def driven(role: FollowerRole, seconds: float, speed_mps: float = 2.0) -> tuple[Followers, np.ndarray]:
    """The followers and the vehicle after a drive along x."""
    followers = Followers((role,))
    vehicle = np.array([[0.0, 0.0, 0.0, 0.85, 3.5, 0.815, speed_mps]])
    for _ in range(round(seconds / DT_S)):
        vehicle[0, 0] += speed_mps * DT_S
        followers.step(vehicle, np.zeros(1), np.zeros((1, 1, 2)), DT_S)
        pose = followers.bodies().poses_map[0]
        assert clearance_m(vehicle[0], pose[0], pose[1]) > 0.19
    return followers, vehicle[0]


def test_a_follower_waits_for_the_cue_and_then_keeps_to_the_place() -> None:
    followers, _ = driven(BEHIND, 0.9)
    assert followers.bodies().poses_map[0, :2].tolist() == [0.0, 4.0]
    followers, vehicle = driven(BEHIND, 20.0)
    assert followers.bodies().poses_map[0, :2] == pytest.approx([vehicle[0] - 2.5, 0.3], abs=0.1)
    assert followers.bodies().velocities_map_mps[0] == pytest.approx([2.0, 0.0], abs=0.05)


def test_nobody_is_faster_than_he_can() -> None:
    followers, vehicle = driven(replace(BEHIND, speed_mps=1.0), 20.0)
    pace = float(np.hypot(*followers.bodies().velocities_map_mps[0]))
    assert pace == pytest.approx(1.0, abs=0.01)
    assert followers.bodies().poses_map[0, 0] < vehicle[0] - 10.0


def test_who_runs_at_the_shuttle_is_stopped_by_its_body() -> None:
    at_the_front = FollowerRole((12.0, 0.5), ((3.0, 0.0),), 3.0, from_s=0.5)
    followers, vehicle = driven(at_the_front, 10.0, speed_mps=0.0)
    pose = followers.bodies().poses_map[0]
    assert clearance_m(vehicle, pose[0], pose[1]) < 0.25


def test_in_the_end_they_walk_off_to_the_side() -> None:
    followers, vehicle = driven(replace(BEHIND, for_s=5.0), 20.0)
    assert abs(followers.bodies().poses_map[0, 1]) > 5.0
    assert followers.bodies().poses_map[0, 0] < vehicle[0] - 15.0


def test_a_rider_takes_one_place_after_the_other() -> None:
    overtaking = FollowerRole(
        (-20.0, 2.2), ((-3.0, 2.2), (7.0, 2.2)), 6.0, from_s=0.5, each_s=8.0, kind=CYCLIST, size_m=(1.2, 0.5)
    )
    followers, vehicle = driven(overtaking, 12.0)
    assert followers.bodies().poses_map[0, 0] == pytest.approx(vehicle[0] - 3.0, abs=0.1)
    followers, vehicle = driven(overtaking, 25.0)
    assert followers.bodies().poses_map[0, 0] == pytest.approx(vehicle[0] + 7.0, abs=0.1)
    assert followers.bodies().kinds.tolist() == [CYCLIST]
    assert followers.bodies().sizes_m.tolist() == [[1.2, 0.5]]

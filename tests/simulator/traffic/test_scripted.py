"""Actors that play a part: their cue, their way, their end."""

import math
from dataclasses import replace

import numpy as np
import pytest

from simulator.traffic.scripted import ActorGroups, ScriptedRole, ScriptedTraffic
from vehicle_agent.signals import PEDESTRIAN, VEHICLE

DT_S = 0.02
WAY = np.array([[0.0, -4.0], [5.0, -4.0]])
SOMEBODY = ScriptedRole(PEDESTRIAN, (0.0, 4.0, 0.0), (0.5, 0.5), WAY, 1.0)


def vehicles(x_m: float) -> np.ndarray:
    return np.array([[x_m, 4.0, 0.0, 0.85, 3.5, 0.815, 0.0]])


def played(part: ScriptedRole, seconds: float, x_m: float = -100.0) -> ScriptedTraffic:
    traffic = ScriptedTraffic((part,))
    for _ in range(round(seconds / DT_S)):
        traffic.step(vehicles(x_m), np.zeros(1), np.zeros((1, 1, 2)), DT_S)
    return traffic


def changed(**changes: object) -> ScriptedRole:
    return replace(SOMEBODY, **changes)  # type: ignore[arg-type]


def test_the_way_is_walked_at_the_given_speed_to_its_end() -> None:
    half = played(SOMEBODY, 4.2).bodies()
    assert half.poses_map[0, 1] == pytest.approx(0.0, abs=0.1)
    assert half.velocities_map_mps[0] == pytest.approx([0.0, -1.0], abs=1e-9)
    end = played(SOMEBODY, 20.0).bodies()
    assert end.poses_map[0, :2] == pytest.approx([5.0, -4.0])
    assert end.velocities_map_mps[0].tolist() == [0.0, 0.0]


def test_a_cue_by_time_and_by_distance() -> None:
    assert played(changed(from_s=3.0), 2.9).bodies().poses_map[0, 1] == 4.0
    assert played(changed(from_s=3.0), 4.0).bodies().poses_map[0, 1] < 3.5
    cued = changed(distance_m=10.0)
    assert played(cued, 5.0, x_m=-13.6).bodies().poses_map[0, 1] == 4.0
    assert played(cued, 2.0, x_m=-13.4).bodies().poses_map[0, 1] < 3.0
    assert played(changed(after_s=3.0), 2.9).bodies().poses_map[0, 1] == 4.0


def test_who_does_not_stay_is_gone_at_the_end() -> None:
    assert len(played(changed(stays=False), 30.0).bodies().numbers) == 0


def test_a_vehicle_speeds_up_and_slows_down_within_its_acceleration() -> None:
    car = ScriptedRole(VEHICLE, (0.0, 0.0, 0.0), (4.5, 1.8), np.array([[60.0, 0.0]]), 6.0, accel_mps2=1.0)
    traffic, speeds = ScriptedTraffic((car,)), []
    for _ in range(round(25 / DT_S)):
        traffic.step(vehicles(-100.0), np.zeros(1), np.zeros((1, 1, 2)), DT_S)
        speeds.append(traffic.bodies().velocities_map_mps[0, 0])
    assert max(speeds) == pytest.approx(6.0, abs=0.01)
    assert np.abs(np.diff(speeds[5:-5])).max() <= 1.0 * DT_S * 1.6 + 0.06
    assert traffic.bodies().poses_map[0, 0] == pytest.approx(60.0)


def test_groups_keep_their_numbers_apart_and_hold_together() -> None:
    both = ActorGroups((ScriptedTraffic((SOMEBODY,)), ScriptedTraffic((SOMEBODY, SOMEBODY))))
    assert both.bodies().numbers.tolist() == [1, 100_001, 100_002]
    both.hold = True
    assert len(both.bodies().numbers) == 0
    both.hold = False
    both.step(vehicles(0.0), np.zeros(1), np.zeros((1, 1, 2)), DT_S)
    assert both.bodies().poses_map[0, 2] == pytest.approx(-0.5 * math.pi)


def test_who_stops_dead_stands_at_the_place_and_goes_on_later() -> None:
    halting = changed(way=np.array([[0.0, 0.0], [0.0, -4.0]]), halt_at=0, halt_s=10.0)
    there = played(halting, 8.0).bodies()
    assert there.poses_map[0, :2] == pytest.approx([0.0, 0.0])
    assert there.velocities_map_mps[0].tolist() == [0.0, 0.0]
    assert played(halting, 4.2).bodies().velocities_map_mps[0, 1] <= 0.0
    assert played(halting, 30.0).bodies().poses_map[0, 1] == pytest.approx(-4.0)

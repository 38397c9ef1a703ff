"""The graph finds the poses that its factors agree on, and lets go of those that are wrong."""

import math

import numpy as np
import pytest

from contract.geometry import Array
from vehicle_agent.localization.odometry.motion import exponential, inverted
from workshop.cloud_mapping.pose_graph import Edge, GraphParams, Ground, Place, information_of, optimized


def a_ring(count: int = 40, radius_m: float = 20.0) -> Array:
    """(n, 4, 4) true poses around a circle that rises and falls by a metre."""
    poses = np.tile(np.eye(4), (count, 1, 1))
    for number, angle in enumerate(2.0 * math.pi * np.arange(count) / count):
        cos, sin = math.cos(angle), math.sin(angle)
        poses[number, :2, :2] = [[cos, -sin], [sin, cos]]
        poses[number, :3, 3] = radius_m * sin, radius_m * (1.0 - cos), math.sin(angle)
    return poses


def steps(true: Array, rng: np.random.Generator, noise: float) -> list[Edge]:
    information = information_of(0.02, 0.002)
    found = []
    for number in range(len(true) - 1):
        step = inverted(true[number]) @ true[number + 1]
        error = noise * np.concatenate([rng.normal(0.0, 0.02, 3), rng.normal(0.0, 0.002, 3)])
        found.append(Edge(number, number + 1, step @ exponential(error), information, False))
    return found


def reckoned(edges: list[Edge]) -> Array:
    poses = [np.eye(4)]
    for edge in edges:
        poses.append(poses[-1] @ edge.pose)
    return np.array(poses)


def places(true: Array, every: int, lever: Array, std_m: float = 0.03) -> list[Place]:
    return [
        Place(n, lever, true[n, :3, :3] @ lever + true[n, :3, 3], np.full(3, std_m))
        for n in range(0, len(true), every)
    ]


def apart_m(poses: Array, true: Array) -> float:
    return float(np.linalg.norm(poses[:, :3, 3] - true[:, :3, 3], axis=1).max())


def test_exact_factors_give_the_exact_poses_from_a_bad_start() -> None:
    true = a_ring()
    rng = np.random.default_rng(1)
    start = np.array([pose @ exponential(rng.normal(0.0, 0.1, 6)) for pose in true])
    start[0] = true[0]
    edges = [
        *steps(true, rng, 0.0),
        Edge(39, 0, inverted(true[39]) @ true[0], information_of(0.02, 0.002), True),
    ]
    found = optimized(start, edges, [], None, GraphParams())
    assert apart_m(found.poses, true) < 1e-3
    assert found.poses[:, :3, :3] @ found.poses[:, :3, :3].transpose(0, 2, 1) == pytest.approx(
        np.tile(np.eye(3), (40, 1, 1)), abs=1e-9
    )


def test_a_loop_takes_the_drift_out_and_a_wrong_one_loses_its_weight() -> None:
    true = a_ring()
    edges = steps(true, np.random.default_rng(2), 2.0)
    start = reckoned(edges)
    right = Edge(0, 39, inverted(true[0]) @ true[39], information_of(0.03, 0.002), True)
    wrong = Edge(5, 25, np.eye(4), information_of(0.03, 0.002), True)
    closed = optimized(start, [*edges, right], [], None, GraphParams())
    assert apart_m(closed.poses[-1:], true[-1:]) < 0.25 * apart_m(start[-1:], true[-1:])
    both = optimized(closed.poses, [*edges, right, wrong], [], None, GraphParams())
    assert both.edge_weights[-1] < 0.01
    assert both.edge_weights[-2] > 0.9
    assert apart_m(both.poses, closed.poses) < 0.05


def test_places_hold_the_drive_on_the_map_and_a_jump_of_the_receiver_does_not() -> None:
    true = a_ring()
    edges = steps(true, np.random.default_rng(3), 2.0)
    lever = np.array([-3.2, 0.0, -2.6])
    good = places(true, 4, lever)
    jump = Place(22, lever, true[22, :3, 3] + np.array([30.0, 0.0, 0.0]), np.full(3, 0.03))
    found = optimized(reckoned(edges), edges, [*good, jump], None, GraphParams())
    # Beyond the last place there is dead reckoning alone.
    assert apart_m(found.poses[:37], true[:37]) < 0.2
    assert apart_m(reckoned(edges)[:37], true[:37]) > 0.5
    assert found.place_weights[-1] < 0.01


def test_ground_that_is_level_on_average_takes_out_a_lean() -> None:
    true = np.tile(np.eye(4), (60, 1, 1))
    true[:, 0, 3] = np.arange(60)
    # Dead reckoning that pitches a little with each step.
    lean = exponential(np.array([0.0, 0.0, 0.0, 0.0, 0.002, 0.0]))
    edges = [
        Edge(n, n + 1, inverted(true[n]) @ true[n + 1] @ lean, information_of(0.02, 0.003), False)
        for n in range(59)
    ]
    start = reckoned(edges)
    ground = Ground(np.tile([0.0, 0.0, 1.0], (60, 1)), np.full(60, 2.0), np.ones(60, dtype=bool))
    found = optimized(start, edges, [], ground, GraphParams(slope_rad=0.05, rise_ratio=0.05))
    assert abs(start[-1, 2, 3]) > 3.0
    assert abs(found.poses[-1, 2, 3]) < 1.0


def test_the_optimum_is_that_of_another_solver() -> None:
    gtsam = pytest.importorskip("gtsam", reason="the extra `oracle` is not installed")
    true = a_ring(20)
    edges = steps(true, np.random.default_rng(4), 1.0)
    start = reckoned(edges)
    edges.append(Edge(0, 19, inverted(true[0]) @ true[19], information_of(0.03, 0.002), False))
    ours = optimized(start, edges, [], None, GraphParams(first_m=1e-4, first_rad=1e-5))
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for number, pose in enumerate(start):
        values.insert(number, gtsam.Pose3(pose))
    # gtsam's twists have the rotation first.
    order = [3, 4, 5, 0, 1, 2]
    graph.add(gtsam.PriorFactorPose3(0, gtsam.Pose3(), gtsam.noiseModel.Isotropic.Sigma(6, 1e-5)))
    for edge in edges:
        noise = gtsam.noiseModel.Gaussian.Information(edge.information[np.ix_(order, order)])
        graph.add(gtsam.BetweenFactorPose3(edge.from_, edge.to, gtsam.Pose3(edge.pose), noise))
    theirs = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    places_m = np.array([theirs.atPose3(number).translation() for number in range(20)])
    assert ours.poses[:, :3, 3] == pytest.approx(places_m, abs=2e-3)

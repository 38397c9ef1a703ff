"""Pose graphs: known poses come back, and wrong loops do not bend them."""

import numpy as np
import pytest

from vehicle_agent.localization.laser.pose_arrays import between, composed, wrapped
from workshop.laser_mapping.pose_graph import Edge, GraphParams, in_axes_of, optimized

INFORMATION = np.diag([400.0, 400.0, 4000.0])


def circle(count: int) -> np.ndarray:
    angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.stack([5.0 * np.cos(angles), 5.0 * np.sin(angles), wrapped(angles + np.pi / 2)], axis=1)


def edges_of(truth: np.ndarray, noise: float, seed: int = 1) -> list[Edge]:
    rng = np.random.default_rng(seed)
    found = [(a, a + 1, False) for a in range(len(truth) - 1)] + [(0, len(truth) - 1, True)]
    return [
        Edge(a, b, between(truth[a], truth[b]) + noise * rng.normal(size=3), INFORMATION, is_loop)
        for a, b, is_loop in found
    ]


def drifted(edges: list[Edge], first: np.ndarray) -> np.ndarray:
    poses = [first]
    for edge in edges:
        if not edge.is_loop:
            poses.append(composed(poses[-1], edge.pose))
    return np.array(poses)


def test_exact_edges_give_the_truth_from_a_wrong_start() -> None:
    truth = circle(40)
    start = truth + np.random.default_rng(2).normal(0.0, 0.3, truth.shape)
    start[0] = truth[0]
    found = optimized(start, edges_of(truth, 0.0), GraphParams())
    assert found.poses[:, :2] == pytest.approx(truth[:, :2], abs=1e-4)
    assert np.abs(wrapped(found.poses[:, 2] - truth[:, 2])).max() < 1e-4


def test_a_loop_takes_drift_away() -> None:
    truth = circle(60)
    edges = edges_of(truth, 0.01)
    start = drifted(edges, truth[0])
    found = optimized(start, edges, GraphParams())
    before, after = (np.hypot(*(poses - truth)[:, :2].T).mean() for poses in (start, found.poses))
    assert after < 0.6 * before
    assert (found.poses[0] == truth[0]).all()


def test_a_wrong_loop_loses_its_weight() -> None:
    truth = circle(60)
    edges = edges_of(truth, 0.0)
    wrong = Edge(10, 40, np.array([0.0, 0.0, 1.0]), INFORMATION, True)
    found = optimized(truth + 0.0, [*edges, wrong], GraphParams())
    assert found.weights[-1] < 0.01
    assert found.weights[-2] == pytest.approx(1.0)
    assert np.hypot(*(found.poses - truth)[:, :2].T).max() < 0.05


def test_a_graph_of_one_node_or_without_edges_stays_as_it_is() -> None:
    for poses in (np.zeros((1, 3)), circle(3)):
        found = optimized(poses, [], GraphParams())
        assert (found.poses == poses).all()


def test_information_turns_with_its_axes() -> None:
    turned = in_axes_of(np.array([0.0, 0.0, np.pi / 2]), np.diag([1.0, 9.0, 4.0]))
    assert turned == pytest.approx(np.diag([9.0, 1.0, 4.0]), abs=1e-12)

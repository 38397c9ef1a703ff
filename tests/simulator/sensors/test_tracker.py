import math

import numpy as np
import pytest

from contract.geometry import Pose2
from simulator.sensors.tracker import Tracker, TrackerNoise
from simulator.traffic.actors import Bodies
from vehicle_agent.signals import PEDESTRIAN, VEHICLE, TrackPercept

NO_WALLS = np.empty((0, 4))
EXACT = TrackerNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0)
STEP_NS = 20_000_000


def bodies(*rows: tuple[int, float, float, float, float]) -> Bodies:
    """rows: kind, x, y, vx, vy; numbers from 1."""
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    kinds = table[:, 0].astype(np.int64)
    sizes = np.array([(0.5, 0.5) if kind == PEDESTRIAN else (4.5, 1.8) for kind in kinds])
    yaws = np.arctan2(table[:, 4], table[:, 3])
    return Bodies(
        np.arange(1, len(table) + 1, dtype=np.int64),
        kinds,
        np.column_stack((table[:, 1:3], yaws)),
        table[:, 3:].copy(),
        sizes.reshape(-1, 2),
    )


def a_tracker(noise: TrackerNoise = EXACT, walls: np.ndarray = NO_WALLS, seed: int = 1) -> Tracker:
    return Tracker(noise, walls, 0.0, np.random.default_rng(seed))


def test_without_noise_it_tells_the_truth_in_the_vehicles_frame() -> None:
    pose = Pose2(10.0, 0.0, math.pi / 2)
    percept = a_tracker().percepts(STEP_NS, pose, bodies((PEDESTRIAN, 10.0, 5.0, 1.0, 0.0)))[0]
    np.testing.assert_allclose(percept.poses_base[0, :2], (5.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(percept.velocities_base_mps[0], (0.0, -1.0), atol=1e-12)


def test_it_is_late_and_says_of_when_it_speaks() -> None:
    tracker = a_tracker(TrackerNoise(latency_ns=80_000_000))
    told: list[tuple[int, TrackPercept]] = []
    for k in range(1, 30):
        now_ns = k * STEP_NS
        here = tracker.percepts(now_ns, Pose2(0.0, 0.0, 0.0), bodies((PEDESTRIAN, 5.0, 0.0, 0.0, 0.0)))
        told += [(now_ns, percept) for percept in here]
    assert {now_ns - percept.stamp_ns for now_ns, percept in told} == {80_000_000}
    assert np.diff([percept.stamp_ns for _, percept in told]).tolist() == [100_000_000] * (len(told) - 1)


@pytest.mark.parametrize("hidden_by", ["car", "wall"])
def test_who_is_behind_something_is_not_seen(hidden_by: str) -> None:
    walls = np.array([[8.0, -3.0, 8.0, 3.0]]) if hidden_by == "wall" else NO_WALLS
    things = [(PEDESTRIAN, 12.0, 0.0, 0.0, 0.0), (PEDESTRIAN, 0.0, 12.0, 0.0, 0.0)]
    if hidden_by == "car":
        things.append((VEHICLE, 8.0, 0.0, 0.0, 1e-9))
    percept = a_tracker(walls=walls).percepts(STEP_NS, Pose2(0.0, 0.0, 0.0), bodies(*things))[0]
    assert 1 not in percept.ids
    assert 2 in percept.ids


def test_misses_and_errors_are_as_often_and_as_large_as_stated() -> None:
    tracker = a_tracker(TrackerNoise(dropout_ratio=0.2, latency_ns=0))
    errors, missed, looks = [], 0, 2000
    for k in range(looks):
        percepts = tracker.percepts(
            k * 5 * STEP_NS, Pose2(0.0, 0.0, 0.0), bodies((PEDESTRIAN, 9.0, 0.0, 0.0, 0.0))
        )
        missed += not len(percepts[0].ids)
        errors += (percepts[0].poses_base[:, 0] - 9.0).tolist()
    assert missed / looks == pytest.approx(0.2, abs=0.04)
    assert np.std(errors) == pytest.approx(0.07, rel=0.25)


def test_the_same_seed_tells_the_same() -> None:
    def told(seed: int) -> bytes:
        tracker = a_tracker(TrackerNoise(latency_ns=0), seed=seed)
        rows = [
            tracker.percepts(k * 5 * STEP_NS, Pose2(0.0, 0.0, 0.0), bodies((PEDESTRIAN, 9.0, 1.0, 0.0, 1.0)))[
                0
            ]
            for k in range(20)
        ]
        return b"".join(row.poses_base.tobytes() for row in rows)

    assert told(3) == told(3) != told(4)

"""The s-t graph that people read is the one that was planned with."""

import numpy as np
import pytest

from tests.vehicle_agent.planning.motion.scenes import a_corridor, a_request, people
from vehicle_agent.planning.motion.plan import plan_motion
from vehicle_agent.planning.motion.request import MotionParams
from vehicle_agent.signals import UNBOUNDED_CM, PathGraph

PARAMS = MotionParams()


def graph_of(**scene: object) -> tuple[PathGraph, np.ndarray]:
    motion = plan_motion(a_request(**scene), PARAMS)  # type: ignore[arg-type]
    assert motion.graph is not None
    return motion.graph, motion.rows


def test_the_chosen_way_is_the_trajectory_and_stays_in_the_corridor() -> None:
    graph, rows = graph_of(speed_mps=3.0, agents=people((15.0, -6.0, 0.0, 1.4)))
    times = graph.dt_s * np.arange(len(graph.way_cm))
    # On a straight line the way along the path is the way along the line.
    way_m = np.interp(times, rows[:, 0], rows[:, 7] - rows[0, 7])
    np.testing.assert_allclose(graph.way_cm / 100.0, way_m, atol=0.02)
    assert (graph.way_cm <= graph.high_cm.astype(int) + 10).all()
    assert (graph.way_cm >= graph.low_cm.astype(int) - 10).all()


def test_a_person_who_crosses_is_on_the_path_when_they_are_predicted_to_be() -> None:
    graph, _ = graph_of(speed_mps=3.0, agents=people((15.0, -6.0, 0.0, 1.4)))
    assert list(graph.ids) == [0]
    on_path = np.flatnonzero(graph.from_cm[:, 0] <= graph.to_cm[:, 0])
    # 6 m at 1.4 m/s, less half the body and margins, and as long on the other side.
    assert 2.0 < graph.dt_s * on_path[0] < 4.3 < graph.dt_s * on_path[-1] < 6.5
    # The vehicle's nose is met before the person's own place, its rear after it.
    assert graph.from_cm[on_path, 0].min() < 1500 < graph.to_cm[on_path, 0].max() + 600
    # Only there does anything bound the way upwards but the end of the path.
    assert graph.high_cm[0] > graph.high_cm[on_path].min()


def test_a_free_road_has_no_tracks_and_its_speed_limit() -> None:
    graph, _ = graph_of()
    assert len(graph.ids) == 0
    assert (graph.low_cm == -UNBOUNDED_CM).all()
    assert graph.limits[0].reason == "speed_limit"
    assert graph.limits[0].speed_mps == pytest.approx(4.17, abs=0.05)


def test_limits_are_named_by_what_causes_them_and_follow_each_other() -> None:
    graph, _ = graph_of(corridor=a_corridor(1.0 / 12.0), speed_mps=2.0, curvature_1pm=1.0 / 12.0)
    assert "curve" in {limit.reason for limit in graph.limits}
    for limit, following in zip(graph.limits, graph.limits[1:], strict=False):
        assert limit.from_m < limit.to_m == following.from_m
        assert limit.reason != following.reason

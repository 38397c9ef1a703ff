"""What an operator who looks gets: bounded, for a minute, and nothing that is no longer so."""

import msgspec
import numpy as np
import pytest

from contract.geometry import Pose2
from contract.wire.codec import decode_from_vehicle, encode
from contract.wire.messages import Command, CommandDone
from tests.contract.roads.ring_map import ring_map
from vehicle_agent.config import Profile
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.onboard.onboard_scene import SHOW_EVERY_TICKS, SHOWN_NS, SceneSource, path_times
from vehicle_agent.onboard.tick import tick
from vehicle_agent.signals import (
    UNBOUNDED_CM,
    Detections,
    InboxItem,
    Inputs,
    Outputs,
    PathGraph,
    PathLimit,
    PlanAnswer,
    PlanMemory,
    Trajectory,
)
from vehicle_agent.stacks.gem import gem

TICK_NS = 20_000_000
KNOTS = 41


@pytest.fixture(scope="module")
def outputs() -> Outputs:
    car = gem(Profile(), ring_map())
    return tick(initial_state(car), Inputs(1_000), car)[1]


def a_graph(tracks: int) -> PathGraph:
    free = np.full(KNOTS, UNBOUNDED_CM, np.int16)
    return PathGraph(
        dt_s=0.2,
        way_cm=np.arange(KNOTS, dtype=np.int16) * 83,
        low_cm=-free,
        high_cm=free,
        ids=np.arange(tracks) + 1_000_000,
        from_cm=np.full((KNOTS, tracks), 1234, np.int16),
        to_cm=np.full((KNOTS, tracks), 2345, np.int16),
        limits=(PathLimit(0.0, 40.0, 4.17, "speed_limit"),) * 12,
    )


def an_answer(stamp_ns: int, tracks: int = 1) -> PlanAnswer:
    yields_to = np.array([1_000_000])
    rows = np.zeros((2, 8))
    rows[1, 0] = 8.0
    return PlanAnswer(1, stamp_ns, 1, rows, "obstacle", np.inf, yields_to, (), PlanMemory(), a_graph(tracks))


def driving(outputs: Outputs, answer: PlanAnswer, points: int = 0) -> Outputs:
    """The tick follows this plan and sees so many cells around."""
    angles = np.arange(points) * 0.7
    cells = np.column_stack((39.0 * np.cos(angles), 39.0 * np.sin(angles)))
    flow = msgspec.structs.replace(
        outputs.flow,
        ego=msgspec.structs.replace(outputs.flow.ego, pose_map=Pose2(0.0, 0.0, 0.0)),
        detections=Detections(5, cells, False),
        path=msgspec.structs.replace(
            outputs.flow.path, trajectory=Trajectory(answer.stamp_ns, answer.trajectory)
        ),
    )
    return msgspec.structs.replace(outputs, flow=flow)


def asked(source: SceneSource, outputs: Outputs, stamp_ns: int, done: bool = True) -> None:
    items = [InboxItem(stamp_ns, "link", 0, Command(1, "command-1", "show_scene"))]
    answered = msgspec.structs.replace(outputs, events=(CommandDone("command-1", done),))
    source.observe(items, answered, stamp_ns)


def test_a_scene_is_shown_for_a_minute_and_2_5_times_a_second(outputs: Outputs) -> None:
    source = SceneSource()
    asked(source, outputs, TICK_NS)
    shown = []
    for k in range(2, 3200):
        source.observe([], outputs, k * TICK_NS)
        if source.is_due(k * TICK_NS):
            shown.append(k * TICK_NS)
    assert set(np.diff(shown)) == {SHOW_EVERY_TICKS * TICK_NS}
    assert shown[-1] < TICK_NS + SHOWN_NS
    assert len(shown) == 150


def test_a_request_that_was_refused_shows_nothing(outputs: Outputs) -> None:
    source = SceneSource()
    asked(source, outputs, TICK_NS, done=False)
    for k in range(2, 100):
        source.observe([], outputs, k * TICK_NS)
        assert not source.is_due(k * TICK_NS)


def test_the_largest_scene_takes_no_more_than_is_said(outputs: Outputs) -> None:
    answer = an_answer(1_000, tracks=8)
    source = SceneSource()
    source.observe([InboxItem(1, "planner", 0, answer)], outputs, 2_000)
    scene = source.scene(driving(outputs, answer, points=5_000).flow, 2_000, None, with_points=True)
    assert len(scene.points) == 1_200
    assert len(encode(scene)) < 16_000
    assert decode_from_vehicle(encode(scene)) == scene


def test_a_plan_that_is_no_longer_driven_is_not_shown(outputs: Outputs) -> None:
    answer = an_answer(1_000)
    source = SceneSource()
    source.observe([InboxItem(1, "planner", 0, answer)], outputs, 2_000)
    driven = driving(outputs, answer).flow
    assert source.scene(driven, 2_000, None, with_points=False).path_times is not None
    stopped = driving(outputs, msgspec.structs.replace(answer, stamp_ns=500)).flow
    assert source.scene(stopped, 2_000, None, with_points=False).path_times is None
    assert source.scene(outputs.flow, 2_000, None, with_points=False).path_times is None


def test_an_open_corridor_is_told_as_open_and_who_is_yielded_to_as_that() -> None:
    times = path_times(a_graph(2), 0.5, {1_000_001})
    assert set(times.low_m) == set(times.high_m) == {None}
    assert [(track.track_id, track.yielded_to) for track in times.tracks] == [
        (1_000_000, False),
        (1_000_001, True),
    ]
    assert times.tracks[0].knots == tuple(range(KNOTS))
    assert (times.tracks[0].from_m[0], times.tracks[0].to_m[0]) == (12.34, 23.45)

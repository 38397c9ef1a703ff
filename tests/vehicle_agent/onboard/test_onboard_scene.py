"""What an operator who looks gets: bounded, for a minute, and nothing that is no longer so."""

import math

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
from vehicle_agent.onboard.seen_things import SCAN_NS_MAX
from vehicle_agent.onboard.tick import tick
from vehicle_agent.signals import (
    TRACK_KINDS,
    UNBOUNDED_CM,
    Detections,
    InboxItem,
    Inputs,
    Outputs,
    PathGraph,
    PathLimit,
    PlanAnswer,
    PlanMemory,
    SeenSign,
    ThinnedScan,
    Tracks,
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


def around(count: int, radius_m: float) -> np.ndarray:
    angles = np.arange(count) * 0.7
    return np.column_stack((radius_m * np.cos(angles), radius_m * np.sin(angles)))


def tracks_around(count: int) -> Tracks:
    return Tracks(
        5,
        np.arange(count) + 1_000_000,
        np.arange(count) % len(TRACK_KINDS),
        np.column_stack((around(count, 38.0), np.full(count, -3.1))),
        np.full((count, 2), -1.234),
        np.full((count, 2), 0.567),
    )


def driving(
    outputs: Outputs, answer: PlanAnswer, points: int = 0, tracks: int = 0, signs: int = 0
) -> Outputs:
    """The tick follows this plan and sees so many cells, road users and signs around."""
    seen = [SeenSign(k, "board", Pose2(-30.0 - k, 20.0, -1.0), 30.0) for k in range(signs)]
    flow = msgspec.structs.replace(
        outputs.flow,
        ego=msgspec.structs.replace(outputs.flow.ego, pose_map=Pose2(0.0, 0.0, 0.0)),
        detections=Detections(5, around(points, 39.0), False, tracks_around(tracks), tuple(seen)),
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
    source = SceneSource("own")
    full = driving(outputs, answer, points=5_000, tracks=200, signs=50)
    scan = ThinnedScan(1_500, np.full(3 * 1_200, -12_345, np.int16).tobytes())
    items = [InboxItem(1, "planner", 0, answer), InboxItem(2, "thinned scans", 0, scan)]
    source.observe(items, full, 2_000)
    scene = source.scene(full.flow, 2_000, None, with_points=True)
    assert len(scene.points) == 600
    assert (len(scene.tracks), len(scene.signs)) == (30, 12)
    assert scene.scan is not None
    assert len(scene.scan.offsets_cm) == 400 * 6
    # 2.5 times a second: 40 kB/s.
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


def test_a_scan_lies_where_the_vehicle_was_when_it_was_measured(outputs: Outputs) -> None:
    """The vehicle drives north at 5 m/s, and the scan is told 0.2 s late."""
    source = SceneSource()
    for k in range(1, 21):
        ego = msgspec.structs.replace(outputs.flow.ego, pose_map=Pose2(100.0, 50.0 + 0.1 * k, 0.5 * math.pi))
        at_pose = msgspec.structs.replace(outputs, flow=msgspec.structs.replace(outputs.flow, ego=ego))
        scan = ThinnedScan(10 * TICK_NS, np.array([[500, -200, 150]], np.int16).tobytes())
        items = [InboxItem(1, "thinned scans", 0, scan)] if k == 20 else []
        source.observe(items, at_pose, k * TICK_NS)
    shown = source.scene(outputs.flow, 20 * TICK_NS, None, with_points=True).scan
    assert shown is not None
    assert (shown.x_m, shown.y_m, shown.age_s) == (100.0, 51.0, 0.2)
    # 5 m ahead is north of it, 2 m to the right is east.
    assert np.frombuffer(shown.offsets_cm, "<i2").tolist() == [200, 500, 150]
    assert source.scene(outputs.flow, 20 * TICK_NS, None, with_points=False).scan is None
    assert source.scene(outputs.flow, 20 * TICK_NS + SCAN_NS_MAX, None, with_points=True).scan is None


def test_what_is_seen_is_told_with_identity_velocity_and_distance(outputs: Outputs) -> None:
    signs = (
        SeenSign(2, "board", Pose2(30.0, 4.0, 3.0), 25.0),
        SeenSign(1, "stop", Pose2(3.0, 14.0, -1.5), 9.0),
    )
    flow = msgspec.structs.replace(
        outputs.flow,
        ego=msgspec.structs.replace(outputs.flow.ego, pose_map=Pose2(3.0, 4.0, 0.0)),
        detections=Detections(5, np.empty((0, 2)), False, tracks_around(3), signs),
        path=msgspec.structs.replace(outputs.flow.path, yields_to=(1_000_001,)),
    )
    scene = SceneSource("own").scene(flow, 100_000_005, None, with_points=False)
    assert (scene.tracks_by, scene.tracks_age_s) == ("own", 0.1)
    by_id = {track.track_id: track for track in scene.tracks}
    assert [by_id[1_000_000 + k].kind for k in range(3)] == ["pedestrian", "cyclist", "vehicle"]
    assert [by_id[1_000_000 + k].yielded_to for k in range(3)] == [False, True, False]
    assert (by_id[1_000_000].velocity_x_mps, by_id[1_000_000].length_m) == (-1.23, 0.57)
    assert [(sign.sign_id, sign.kind, sign.distance_m) for sign in scene.signs] == [
        (1, "stop", 10.0),
        (2, "board", 27.0),
    ]


def test_a_vehicle_that_does_not_know_where_it_is_shows_no_places(outputs: Outputs) -> None:
    nowhere = driving(outputs, an_answer(1_000), points=9, tracks=3, signs=2)
    ego = msgspec.structs.replace(nowhere.flow.ego, pose_map=Pose2(math.nan, math.nan, 0.0))
    lost = msgspec.structs.replace(nowhere, flow=msgspec.structs.replace(nowhere.flow, ego=ego))
    source = SceneSource("own")
    source.observe([InboxItem(1, "thinned scans", 0, ThinnedScan(1, bytes(6)))], lost, 2_000)
    scene = source.scene(lost.flow, 2_000, None, with_points=True)
    assert (scene.points, scene.tracks, scene.signs, scene.scan) == ((), (), (), None)

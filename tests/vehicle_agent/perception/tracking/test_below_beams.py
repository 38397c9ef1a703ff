"""A person close before the bumper is below the lidars' beams, and has not gone."""

import math

import numpy as np
import pytest

from contract.geometry import Pose2
from tests.vehicle_agent.perception.test_height_map import a_scan
from vehicle_agent.perception.own_tracks import TracksWorker
from vehicle_agent.perception.points.chain import PointPerception
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.perception.tracking.below_beams import NearArea
from vehicle_agent.perception.tracking.params import DEFAULT_PARAMS
from vehicle_agent.perception.tracking.tracker import ObjectTracker
from vehicle_agent.signals import PEDESTRIAN, TrackPercept
from vehicle_agent.signals.objects import EgoMotion, SeenObjects

BUMPER_M = 3.5
AREA = NearArea(-0.85, BUMPER_M, BUMPER_M + 3.5, 0.8, 1.8)
TRACKER = ObjectTracker(viewpoint_x_m=1.3, below_beams=AREA)
HERE = Pose2(0.0, 0.0, 0.0)
# Scans: seen as they come, the last of them by their top alone.
COMES = 20


class Scene:
    """A tracker that is told where a person is seen, scan after scan."""

    def __init__(self) -> None:
        self.number, self.state = 0, TRACKER.initial()

    def scan(self, place: tuple[float, float] | None, visible_m: float, pose: Pose2 = HERE) -> TrackPercept:
        """place: None for a scan without a person."""
        n = 0 if place is None else 1
        places = np.zeros((n, 3))
        if place is not None:
            places[0, :2] = place
        seen = SeenObjects(
            1_000_000_000 + 100_000_000 * self.number, np.full(n, PEDESTRIAN), np.full(n, 0.8), places,
            np.tile((0.5, 0.5, 1.5), (n, 1)), np.full((n, 2), math.nan), visible_m=np.full(n, visible_m),
        )  # fmt: skip
        self.number += 1
        percept, self.state = TRACKER.step(self.state, seen, pose)
        return percept

    def comes_up(self, visible_m: float, x_m: float = BUMPER_M + 0.5) -> TrackPercept:
        """A person walks up to x_m, of whom visible_m are seen at last."""
        for k in range(COMES):
            left_m = 0.1 * (COMES - 1 - k)
            percept = self.scan((x_m + left_m, -0.4), max(visible_m, 1.2 * left_m))
        return percept

    def walks_along(
        self, speed_mps: float, side: float, pose: Pose2, from_m: float = BUMPER_M - 0.9
    ) -> TrackPercept:
        """A person walks along the flank up to from_m, of whom the top of the head is seen at last."""
        for k in range(COMES):
            left_s = 0.1 * (COMES - 1 - k)
            percept = self.scan((from_m - speed_mps * left_s, side * 1.25), 0.05 + 0.2 * left_s, pose)
        return percept

    def nothing(self, scans: int, pose: Pose2 = HERE) -> TrackPercept:
        for _ in range(scans):
            percept = self.scan(None, 0.0, pose)
        return percept


def test_who_walks_up_to_the_bumper_stays_there_until_they_are_seen_to_leave() -> None:
    scene = Scene()
    number = scene.comes_up(0.05).ids.tolist()
    percept = scene.nothing(200)
    assert percept.ids.tolist() == number
    assert percept.poses_base[0, :2] == pytest.approx((BUMPER_M + 0.5, -0.4), abs=0.7)
    assert np.hypot(*percept.velocities_base_mps[0]) < 0.05
    for k in range(10):
        percept = scene.scan((BUMPER_M + 0.6, 1.0 + 0.1 * k), 0.3 + 0.1 * k)
    assert percept.ids.tolist() == number, "who appears beside them is them, and nobody stays behind"
    assert percept.velocities_base_mps[0, 1] == pytest.approx(1.0, abs=0.3)


@pytest.mark.parametrize("yaw_rad", [0.0, 2.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_who_walked_along_the_flank_and_does_not_come_out_at_the_corner_has_turned_in(
    side: float, yaw_rad: float
) -> None:
    scene, pose = Scene(), Pose2(20.0, 5.0, yaw_rad)
    number = scene.walks_along(1.2, side, pose).ids.tolist()
    aside_m = [abs(scene.nothing(1, pose).poses_base[0, 1]) for _ in range(8)]
    assert aside_m == pytest.approx([1.25] * 8, abs=0.1), "beside the body they can but walk on"
    percept = scene.nothing(30, pose)
    assert percept.ids.tolist() == number
    x_m, y_m = percept.poses_base[0, :2]
    assert BUMPER_M < x_m < BUMPER_M + 1.0
    assert abs(y_m) < 0.8, "who would be seen elsewhere is before it"
    for k in range(10):
        percept = scene.scan((BUMPER_M + 0.8 + 0.1 * k, side * 1.2), 0.2 + 0.1 * k, pose)
    assert percept.ids.tolist() == number, "the same person has come out, and nobody is left behind"


def test_who_walks_back_along_the_flank_is_found_where_they_come_into_view() -> None:
    scene = Scene()
    number = scene.walks_along(-1.2, 1.0, HERE, from_m=BUMPER_M).ids.tolist()
    percept = scene.nothing(10)
    assert percept.poses_base[0, 0] < BUMPER_M - 1.0
    for k in range(5):
        percept = scene.scan((BUMPER_M - 1.6 - 0.12 * k, 1.25), 0.4)
    assert percept.ids.tolist() == number


@pytest.mark.parametrize("error_mps", [0.0, 0.15, -0.15])
def test_who_stands_beside_the_body_stays_beside_it(error_mps: float) -> None:
    """error_mps: what the track says of them as they are lost."""
    scene = Scene()
    number = scene.walks_along(error_mps, 1.0, HERE).ids.tolist()
    percept = scene.nothing(100)
    assert percept.ids.tolist() == number
    assert percept.poses_base[0, :2] == pytest.approx((BUMPER_M - 0.9, 1.25), abs=0.2)


def test_who_appears_where_they_cannot_be_yet_is_somebody_else() -> None:
    scene = Scene()
    number = scene.comes_up(0.05).ids.tolist()
    scene.nothing(5)
    for _ in range(5):
        percept = scene.scan((BUMPER_M + 3.0, 2.3), 1.2)
    assert len(percept.ids) == 2
    assert set(number) < set(percept.ids.tolist())


def test_who_comes_out_far_from_the_vehicle_is_somebody_else() -> None:
    scene = Scene()
    number = scene.comes_up(0.05).ids.tolist()
    scene.nothing(100)
    for _ in range(5):
        percept = scene.scan((BUMPER_M + 0.5, 7.0), 1.2)
    assert set(number) < set(percept.ids.tolist())


def test_who_was_seen_from_head_to_foot_and_is_not_any_more_has_gone() -> None:
    scene = Scene()
    scene.comes_up(1.2)
    assert len(scene.nothing(DEFAULT_PARAMS.shown_scans + 1).ids) == 0


def test_who_was_seen_by_their_top_far_away_is_not_kept() -> None:
    scene = Scene()
    scene.comes_up(0.05, x_m=BUMPER_M + 5.0)
    assert len(scene.nothing(DEFAULT_PARAMS.shown_scans + 1).ids) == 0


def test_the_place_that_comes_into_view_is_empty() -> None:
    """The vehicle rolls back: whoever had stood before its bumper would be seen now."""
    scene = Scene()
    scene.comes_up(0.05)
    assert len(scene.nothing(40).ids) == 1
    assert len(scene.nothing(1, Pose2(-4.0, 0.0, 0.0)).ids) == 0


def test_nobody_stays_in_the_own_body() -> None:
    scene = Scene()
    scene.comes_up(0.05, x_m=BUMPER_M - 0.2)
    assert len(scene.nothing(DEFAULT_PARAMS.shown_scans + 1).ids) == 0


def test_whoever_stands_there_for_minutes_is_not_forgotten() -> None:
    scene = Scene()
    scene.comes_up(0.05)
    assert len(scene.nothing(3000).ids) == 1


@pytest.mark.parametrize("visible_m", [0.05, 0.3])
def test_whoever_stands_there_is_not_forgotten_while_no_scan_comes(visible_m: float) -> None:
    scene = Scene()
    number = scene.comes_up(visible_m).ids.tolist()
    scene.number += 100
    percept = scene.nothing(50)
    assert percept.ids.tolist() == number
    assert percept.poses_base[0, :2] == pytest.approx((BUMPER_M + 0.5, -0.4), abs=0.3)
    scene.number += 100
    for k in range(5):
        percept = scene.scan((BUMPER_M + 0.5, 1.4 + 0.1 * k), 1.2)
    assert percept.ids.tolist() == number, "who has stepped aside meanwhile is them"


def test_who_was_seen_from_head_to_foot_is_forgotten_while_no_scan_comes() -> None:
    scene = Scene()
    scene.comes_up(1.2)
    scene.number += 100
    assert len(scene.nothing(1).ids) == 0


def roof_worker() -> TracksWorker:
    return TracksWorker(
        PointPerception(
            PointGrid(2.4, BUMPER_M, 0.85, 0.82),
            tracker=ObjectTracker(below_beams=NearArea(3.0, BUMPER_M, 9.0, 0.8, 1.8)),
        )
    )


class RoofLidarDrive:
    """Under one lidar on the roof: a child of 1.2 m comes up to it, and is below all beams from 7 m on."""

    def __init__(self, waved_on_ns: int = 0) -> None:
        self.worker = roof_worker()
        self.number, self.waved_on_ns = 0, waved_on_ns
        self.shown = [len(self.scan(max(5.0, 10.0 - 0.1 * k)).ids) for k in range(1, 90)]

    def scan(self, x_m: float) -> TrackPercept:
        self.number += 1
        now_ns = 100_000_000 * self.number
        self.worker.take(EgoMotion(now_ns, 0.0, 0.0, self.waved_on_ns))
        points = a_scan([(x_m, 0.2, 0.4, 1.2)])
        _, tracks = self.worker.percepts(np.column_stack((points, np.zeros((len(points), 2)))), now_ns)
        assert isinstance(tracks, TrackPercept)
        return tracks


def test_a_child_before_the_bumper_is_not_forgotten_by_the_whole_chain() -> None:
    assert RoofLidarDrive().shown[-1] == 1


def test_a_worker_that_goes_on_in_the_place_of_another_knows_who_stands_there() -> None:
    drive = RoofLidarDrive(waved_on_ns=42)
    below = drive.worker.below_beams()
    drive.worker = roof_worker()
    assert len(drive.scan(5.0).ids) == 0, "it cannot see them"
    drive.worker = roof_worker()
    drive.worker.remember(below)
    assert [len(drive.scan(5.0).ids) for _ in range(100)] == [1] * 100
    assert drive.scan(5.0).poses_base[0, :2] == pytest.approx(below.people_base[0][:2], abs=0.1)
    drive.waved_on_ns = 43
    assert len(drive.scan(5.0).ids) == 0


def test_an_operator_who_has_looked_while_no_worker_ran_is_believed() -> None:
    drive = RoofLidarDrive()
    below = drive.worker.below_beams()
    drive.worker, drive.waved_on_ns = roof_worker(), 42
    drive.worker.remember(below)
    assert len(drive.scan(5.0).ids) == 0


@pytest.mark.parametrize(("visible_m", "told"), [(0.05, 1), (0.3, 1), (1.2, 0)])
def test_only_who_is_hardly_seen_is_handed_over(visible_m: float, told: int) -> None:
    scene = Scene()
    scene.comes_up(visible_m)
    assert len(TRACKER.people_below(scene.state, HERE)) == told


def test_an_operator_who_has_looked_and_waves_it_on_ends_the_wait_for_whoever_is_not_seen() -> None:
    drive = RoofLidarDrive()
    drive.waved_on_ns = 42
    assert len(drive.scan(5.0).ids) == 0


def test_a_tick_that_was_started_again_is_no_operator_who_has_looked() -> None:
    drive = RoofLidarDrive(waved_on_ns=42)
    drive.waved_on_ns = 0
    assert len(drive.scan(5.0).ids) == 1


def test_that_forgets_nobody_who_is_seen_and_none_who_come_after_it() -> None:
    scene = Scene()
    number = scene.comes_up(1.2).ids.tolist()
    scene.state = TRACKER.without_below(scene.state)
    for visible_m in (1.2, 0.8, 0.4, 0.05):
        assert scene.scan((BUMPER_M + 0.5, -0.4), visible_m).ids.tolist() == number
    assert scene.nothing(100).ids.tolist() == number

"""What a vehicle with one laser and cameras knows of the people around it."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Pose2
from simulator.sensors.cameras.mounts import CameraMount
from tests.vehicle_agent.perception.laser_people.test_segments import ANGLES, scan_of
from vehicle_agent.perception.laser_people.people import LaserPeople, LaserPeopleState, beams_of
from vehicle_agent.signals import OTHER, PEDESTRIAN
from vehicle_agent.signals.pictures import Picture, PinholeCamera, optical_pose

STEP_NS = 40_000_000
ROOM = LaserPeople()
MOUNT = CameraMount("front", optical_pose(0.0, 0.0, 1.6, 0.0))
CAMERA = PinholeCamera("front", MOUNT.K, MOUNT.T_base_camera, 640, 480)
HERE = Pose2(0.0, 0.0, 0.0)


class Scorer:
    """Answers by column of the picture: people are where `people_px` says, upright or on their heads."""

    def __init__(self, people_px: list[float], upside_down: bool = False) -> None:
        self.people_px, self.upside_down, self.looks = people_px, upside_down, 0

    def score(self, pixels: np.ndarray, feet_px: tuple[float, float], height_px: float) -> float:
        self.looks += 1
        is_turned = pixels.strides[0] < 0
        u = 639 - feet_px[0] if is_turned else feet_px[0]
        is_there = any(abs(u - place) < 0.2 * height_px for place in self.people_px)
        return 1.5 if is_there and is_turned == self.upside_down else -1.5


def pixel_of(x_m: float, y_m: float) -> float:
    return float(MOUNT.K[0, 2] - MOUNT.K[0, 0] * y_m / x_m)


def a_picture(number: int) -> Picture:
    rng = np.random.default_rng(number)
    return Picture("front", number * STEP_NS, rng.integers(0, 255, (480, 640, 3), dtype=np.uint8))


class Rig:
    """Walks things (x, y, vx, vy) past a vehicle; pictures come with every third scan."""

    def __init__(self, things: list[tuple[float, float, float, float]], scorer: Scorer | None = None) -> None:
        self.things, self.scorer = things, scorer
        self.state, self.number = LaserPeopleState(), 0

    def places(self) -> list[tuple[float, float]]:
        t = self.number * STEP_NS * 1e-9
        return [(x + t * vx, y + t * vy) for x, y, vx, vy in self.things]

    def run(self, scans: int, picture: Picture | None = None, pose_map: Pose2 = HERE) -> "Rig":
        for _ in range(scans):
            self.number += 1
            rng = np.random.default_rng(self.number)
            ranges = scan_of([(x, y, 0.2) for x, y in self.places()]) + rng.normal(0.0, 0.01, len(ANGLES))
            self.state = ROOM.after_scan(
                self.state, ranges, ANGLES, np.eye(4), pose_map, self.number * STEP_NS
            )
            if self.scorer is not None and self.number % 3 == 0:
                shown = a_picture(self.number)
                if picture is not None:
                    shown = Picture("front", shown.stamp_ns, picture.pixels)
                self.state = ROOM.after_picture(self.state, shown, CAMERA, pose_map, self.scorer)
        return self


@given(
    st.floats(6.0, 25.0),
    st.floats(-4.0, 4.0),
    st.floats(-1.5, 1.5),
    st.floats(-1.5, 1.5),
    st.floats(-3.0, 3.0),
)
@settings(max_examples=25, deadline=None)
def test_a_walker_keeps_one_identity_and_its_velocity_is_found(
    x: float, y: float, vx: float, vy: float, yaw_rad: float
) -> None:
    pose_map = Pose2(20.0, -7.0, yaw_rad)
    rig = Rig([(x, y, vx, vy)]).run(5, pose_map=pose_map)
    first = rig.state.tracks.ids.tolist()
    rig.run(45, pose_map=pose_map)
    tracks = rig.state.tracks
    assert tracks.ids.tolist() == first
    percept = ROOM.track_percept(LaserPeopleState(tracks), pose_map)
    # Without a camera, all that could be a person is told of.
    assert np.hypot(*(percept.poses_base[0, :2] - rig.places()[0])) < 0.25
    assert np.hypot(*(percept.velocities_base_mps[0] - (vx, vy))) < 0.4


def test_a_person_whom_pictures_verify_keeps_the_label_when_they_miss() -> None:
    scorer = Scorer([pixel_of(12.0, 1.0)])
    rig = Rig([(12.0, 1.0, 0.0, 0.0)], scorer).run(15)
    assert rig.state.tracks.is_person.tolist() == [True]
    assert ROOM.seen_objects(rig.state, HERE).kinds.tolist() == [PEDESTRIAN]
    scorer.people_px = []
    rig.run(60)
    assert rig.state.tracks.is_person.tolist() == [True]


def test_a_trunk_is_never_a_person_and_a_standing_thing_is_not_told_of() -> None:
    rig = Rig([(12.0, 1.0, 0.0, 0.0)], Scorer([])).run(75)
    assert not rig.state.tracks.is_person.any()
    assert rig.state.cameras[0].state == "good"
    assert len(ROOM.seen_objects(rig.state, HERE).kinds) == 0


def test_what_moves_is_told_of_though_no_picture_verifies_it() -> None:
    seen = ROOM.seen_objects(Rig([(15.0, -3.0, 0.0, 1.2)], Scorer([])).run(50).state, HERE)
    assert seen.kinds.tolist() == [OTHER]
    assert np.allclose(seen.velocities_base_mps[0], (0.0, 1.2), atol=0.3)


def test_a_walker_who_stops_is_still_told_of() -> None:
    rig = Rig([(12.0, -3.0, 0.0, 1.2)], Scorer([])).run(50)
    rig.things = [(12.0, rig.places()[0][1], 0.0, 0.0)]
    assert ROOM.seen_objects(rig.run(100).state, HERE).kinds.tolist() == [OTHER]


def test_what_a_gap_shows_of_a_wall_does_not_move() -> None:
    # The vehicle drives along a fence with a gap. The part of a wall that is seen through it wanders.
    state, moving = LaserPeopleState(), 0
    left = ANGLES > 0.05
    for number in range(1, 90):
        x = 2.0 * number * STEP_NS * 1e-9
        ranges = np.full(len(ANGLES), np.inf)
        fence_m = 3.0 / np.sin(ANGLES[left])
        in_gap = np.abs(x + fence_m * np.cos(ANGLES[left]) - 12.0) < 0.25
        ranges[left] = np.where(in_gap, 6.0 / np.sin(ANGLES[left]), fence_m)
        pose_map = Pose2(x, 0.0, 0.0)
        state = ROOM.after_scan(state, ranges, ANGLES, np.eye(4), pose_map, number * STEP_NS)
        moving += int(ROOM.is_moving(state.tracks).sum())
    assert moving == 0


def test_leaves_that_jump_about_do_not_move() -> None:
    rng, state, moving = np.random.default_rng(4), LaserPeopleState(), 0
    for number in range(1, 250):
        twigs = [(9.0 + 0.02 * number + rng.normal(0.0, 0.2), rng.normal(0.0, 0.2), 0.05) for _ in range(2)]
        state = ROOM.after_scan(state, scan_of(twigs), ANGLES, np.eye(4), HERE, number * STEP_NS)
        moving += int(ROOM.is_moving(state.tracks).sum())
    assert moving == 0


def test_a_person_before_a_trunk_is_verified_and_the_trunk_is_not() -> None:
    scorer = Scorer([pixel_of(10.0, 1.0)])
    # The trunk is 20 cm beside the line of sight: its region shows the person, too.
    rig = Rig([(10.0, 1.0, 0.0, 0.0), (13.0, 1.9, 0.0, 0.0)], scorer).run(40)
    tracks = rig.state.tracks
    nearer = np.argsort(np.hypot(*tracks.places_map.T))
    assert tracks.is_person[nearer].tolist() == [True, False]


@pytest.mark.parametrize("level", [0, 90, 255])
def test_a_camera_without_a_view_is_noticed_and_gives_no_label(level: int) -> None:
    blind = Picture("front", 0, np.full((480, 640, 3), level, np.uint8))
    scorer = Scorer([pixel_of(12.0, 1.0)])
    rig = Rig([(12.0, 1.0, 0.0, 0.0)], scorer).run(30, blind)
    assert scorer.looks == 0
    assert rig.state.cameras[0].state in ("black", "covered", "dazzled", "frozen")
    # The person is what the laser says: there.
    assert ROOM.seen_objects(rig.state, HERE).kinds.tolist() == [OTHER]


def test_a_frozen_camera_is_noticed_and_labels_stay() -> None:
    scorer = Scorer([pixel_of(12.0, 1.0)])
    rig = Rig([(12.0, 1.0, 0.0, 0.0)], scorer).run(20)
    looks = scorer.looks
    rig.run(40, a_picture(999))
    assert rig.state.cameras[0].state == "frozen"
    assert rig.state.tracks.is_person.tolist() == [True]
    assert scorer.looks <= looks + 8


def test_a_camera_that_hangs_upside_down_is_noticed_and_verifies_nobody() -> None:
    scorer = Scorer([pixel_of(12.0, 1.0)], upside_down=True)
    rig = Rig([(12.0, 1.0, 0.0, 0.0)], scorer).run(40)
    assert rig.state.cameras[0].state == "upside_down"
    assert not rig.state.tracks.is_person.any()
    assert ROOM.seen_objects(rig.state, HERE).kinds.tolist() == [OTHER]


def test_a_picture_of_another_time_is_compared_with_where_the_person_was_then() -> None:
    rig = Rig([(12.0, -3.0, 0.0, 3.0)]).run(20)
    x, y = rig.places()[0]
    for number in range(2):
        stamp_ns = rig.number * STEP_NS - 200_000_000 + number
        scorer = Scorer([pixel_of(x, y - 0.6)])
        picture = Picture("front", stamp_ns, a_picture(number).pixels)
        rig.state = ROOM.after_picture(rig.state, picture, CAMERA, HERE, scorer)
    assert rig.state.tracks.is_person.tolist() == [True]


def test_a_late_scan_and_a_late_picture_change_nothing() -> None:
    rig = Rig([(12.0, 1.0, 0.0, 0.0)], Scorer([])).run(10)
    ranges = scan_of([(5.0, 0.0, 0.2)])
    assert ROOM.after_scan(rig.state, ranges, ANGLES, np.eye(4), HERE, 1).tracks is rig.state.tracks
    assert ROOM.after_picture(rig.state, a_picture(0), CAMERA, HERE, Scorer([])) is rig.state


def test_a_thicket_does_not_make_more_tracks_than_the_budget() -> None:
    rng = np.random.default_rng(1)
    state = LaserPeopleState()
    for number in range(1, 5):
        ranges = rng.uniform(2.0, 30.0, len(ANGLES))
        state = ROOM.after_scan(state, ranges, ANGLES, np.eye(4), HERE, number * STEP_NS)
    assert len(state.tracks) <= ROOM.tracker.tracks_max


@given(st.floats(-3.0, 3.0), st.floats(-1.0, 2.0), st.floats(-1.0, 1.0))
@settings(max_examples=25, deadline=None)
def test_points_of_a_driver_become_ranges_about_the_laser(yaw_rad: float, x: float, y: float) -> None:
    T_base_laser = np.eye(4)
    T_base_laser[:2, :2] = [[math.cos(yaw_rad), -math.sin(yaw_rad)], [math.sin(yaw_rad), math.cos(yaw_rad)]]
    T_base_laser[:3, 3] = x, y, 0.8
    ranges = 10.0 + np.sin(3.0 * ANGLES)
    level = np.column_stack((ranges * np.cos(ANGLES), ranges * np.sin(ANGLES), np.zeros(len(ANGLES))))
    points = level @ T_base_laser[:3, :3].T + T_base_laser[:3, 3]
    step_rad = math.radians(0.25)
    kept = np.arange(len(ANGLES)) % 5 > 0
    found, angles = beams_of(points[kept], T_base_laser, 719.0 * step_rad, step_rad)
    assert np.allclose(angles, ANGLES)
    assert np.allclose(found[kept], ranges[kept])
    assert np.isinf(found[~kept]).all(), "a beam without a return has none"

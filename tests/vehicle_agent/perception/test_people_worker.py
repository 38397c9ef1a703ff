"""The worker of the NUS cart: planar scans and pictures become people among the tracks of the points."""

import msgspec
import numpy as np
import pytest

from campusloop.scenes.stacks import profile_of
from simulator.sensors.cameras.mounts import profile_camera
from tests.vehicle_agent.perception.laser_people.test_people import Scorer
from tests.vehicle_agent.perception.laser_people.test_segments import scan_of
from tests.vehicle_agent.perception.test_height_map import a_scan
from vehicle_agent.config import Profile
from vehicle_agent.perception.laser_people.people import LaserPeople
from vehicle_agent.perception.people_worker import PeopleFinder, PeopleWorker
from vehicle_agent.signals import OTHER, PEDESTRIAN, ObstaclePercept, TrackPercept
from vehicle_agent.signals.objects import EgoMotion
from vehicle_agent.signals.pictures import Picture, PinholeCamera
from vehicle_agent.stacks import own_perception
from vehicle_agent.stacks.choice import build_perception_worker, perception_lacks

CART = msgspec.structs.replace(profile_of("nus"), perception="own")
ANGLES = np.radians(0.25) * (np.arange(720) - 359.5)
T_BASE_LASER = np.eye(4)
T_BASE_LASER[:3, 3] = CART.people_scanner.x_m, 0.0, 0.85
STEP_NS = 20_000_000
START_NS = 1_000_000_000
FLAT = a_scan([])


class Cart:
    """Stands, or drives ahead, past something that moves; the roof's lidar sees flat ground alone."""

    def __init__(self, scorer: Scorer | None, speed_mps: float = 0.0) -> None:
        mount = profile_camera(CART.camera)
        self.camera = PinholeCamera("front", mount.K, mount.T_base_camera, mount.width_px, mount.height_px)
        scanner = CART.people_scanner
        finder = PeopleFinder(
            LaserPeople(), T_BASE_LASER, scanner.field_rad, scanner.step_rad, self.camera, scorer
        )
        self.worker = PeopleWorker(own_perception.point_perception(CART), finder)
        self.speed_mps, self.number, self.scorer = speed_mps, 0, scorer
        self.pictures = 0

    def run(self, steps: int, x_m: float, y_m: float, vy_mps: float) -> TrackPercept:
        """The last tracks; x_m, y_m: at the first step, in the base frame of that time."""
        tracks = None
        for _ in range(steps):
            self.number += 1
            now_ns, t = START_NS + self.number * STEP_NS, self.number * STEP_NS * 1e-9
            self.worker.take(EgoMotion(now_ns, self.speed_mps, 0.0))
            x, y = x_m - self.speed_mps * t, y_m + vy_mps * t
            if self.number % 2 == 0:
                self.worker.planar(self.rows(x - T_BASE_LASER[0, 3], y), now_ns)
            if self.scorer is not None and self.number % 10 == 0 and self.worker.windows(now_ns) is not None:
                K, T = self.camera.K, np.linalg.inv(self.camera.T_base_camera)
                place = K @ (T @ (x, y, 0.0, 1.0))[:3]
                self.scorer.people_px = [float(place[0] / place[2])]
                rng = np.random.default_rng(self.number)
                pixels = rng.integers(0, 255, (480, 640, 3), dtype=np.uint8)
                self.worker.look(Picture("front", now_ns, pixels))
                self.pictures += 1
            if self.number % 5 == 0:
                tracks = self.worker.percepts(self.flat(), now_ns)[1]
        assert isinstance(tracks, TrackPercept)
        return tracks

    @staticmethod
    def flat() -> np.ndarray:
        return np.column_stack((FLAT, np.zeros((len(FLAT), 2), np.float32)))

    def rows(self, x_m: float, y_m: float) -> np.ndarray:
        rng = np.random.default_rng(self.number)
        ranges = scan_of([(x_m, y_m, 0.2)]) + rng.normal(0.0, 0.01, len(ANGLES))
        seen = np.isfinite(ranges)
        level = np.column_stack((ranges * np.cos(ANGLES), ranges * np.sin(ANGLES), 0.0 * ANGLES))[seen]
        points = (level + T_BASE_LASER[:3, 3]).astype(np.float32)
        return np.column_stack((points, np.zeros((len(points), 2), np.float32)))


def test_a_person_whom_only_laser_and_camera_see_is_a_pedestrian_among_the_tracks() -> None:
    cart = Cart(Scorer([]), speed_mps=1.0)
    tracks = cart.run(80, 15.0, -2.0, 1.0)
    assert tracks.kinds.tolist() == [PEDESTRIAN]
    assert tracks.poses_base[0, :2] == pytest.approx((15.0 - 1.6, -0.4), abs=0.3)
    assert tracks.velocities_base_mps[0] == pytest.approx((0.0, 1.0), abs=0.35)


def test_without_a_camera_what_moves_is_told_of_as_something_that_moves() -> None:
    tracks = Cart(None).run(100, 12.0, -2.0, 1.2)
    assert tracks.kinds.tolist() == [OTHER]
    assert tracks.velocities_base_mps[0] == pytest.approx((0.0, 1.2), abs=0.4)


def test_who_stood_before_the_bumper_and_walks_on_is_followed_though_the_roof_does_not_see_them() -> None:
    cart = Cart(None)
    assert len(cart.run(200, 4.0, -1.0, 0.0).ids) == 0, "it could be a bollard, and its cells say so"
    begin_s = cart.number * STEP_NS * 1e-9
    tracks = cart.run(80, 4.0, -1.0 - 1.2 * begin_s, 1.2)
    assert len(tracks.ids) == 1
    assert tracks.velocities_base_mps[0] == pytest.approx((0.0, 1.2), abs=0.4)
    assert tracks.poses_base[0, :2] == pytest.approx((4.0, -1.0 + 1.2 * 1.6), abs=0.3)


def test_pictures_are_asked_for_where_something_is_and_seldom_where_nothing_is() -> None:
    cart = Cart(Scorer([]))
    cart.run(8, 12.0, 1.0, 0.0)
    windows = cart.worker.windows(START_NS + 8 * STEP_NS)
    assert windows is not None
    assert len(windows) == 1
    left, top, right, bottom = windows[0]
    K, T = cart.camera.K, np.linalg.inv(cart.camera.T_base_camera)
    for height_m in (0.0, 1.7):
        u, v, w = K @ (T @ (12.0, 1.0, height_m, 1.0))[:3]
        assert left < u / w < right
        assert top < v / w < bottom
    empty = Cart(Scorer([]))
    empty.run(250, 60.0, 0.0, 0.0)
    assert 6 <= empty.pictures <= 9, "of 25: the camera's health is watched"


def test_a_laser_that_falls_silent_leaves_the_tracks_of_the_points() -> None:
    cart = Cart(Scorer([]))
    assert len(cart.run(100, 12.0, -2.0, 1.2).ids) == 1
    cart.rows = lambda x_m, y_m: np.empty((0, 5), np.float32)  # type: ignore[method-assign]
    assert len(cart.run(100, 12.0, -2.0, 1.2).ids) == 0


def test_what_stands_before_the_bumper_is_a_cell_though_the_roof_does_not_see_it() -> None:
    cart = Cart(None, speed_mps=1.0)
    cart.run(10, 5.0, 0.3, 0.0)
    cells = cart.worker.percepts(cart.flat(), START_NS + 10 * STEP_NS)[0]
    assert isinstance(cells, ObstaclePercept)
    apart = np.hypot(*(cells.cells_base - (5.0 - 0.2 - 0.2, 0.3)).T)
    assert apart.min() < 0.25
    assert (apart < 0.6).all()
    assert len(cells.heights_m) == len(cells.cells_base)
    far = Cart(None)
    far.run(10, 9.0, 0.3, 0.0)
    (seen, _) = far.worker.percepts(far.flat(), START_NS + 10 * STEP_NS)
    assert isinstance(seen, ObstaclePercept)
    assert len(seen.cells_base) == 0, "on a slope the laser could meet the road there"


def test_a_gem_vehicle_with_a_planar_scanner_sees_people_with_it_and_reads_signs() -> None:
    worker = build_perception_worker(msgspec.structs.replace(profile_of("gem"), perception="own"))
    assert isinstance(worker, PeopleWorker)
    assert not worker.looks_at_pictures
    assert len(worker.signs(Cart.flat(), START_NS)) == 1


def test_what_own_perception_lacks_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> None:
        raise own_perception.CameraLibraryMissing("install it with `make camera`")

    monkeypatch.setattr(own_perception, "opencv", missing)
    monkeypatch.setattr(own_perception, "HogPeopleDetector", missing)
    assert "make camera" in perception_lacks(CART)
    assert isinstance(build_perception_worker(CART), PeopleWorker), "laser and lidar go on alone"
    assert "[people_scanner]" in perception_lacks(Profile(stack="nus", perception="own"))
    assert "[people_scanner]" in perception_lacks(Profile(stack="gem", perception="own"))
    lidars_alone = Profile(stack="snow_lion", perception="own")
    assert perception_lacks(lidars_alone) == ""
    with_scanner = msgspec.structs.replace(lidars_alone, people_scanner=CART.people_scanner)
    assert "is not used" in perception_lacks(with_scanner)
    shuttle = msgspec.structs.replace(profile_of("gem"), perception="own")
    assert perception_lacks(shuttle) == "", "the GEM paper's camera looks at no people"
    assert perception_lacks(Profile(stack="snow_lion", perception="own")) == ""
    assert perception_lacks(profile_of("nus")) == ""

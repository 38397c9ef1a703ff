"""People found by what the drivers of a planar scanner and a camera write into their rings."""

from pathlib import Path

import numpy as np
import pytest
from structlog.testing import capture_logs

from tests.vehicle_agent.perception.laser_people.test_people import Scorer
from tests.vehicle_agent.perception.test_people_worker import START_NS, STEP_NS, T_BASE_LASER, Cart
from vehicle_agent.device_feed import ScanRing, people_ring_path
from vehicle_agent.picture_ring import PEOPLE_CAMERA, PictureRing, picture_ring_path
from vehicle_agent.picture_windows import PictureWindows, picture_windows_path
from vehicle_agent.runtime.processes.sensing.people_feed import SILENT_NS, PeopleFeed
from vehicle_agent.signals import OTHER, PEDESTRIAN, TrackPercept
from vehicle_agent.signals.objects import EgoMotion

SECOND_NS = 1_000_000_000


class Vehicle:
    """A cart that stands, 1.2 m/s of a person across its way, and drivers that write into the rings."""

    def __init__(self, folder: Path, scorer: Scorer | None) -> None:
        self.cart, self.scorer = Cart(scorer), scorer
        ring = folder / "s1.scans"
        self.scans = ScanRing(people_ring_path(ring), create=True)
        self.pictures = PictureRing(picture_ring_path(ring, PEOPLE_CAMERA), create=True)
        self.windows_path = picture_windows_path(ring, PEOPLE_CAMERA)
        self.feed = PeopleFeed("s1", self.cart.worker, ring)
        self.now_ns, self.number, self.shape = START_NS, 0, (480, 640, 3)
        self.scans_silent = self.camera_silent = False

    def run(self, steps: int) -> TrackPercept:
        tracks = None
        for _ in range(steps):
            self.number, self.now_ns = self.number + 1, self.now_ns + STEP_NS
            self.cart.worker.take(EgoMotion(self.now_ns, 0.0, 0.0))
            y_m = -2.0 + 1.2 * self.number * STEP_NS * 1e-9
            if self.number % 2 == 0 and not self.scans_silent:
                self.cart.number = self.number
                rows = self.cart.rows(12.0 - T_BASE_LASER[0, 3], y_m)
                self.scans.write(self.number, self.now_ns, rows[:, :3], rows[:, 3])
            if self.scorer is not None and self.number % 10 == 0 and not self.camera_silent:
                self.take_picture(self.scorer, y_m)
            self.feed.take(self.now_ns)
            if self.number % 5 == 0:
                tracks = self.cart.worker.percepts(self.cart.flat(), self.now_ns)[1]
        assert isinstance(tracks, TrackPercept)
        return tracks

    def take_picture(self, scorer: Scorer, y_m: float) -> None:
        if PictureWindows(self.windows_path, create=False).asked() is None:
            return
        K, T = self.cart.camera.K, np.linalg.inv(self.cart.camera.T_base_camera)
        place = K @ (T @ (12.0, y_m, 0.0, 1.0))[:3]
        scorer.people_px = [float(place[0] / place[2])]
        rng = np.random.default_rng(self.number)
        self.pictures.write(self.now_ns, rng.integers(0, 255, self.shape, dtype=np.uint8))


def test_who_is_in_both_rings_is_a_pedestrian(tmp_path: Path) -> None:
    tracks = Vehicle(tmp_path, Scorer([])).run(100)
    assert tracks.kinds.tolist() == [PEDESTRIAN]
    assert tracks.velocities_base_mps[0] == pytest.approx((0.0, 1.2), abs=0.35)


def test_without_a_library_for_pictures_the_camera_is_asked_for_nothing(tmp_path: Path) -> None:
    vehicle = Vehicle(tmp_path, None)
    assert vehicle.run(100).kinds.tolist() == [OTHER]
    assert not vehicle.windows_path.exists()


def test_pictures_of_another_size_are_refused_and_told_once(tmp_path: Path) -> None:
    vehicle = Vehicle(tmp_path, Scorer([]))
    vehicle.shape = (240, 320, 3)
    with capture_logs() as logs:
        assert PEDESTRIAN not in vehicle.run(100).kinds.tolist()
    (refused,) = [entry for entry in logs if entry["event"] == "worker.picture_refused"]
    assert refused["profile"] == (480, 640)


@pytest.mark.parametrize(
    ("silent", "sensor"), [("scans_silent", "people_scanner"), ("camera_silent", "camera")]
)
def test_a_silent_sensor_is_told_of_once_and_when_it_is_back(
    tmp_path: Path, silent: str, sensor: str
) -> None:
    vehicle = Vehicle(tmp_path, Scorer([]))
    vehicle.run(50)
    setattr(vehicle, silent, True)
    steps = 3 * SILENT_NS // STEP_NS
    with capture_logs() as logs:
        vehicle.run(steps)
        setattr(vehicle, silent, False)
        vehicle.run(50)
    told = [entry["event"] for entry in logs if entry.get("sensor") == sensor]
    assert told == ["worker.sensor_silent", "worker.sensor_back"]


def test_drivers_may_start_later(tmp_path: Path) -> None:
    cart = Cart(Scorer([]))
    feed = PeopleFeed("s1", cart.worker, tmp_path / "s1.scans")
    with capture_logs() as logs:
        for step in range(int(3 * SECOND_NS // STEP_NS)):
            feed.take(START_NS + step * STEP_NS)
    events = [entry["event"] for entry in logs]
    assert events.count("scans.no_ring") == 1
    assert events.count("worker.sensor_silent") == 2, "scanner and camera"

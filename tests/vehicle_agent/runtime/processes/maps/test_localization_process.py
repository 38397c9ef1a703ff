"""The localization worker as the tick meets it: mail in, a ring of scans, mail out."""

from pathlib import Path

import numpy as np
import pytest

from contract.geometry import Pose2
from contract.runlog.matched_scans import MatchedScan
from tests.vehicle_agent.localization.scan_map.places import MOUNT, SQUARE, TILE_M, VOXEL_M, a_map, a_scan
from vehicle_agent.device_feed import SLOTS, ScanRing
from vehicle_agent.localization.scan_map.matcher import SurfaceMatcher
from vehicle_agent.localization.worker import LocalizationWorker, NoMap
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.mailbox import (
    Deliveries,
    LocalizationJobs,
    LocalizationMapAnswer,
    Mailbox,
)
from vehicle_agent.runtime.processes.maps.localization_process import LocalizationProcess
from vehicle_agent.signals import LocalizationJob, ScanPose, ScanUnplaced

TILES = a_map(SQUARE)
TRUE = Pose2(0.0, 1.0, 0.2)
NEAR = Pose2(0.3, 0.8, 0.22)
COVARIANCE = np.diag([0.1**2, 0.1**2, 0.02**2])


class Vehicle:
    """The worker's process between a driver and a tick of the test."""

    def __init__(self, folder: Path) -> None:
        self.has_map = True
        self.ring_path, self.mail = folder / "scans", folder / "mail"
        self.tick = Mailbox(self.mail / "tick")
        self.process = LocalizationProcess(
            self.mail, self.ring_path, self.load, MONOTONIC.open("localization")
        )

    def load(self) -> LocalizationWorker:
        if not self.has_map:
            return LocalizationWorker(NoMap())
        outline_m = (3.5, 0.85, 0.8)
        return LocalizationWorker(
            SurfaceMatcher(lambda ix, iy: TILES.get((ix, iy)), TILE_M, VOXEL_M, outline_m)
        )

    def driver(self) -> ScanRing:
        return ScanRing(self.ring_path, create=True)

    def ask(self, stamp_ns: int, pose: Pose2 = NEAR) -> None:
        job = LocalizationJob(stamp_ns, pose, pose, COVARIANCE, 0.0, 0.0)
        self.tick.post(self.mail / "localization", LocalizationJobs((job,)))
        self.process.step()

    def posted(self) -> list[object]:
        return [item.body for mail in self.tick.take() if isinstance(mail, Deliveries) for item in mail.items]

    def answers(self) -> list[object]:
        return [body for body in self.posted() if not isinstance(body, MatchedScan)]


@pytest.fixture
def vehicle(tmp_path: Path) -> Vehicle:
    return Vehicle(tmp_path)


def write(ring: ScanRing, number: int, stamp_ns: int) -> None:
    points = (a_scan(SQUARE, TRUE, 1).points_sensor + MOUNT[:3, 3]).astype(np.float32)
    ring.write(number, stamp_ns, points, np.zeros(len(points), np.float32))


def test_the_newest_scan_is_answered_once_with_the_vehicles_place(vehicle: Vehicle) -> None:
    vehicle.ask(90)
    assert vehicle.answers() == []  # No driver yet.
    ring = vehicle.driver()
    write(ring, 0, 100)
    write(ring, 1, 110)
    vehicle.ask(105)
    assert vehicle.answers() == []  # The jobs do not reach it yet.
    vehicle.ask(120)
    vehicle.ask(130)
    (found,) = vehicle.answers()
    assert isinstance(found, ScanPose)
    assert found.stamp_ns == 110
    assert np.hypot(found.pose_map.x_m - TRUE.x_m, found.pose_map.y_m - TRUE.y_m) < 0.06
    write(ring, 2, 140)
    vehicle.ask(150)
    assert [answer.stamp_ns for answer in vehicle.answers() if isinstance(answer, ScanPose)] == [140]


def test_a_place_without_a_map_is_told(vehicle: Vehicle) -> None:
    write(vehicle.driver(), 0, 100)
    vehicle.ask(95, Pose2(900.0, 900.0, 0.0))
    vehicle.ask(105, Pose2(900.0, 900.0, 0.0))
    assert vehicle.answers() == [ScanUnplaced(100, "no_map")]


def test_once_a_second_the_tick_gets_a_scan_for_its_run_log(vehicle: Vehicle) -> None:
    ring, kinds = vehicle.driver(), []
    for number in range(1, 13):
        stamp_ns = 100_000_000 * number
        write(ring, number, stamp_ns)
        vehicle.ask(stamp_ns + 1)
        kinds += [type(body) for body in vehicle.posted()]
    # Before the first job nothing tells where the vehicle was.
    assert kinds.count(ScanPose) == 11
    assert kinds.count(MatchedScan) == 2


def test_a_driver_that_starts_again_is_followed(vehicle: Vehicle) -> None:
    for start in range(2):
        ring = vehicle.driver()
        for number in range(SLOTS + 1):
            write(ring, number, 1000 * start + 10 * number + 10)
        vehicle.ask(1000 * start + 15)
        vehicle.ask(1000 * start + 100)
        assert [type(answer) for answer in vehicle.answers()] == [ScanPose]


def test_a_vehicle_without_a_map_gets_one_while_it_runs(tmp_path: Path) -> None:
    waiting = Vehicle(tmp_path)
    waiting.has_map = False
    waiting.process = LocalizationProcess(
        waiting.mail, waiting.ring_path, waiting.load, MONOTONIC.open("localization")
    )
    ring = waiting.driver()
    write(ring, 1, 100)
    waiting.ask(90)
    waiting.ask(110)
    assert waiting.answers() == [ScanUnplaced(100, "no_map")]
    waiting.has_map = True
    waiting.tick.post(waiting.mail / "localization", LocalizationMapAnswer("refused", "not_stored"))
    waiting.tick.post(waiting.mail / "localization", LocalizationMapAnswer("map-1"))
    write(ring, 2, 200)
    waiting.ask(190)
    waiting.ask(210)
    (answer,) = waiting.answers()
    assert isinstance(answer, ScanPose)

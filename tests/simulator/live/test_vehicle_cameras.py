"""The pictures of a live world's vehicles: in turn, when they are due, with what stands before them."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from campusloop.live.simulated_cameras import NAMES, cameras_file
from campusloop.scenes.stacks import profile_of
from simulator.live.live import scan_ring_path
from simulator.live.moment_file import Moment, MomentFile, moment_path
from simulator.live.vehicle_cameras import VehicleCameras
from simulator.sensors.scene_lidars import open_square
from simulator.traffic.actors import Bodies
from simulator.world import FLEET_NUMBERS_FROM
from tests.simulator.street import street
from vehicle_agent.device_feed import DeviceFeedError
from vehicle_agent.picture_ring import PictureRing, picture_ring_path
from vehicle_agent.runtime.video.cameras_file import load_cameras
from vehicle_agent.signals import PEDESTRIAN, VEHICLE

VEHICLES = ("s1", "s2")
SECOND_NS = 1_000_000_000


class Campus:
    """The simulator's file of moments, and the cameras beside it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.moments = MomentFile(moment_path(folder), create=True)
        self.cameras = VehicleCameras(
            street(), profile_of("snow_lion"), VEHICLES, open_square(1), folder, (160, 120), 2.0
        )

    def moment(self, stamp_ns: int, people: tuple[tuple[float, float], ...] = ()) -> None:
        poses = np.array([(20.0, 0.0, 0.0), (60.0, 0.0, 0.0)])
        count = len(people)
        places = np.array([*people, (21.3, 0.0), (61.3, 0.0)]).reshape(-1, 2)
        bodies = Bodies(
            np.array([*range(count), FLEET_NUMBERS_FROM, FLEET_NUMBERS_FROM + 1]),
            np.array([PEDESTRIAN] * count + [VEHICLE] * 2),
            np.column_stack((places, np.zeros(len(places)))),
            np.zeros((count + 2, 2)),
            np.array([(0.5, 0.5)] * count + [(4.35, 1.63)] * 2),
        )
        self.moments.write(Moment(stamp_ns, poses, bodies))

    def steps(self) -> int:
        count = 0
        while self.cameras.step():
            count += 1
        return count

    def newest(self, vehicle: str, camera: str) -> tuple[int, NDArray[np.uint8]]:
        ring = PictureRing(picture_ring_path(scan_ring_path(self.folder, vehicle), camera), create=False)
        found = None
        ring._next = 0
        while (picture := ring.read()) is not None:
            found = picture
        assert found is not None
        return found.stamp_ns, found.pixels


def test_each_camera_of_each_vehicle_takes_a_picture_when_it_is_due(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    assert campus.steps() == 0, "the simulator has shown no moment yet"
    campus.moment(SECOND_NS)
    assert campus.steps() == 8
    campus.moment(SECOND_NS + 200_000_000)
    assert campus.steps() == 0, "two a second"
    campus.moment(SECOND_NS + 500_000_000)
    assert campus.steps() == 8
    for vehicle in VEHICLES:
        for camera in NAMES:
            stamp_ns, pixels = campus.newest(vehicle, camera)
            assert stamp_ns == SECOND_NS + 500_000_000
            assert pixels.shape == (120, 160, 3)
            assert pixels.std() > 5.0


def test_who_stands_before_a_camera_is_in_its_picture_and_in_no_other(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    campus.moment(SECOND_NS)
    campus.steps()
    before = {camera: campus.newest("s1", camera)[1] for camera in NAMES}
    campus.moment(2 * SECOND_NS, people=((29.0, 0.0),))
    campus.steps()
    for camera in NAMES:
        after = campus.newest("s1", camera)[1]
        changed = np.abs(after.astype(int) - before[camera]).mean(axis=2)
        # Sensor noise changes pixels a little.
        assert (changed[:, 70:90].max() > 60.0) == (camera == "front"), camera


def test_a_simulator_that_is_started_again_is_followed(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    campus.moment(100 * SECOND_NS)
    campus.steps()
    campus.moment(SECOND_NS)
    assert campus.steps() == 8


def test_the_cameras_wait_for_the_simulator(tmp_path: Path) -> None:
    with pytest.raises(DeviceFeedError):
        VehicleCameras(street(), profile_of("snow_lion"), VEHICLES, open_square(1), tmp_path, (160, 120), 2.0)


def test_agents_record_these_cameras_from_their_rings(tmp_path: Path) -> None:
    path, ring = tmp_path / "cameras.toml", scan_ring_path(tmp_path, "s1")
    path.write_text(cameras_file())
    settings = load_cameras(path, ring)
    assert settings is not None
    assert [camera.name for camera in settings.cameras] == list(NAMES)
    assert [
        str(picture_ring_path(ring, name)) in camera.address
        for name, camera in zip(NAMES, settings.cameras, strict=True)
    ] == [True] * 4

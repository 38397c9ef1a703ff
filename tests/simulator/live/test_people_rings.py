"""What a cart's scanner and camera for people see, as the perception worker of a live agent finds it."""

from pathlib import Path

import numpy as np

from campusloop.scenes.stacks import perceiving, profile_of
from contract.geometry import Pose2
from simulator.live.control_server import RemotePhones
from simulator.live.live import LiveSimulation, scan_ring_path
from simulator.sensors.scene_lidars import open_square
from simulator.world import SimWorld, WorldOptions
from tests.simulator.street import street
from vehicle_agent.device_feed import ScanRing, people_ring_path
from vehicle_agent.picture_ring import PEOPLE_CAMERA, PictureRing, picture_ring_path
from vehicle_agent.picture_windows import PictureWindows, picture_windows_path

BASE_PORT = 48_910
STEP_NS = 20_000_000


class HandClock:
    now = 1_000_000_000

    def now_ns(self) -> int:
        return self.now

    def wait(self, due_ns: int) -> None:
        self.now = due_ns


def test_scans_and_wanted_pictures_lie_in_rings_beside_that_of_the_lidar(tmp_path: Path) -> None:
    cart = perceiving(profile_of("nus"), own=True)
    options = WorldOptions(traffic=None, scene=open_square(1))
    phones = RemotePhones()
    world = SimWorld(street(), {"s1": cart}, {"s1": Pose2(20.0, 0.0, 0.0)}, 1, phones, options)
    simulation = LiveSimulation(world, phones, tmp_path, BASE_PORT, HandClock())
    ring = scan_ring_path(tmp_path, "s1")
    pictures_path = picture_ring_path(ring, PEOPLE_CAMERA)

    def run(steps: int) -> None:
        for _ in range(steps):
            simulation._wait()
            simulation.run_step()

    run(30)
    scans = ScanRing(people_ring_path(ring), create=False)
    first = scans.newest()
    assert first is not None
    assert len(scans.read(first) or ()) == 2
    assert not pictures_path.exists(), "no worker has asked for a picture"
    asked = PictureWindows(picture_windows_path(ring, PEOPLE_CAMERA), create=True)
    run(15)
    assert not pictures_path.exists()
    asked.ask(np.array([[300, 200, 364, 328]]))
    run(30)
    second = scans.newest()
    assert second is not None
    assert second.number - first.number == 22, "45 steps of 20 ms, 25 scans a second"
    pictures = PictureRing(pictures_path, create=False)
    run(15)
    newest = pictures.read()
    assert newest is not None
    assert newest.pixels.shape == (cart.camera.height_px, cart.camera.width_px, 3)
    assert newest.pixels.std() > 0.0
    simulation.close()

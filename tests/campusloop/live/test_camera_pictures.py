"""The process that takes pictures for simulated shuttles."""

import multiprocessing
import time
from pathlib import Path

import numpy as np

from campusloop.live.jobs import take_pictures
from campusloop.live.shuttles import ShuttleOptions, SimulatedShuttles
from campusloop.live.simulated_cameras import NAMES, cameras_file
from campusloop.shipped import DEFAULT_MAP, PROFILES
from simulator.live.live import scan_ring_path
from simulator.live.moment_file import Moment, MomentFile, moment_path
from simulator.sensors.scene_lidars import open_square
from simulator.traffic.actors import no_bodies
from vehicle_agent.device_feed import DeviceFeedError
from vehicle_agent.picture_ring import PictureRing, picture_ring_path
from vehicle_agent.runtime.processes.agent_files import AgentFolder

WITHIN_S = 60.0


def has_picture(path: Path) -> bool:
    try:
        ring = PictureRing(path, create=False)
    except DeviceFeedError:
        return False
    ring._next = 0
    return ring.read() is not None


def test_it_waits_for_the_simulator_takes_pictures_and_ends_when_asked(tmp_path: Path) -> None:
    scene, profile = open_square(1), PROFILES / "snow-lion.toml"
    process = multiprocessing.get_context("spawn").Process(
        target=take_pictures, args=(DEFAULT_MAP, ("shuttle-1",), profile, tmp_path, scene)
    )
    process.start()
    try:
        time.sleep(1.0)
        MomentFile(moment_path(tmp_path), create=True).write(Moment(10, np.zeros((1, 3)), no_bodies()))
        rings = [picture_ring_path(scan_ring_path(tmp_path, "shuttle-1"), name) for name in NAMES]
        until_s = time.monotonic() + WITHIN_S
        while not all(has_picture(ring) for ring in rings) and time.monotonic() < until_s:
            assert process.is_alive()
            time.sleep(0.1)
        assert all(has_picture(ring) for ring in rings)
        process.terminate()
        process.join(10.0)
        assert process.exitcode == 0
    finally:
        process.kill()


def shuttles(folder: Path, *, cameras: bool) -> SimulatedShuttles:
    return SimulatedShuttles(
        ShuttleOptions(
            DEFAULT_MAP, folder, ("shuttle-1",), "http://127.0.0.1:1", scene=open_square(1), cameras=cameras
        )
    )


def test_a_shuttle_has_cameras_while_they_are_asked_for_and_keeps_its_own(tmp_path: Path) -> None:
    path = AgentFolder(tmp_path / "vehicles" / "shuttle-1").root / "cameras.toml"
    shuttles(tmp_path, cameras=True)._place(0, "shuttle-1")
    assert path.read_text() == cameras_file()
    shuttles(tmp_path, cameras=False)._place(0, "shuttle-1")
    assert not path.exists()
    path.write_text('[cameras.mine]\nsource = "/dev/video0"\n')
    shuttles(tmp_path, cameras=False)._place(0, "shuttle-1")
    assert "mine" in path.read_text()
    shuttles(tmp_path, cameras=True)._place(0, "shuttle-1")
    assert "mine" in path.read_text()

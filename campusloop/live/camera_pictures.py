"""Pictures of the simulated shuttles' cameras, as a process beside the simulator."""

import os
import signal
import threading
from pathlib import Path

import structlog

from campusloop.live.simulated_cameras import HEIGHT_PX, RATE_HZ, WIDTH_PX
from campusloop.telemetry.journal_console import journal_console
from contract.roads.load import load_map
from simulator.live.vehicle_cameras import VehicleCameras
from simulator.sensors.scene_lidars import SceneOptions
from vehicle_agent.config import Profile, load_profile
from vehicle_agent.device_feed import DeviceFeedError

# Whatever drives comes first to a core.
_NICE = 10
_LOOK_AGAIN_S = 0.02
_WAIT_S = 0.2

log = structlog.get_logger()


def take_pictures_of_vehicles(
    map_path: Path,
    vehicle_ids: tuple[str, ...],
    profile_path: Path | None,
    folder: Path,
    scene: SceneOptions,
) -> None:
    """Take pictures until SIGTERM or SIGINT.

    folder: of the simulator's rings and moments; until it has made them, this waits
    """
    journal_console()
    stopped = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda _number, _frame: stopped.set())
    os.nice(_NICE)
    road_map = load_map(map_path)
    profile = load_profile(profile_path) if profile_path else Profile()
    cameras = None
    while cameras is None and not stopped.is_set():
        try:
            cameras = VehicleCameras(
                road_map, profile, vehicle_ids, scene, folder, (WIDTH_PX, HEIGHT_PX), RATE_HZ
            )
        except DeviceFeedError:
            # The simulator is still starting.
            stopped.wait(_WAIT_S)
    if cameras is None:
        return
    log.info("cameras.started", vehicles=len(vehicle_ids))
    while not stopped.is_set():
        if not cameras.step():
            stopped.wait(_LOOK_AGAIN_S)
    cameras.close()

"""The simulator as a live process: bodies, by-wire and sensors of all vehicles, and people, in real time."""

import gc
import signal
from pathlib import Path
from types import FrameType
from typing import NoReturn

import numpy as np
import structlog
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from campusloop.live.paced_clock import PacedClocks
from campusloop.telemetry.journal_console import journal_console
from contract.roads.load import MapError, load_map
from simulator.infrastructure import CameraParams, cameras_at_crossings
from simulator.live.bus import LiveBusError
from simulator.live.control_server import ControlError, RemotePhones
from simulator.live.live import LiveSimulation, scan_ring_path
from simulator.live.ports import BASE_PORT, control_port, ports_of
from simulator.sensors.scene_lidars import SceneOptions
from simulator.start_places import start_poses
from simulator.traffic.population import TrafficParams
from simulator.warm import warm_kernels
from simulator.world import SimWorld, WorldError, WorldOptions
from vehicle_agent.config import Profile, ProfileError, load_profile
from vehicle_agent.device_feed import DeviceFeedError

_BAD_INPUT = 2

log = structlog.get_logger()


def simulate_vehicles(
    map_path: Path,
    vehicle_ids: tuple[str, ...],
    profile_path: Path | None = None,
    seed: int = 1,
    base_port: int = BASE_PORT,
    folder: Path = Path("var/simulation"),
    people: bool = True,
    lidar: bool = True,
    clocks: PacedClocks | None = None,
    plant_seed: int | None = None,
    scene: SceneOptions | None = None,
) -> None:
    """Simulate until SIGTERM or Ctrl-C. Input that cannot be simulated ends the process with the reason.

    clocks: the simulation opens their master; None: the computer's clock
    plant_seed: of the vehicles' dynamics; None: nominal ones
    scene: hills, kerbs, trees and parked vehicles, and lidars that see them; None: walls on a plane
    """
    console = journal_console()
    if len(set(vehicle_ids)) != len(vehicle_ids):
        _refuse("every vehicle needs an id of its own: --vehicles shuttle-1,shuttle-2")
    phones = RemotePhones()
    try:
        road_map = load_map(map_path)
        profile = load_profile(profile_path) if profile_path else Profile()
        world = SimWorld(
            road_map,
            dict.fromkeys(vehicle_ids, profile),
            start_poses(road_map, vehicle_ids),
            seed,
            phones,
            WorldOptions(
                traffic=TrafficParams() if people else None,
                lidar=lidar,
                plant_seed=plant_seed,
                scene=scene,
            ),
        )
        warm_kernels()
        cameras = cameras_at_crossings(
            road_map, CameraParams(), lambda name: np.random.default_rng([seed, *name.encode()])
        )
        if clocks is None:
            simulation = LiveSimulation(world, phones, folder, base_port, cameras=cameras)
        else:
            # The gaps between frames cannot be measured with a clock that stands still at times.
            clock = clocks.open_master()
            simulation = LiveSimulation(
                world, phones, folder, base_port, clock, frame_gap_ns=0, cameras=cameras
            )
    except (MapError, ProfileError, WorldError, LiveBusError, DeviceFeedError, ControlError) as error:
        _refuse(str(error))
    _print_wiring(console, vehicle_ids, base_port, folder)
    _run_until_signal(simulation)
    console.print(
        f"{simulation.steps} steps, {simulation.late_steps} late, {simulation.lost_ns * 1e-9:.2f} s lost"
    )


def _run_until_signal(simulation: LiveSimulation) -> None:
    """Run until SIGINT or SIGTERM, which end the run after the present step."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        simulation.stop()

    signal.signal(signal.SIGINT, stop)
    signal.signal(signal.SIGTERM, stop)
    gc.collect()
    gc.freeze()
    simulation.run()


def _print_wiring(console: Console, vehicle_ids: tuple[str, ...], base_port: int, folder: Path) -> None:
    if not console.is_terminal:
        _log_wiring(vehicle_ids, base_port, folder)
        return
    table = Table()
    for heading in ("vehicle", "CAN channel", "device values", "scans", "HMI", "scan ring"):
        table.add_column(heading, overflow="fold")
    for number, vehicle_id in enumerate(vehicle_ids):
        ports = ports_of(number, base_port)
        table.add_row(
            vehicle_id,
            ports.can_channel,
            str(ports.values_port),
            str(ports.scans_port),
            str(ports.hmi_port),
            str(scan_ring_path(folder, vehicle_id)),
        )
    console.print(table)
    console.print(f"control on 127.0.0.1:{control_port(base_port)}; Ctrl-C ends the simulation")


def _log_wiring(vehicle_ids: tuple[str, ...], base_port: int, folder: Path) -> None:
    for number, vehicle_id in enumerate(vehicle_ids):
        ports = ports_of(number, base_port)
        log.info(
            "simulator.vehicle",
            vehicle_id=vehicle_id,
            can_channel=ports.can_channel,
            values_port=ports.values_port,
            scans_port=ports.scans_port,
            hmi_port=ports.hmi_port,
            scan_ring=str(scan_ring_path(folder, vehicle_id)),
        )
    log.info("simulator.started", control_port=control_port(base_port))


def _refuse(reason: str) -> NoReturn:
    journal_console(level="error").print(f"[red]cannot simulate:[/red] {escape(reason)}", highlight=False)
    raise SystemExit(_BAD_INPUT)

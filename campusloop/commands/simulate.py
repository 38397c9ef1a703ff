"""`campusloop simulate`: plant, by-wire, sensors and people of all vehicles, in real time; with --km whole
campuses in virtual time, and Table 2 of the Snow Lion paper of what was driven."""

import gc
import os
import signal
from pathlib import Path
from types import FrameType
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.table import Table

from contract.roads.load import MapError, load_map
from simulator.control_desk import CarriedPhones, ControlError
from simulator.live import LiveSimulation, scan_ring_path
from simulator.live_bus import LiveBusError
from simulator.live_ports import BASE_PORT, control_port, ports_of
from simulator.start_places import start_poses
from simulator.traffic.population import TrafficParams
from simulator.warm import warm_kernels
from simulator.world import SimWorld, WorldError, WorldOptions
from vehicle_agent.config import Profile, ProfileError, load_profile
from vehicle_agent.device_feed import DeviceFeedError

_TOUCHED, _BAD_INPUT = 1, 2
_MAPS = Path(__file__).resolve().parents[2] / "maps"
SHIPPED_MAPS = (_MAPS / "shanghai-university" / "map.json", _MAPS / "snow-lion" / "map.json")


def simulate(
    map_path: Annotated[
        Path | None,
        typer.Option("--map", help="the campus map (map.json); with --km also: both shipped ones"),
    ] = None,
    vehicles: Annotated[str, typer.Option(help="vehicle ids, with commas between")] = "shuttle-1",
    profile_path: Annotated[
        Path | None, typer.Option("--profile", help="vehicle profile (TOML); default: the campus shuttle")
    ] = None,
    seed: Annotated[int, typer.Option(help="of noise and people")] = 1,
    base_port: Annotated[int, typer.Option(help="first of the loopback ports used")] = BASE_PORT,
    folder: Annotated[Path, typer.Option(help="where lidar scans are handed over")] = Path("var/simulation"),
    people: Annotated[bool, typer.Option(help="pedestrians around the shuttles")] = True,
    lidar: Annotated[bool, typer.Option(help="simulate the lidars")] = True,
    km: Annotated[float, typer.Option(min=0.0, help="drive so far in virtual time instead")] = 0.0,
    stack: Annotated[str, typer.Option(help="with --km: snow_lion, gem or nus")] = "snow_lion",
    out: Annotated[Path | None, typer.Option(help="with --km: folder for figures, plots and samples")] = None,
    workers: Annotated[int, typer.Option(min=0, help="with --km: processes; 0: one a core")] = 0,
    stint_s: Annotated[float, typer.Option(min=60.0, help="with --km: virtual time of one stint")] = 3600.0,
) -> None:
    """Simulate vehicles in real time until Ctrl-C; each speaks CAN on a bus of its own."""
    console = Console()
    if km > 0.0:
        maps = SHIPPED_MAPS if map_path is None else (map_path,)
        _drive_km(console, maps, stack, km, seed, workers or len(os.sched_getaffinity(0)), stint_s, out)
        return
    if map_path is None:
        _refuse(console, "give a campus map: --map maps/shanghai-university/map.json")
    vehicle_ids = tuple(name.strip() for name in vehicles.split(",") if name.strip())
    if len(set(vehicle_ids)) != len(vehicle_ids):
        _refuse(console, "every vehicle needs an id of its own: --vehicles shuttle-1,shuttle-2")
    phones = CarriedPhones()
    try:
        road_map = load_map(map_path)
        profile = load_profile(profile_path) if profile_path else Profile()
        world = SimWorld(
            road_map,
            dict.fromkeys(vehicle_ids, profile),
            start_poses(road_map, vehicle_ids),
            seed,
            phones,
            WorldOptions(traffic=TrafficParams() if people else None, lidar=lidar),
        )
        warm_kernels()
        simulation = LiveSimulation(world, phones, folder, base_port)
    except (MapError, ProfileError, WorldError, LiveBusError, DeviceFeedError, ControlError) as error:
        _refuse(console, str(error))
    _print_wiring(console, vehicle_ids, base_port, folder)
    _run_until_told(simulation)
    console.print(
        f"{simulation.steps} steps, {simulation.late_steps} late, {simulation.lost_ns * 1e-9:.2f} s lost"
    )


def _drive_km(
    console: Console,
    maps: tuple[Path, ...],
    stack: str,
    km: float,
    seed: int,
    workers: int,
    stint_s: float,
    out: Path | None,
) -> None:
    """Exit 1 when anybody was touched."""
    # A whole campus comes with it, server included; the simulation in real time has no use for one.
    from campusloop.table2 import NothingDriven, tell_km

    try:
        contacts = tell_km(console, maps, stack, km, seed, workers, stint_s, out)
    except (MapError, ProfileError, NothingDriven) as error:
        _refuse(console, str(error))
    if contacts:
        raise typer.Exit(_TOUCHED)


def _run_until_told(simulation: LiveSimulation) -> None:
    """SIGINT and SIGTERM end the run after the present step."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        simulation.stop()

    signal.signal(signal.SIGINT, stop)
    signal.signal(signal.SIGTERM, stop)
    gc.collect()
    gc.freeze()
    simulation.run()


def _print_wiring(console: Console, vehicle_ids: tuple[str, ...], base_port: int, folder: Path) -> None:
    table = Table()
    for heading in ("vehicle", "CAN channel", "device values", "scans", "words", "scan ring"):
        table.add_column(heading, overflow="fold")
    for number, vehicle_id in enumerate(vehicle_ids):
        ports = ports_of(number, base_port)
        table.add_row(
            vehicle_id,
            ports.can_channel,
            str(ports.values_port),
            str(ports.scans_port),
            str(ports.words_port),
            str(scan_ring_path(folder, vehicle_id)),
        )
    console.print(table)
    console.print(f"control on 127.0.0.1:{control_port(base_port)}; Ctrl-C ends the simulation")


def _refuse(console: Console, reason: str) -> NoReturn:
    console.print(f"[red]cannot simulate:[/red] {reason}", highlight=False)
    raise typer.Exit(_BAD_INPUT)

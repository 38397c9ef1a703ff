"""`campusloop workshop`: occupancy tiles of a site, from a laser log with fixes or a simulated survey."""

from pathlib import Path
from typing import Annotated, NoReturn

import msgspec
import typer
from rich.console import Console
from rich.markup import escape

from campusloop.commands.workshop.bars import StageBars, stage_bars
from campusloop.commands.workshop.residual_table import print_residuals
from campusloop.kernels.compiling import ensure_kernels
from campusloop.kernels.groups import SIMULATOR, WORKSHOP
from campusloop.shipped import DEFAULT_MAP, PROFILES
from contract.occupancy.tile_files import INDEX, write_tiles
from contract.roads.load import MapError, load_map
from simulator.sensors.scene.changes import SceneError
from vehicle_agent.config import ProfileError, load_profile
from workshop.carmen.laser_logs import LaserLog
from workshop.cloud_mapping.gnss_fixes import Fixes

console = Console(soft_wrap=True)

EXIT_BAD_INPUT = 2
EXIT_NOT_WRITTEN = 3
# Another day than those of the drives, whose seeds are small.
SURVEY_DAY = 90_000


def survey_laser(
    out: Annotated[Path, typer.Option(help="Folder for the occupancy tiles.")],
    campus_map: Annotated[Path, typer.Option("--map", help="Campus map.")] = DEFAULT_MAP,
    profile: Annotated[Path, typer.Option(help="Vehicle profile (TOML) with a planar scanner.")] = PROFILES
    / "nus-cart.toml",
    scene_seed: Annotated[int, typer.Option(help="Of facades, trees and hills; --scene has 1.")] = 1,
    seed: Annotated[int, typer.Option(help="Of noise and of what is parked that day.")] = SURVEY_DAY,
    km: Annotated[float, typer.Option(min=0.1, help="End the drive after this way.")] = 1000.0,
) -> None:
    """Drive a simulated planar scanner over the campus, and make the NUS stack's occupancy map."""
    from campusloop.scenes.laser_survey import LaserSurvey, NoTour, campus_tour

    check_empty(out)
    make_parent(out)
    ensure_kernels((*SIMULATOR, *WORKSHOP))
    try:
        vehicle, road_map = load_profile(profile), load_map(campus_map)
        if vehicle.planar_scanner.rate_hz <= 0.0:
            raise ProfileError(f"{profile} has no [planar_scanner]")
        # Lines have a point a metre.
        tour = campus_tour(road_map)[: max(2, round(1e3 * km))]
        drive = LaserSurvey(road_map, vehicle, tour, scene_seed, seed)
    except (MapError, ProfileError, NoTour, SceneError) as error:
        _refuse(str(error))
    console.print(f"{drive.length_m / 1e3:.1f} km, {drive.duration_s / 60.0:.0f} minutes", highlight=False)
    with stage_bars(console) as bars:
        progress = StageBars(bars)
        progress.begin("drive", round(drive.duration_s))
        log, fixes = drive.record(progress.advance)
    map_laser_site(log, fixes, out)


def map_laser_site(log: LaserLog, fixes: Fixes, out: Path) -> None:
    """Writes the occupancy tiles of a drive into a new folder, and prints how well they agree."""
    from workshop.laser_mapping.occupancy import MapTooLarge
    from workshop.laser_mapping.placement import NotPlaced
    from workshop.laser_mapping.site_mapping import SiteMappingParams, map_site

    params = SiteMappingParams()
    with stage_bars(console) as bars:
        try:
            site = map_site(log, fixes, params, StageBars(bars))
        except (MapTooLarge, NotPlaced) as error:
            _refuse(f"{error} No map is made of it.")
    print_residuals(console, msgspec.structs.asdict(site.residuals))
    try:
        index = write_tiles(out, site.tiles, params.tile_m, params.occupancy.cell_m, fixes.origin)
    except OSError as error:
        console.print(
            f"[red]{escape(f'{out} cannot be written: {error.strerror or error}')}[/red]", highlight=False
        )
        raise typer.Exit(EXIT_NOT_WRITTEN) from error
    console.print(f"written: {out / INDEX}, map {index.map_version[:12]}", highlight=False)


def check_empty(out: Path) -> None:
    """Refuses a folder that holds something."""
    if out.exists() and any(out.iterdir() if out.is_dir() else (out,)):
        _refuse(f"{out} is not empty; give another --out")


def make_parent(out: Path) -> None:
    """Before a long drive, not after it: ends the command if nothing can be written there."""
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        console.print(
            f"[red]{escape(f'{out} cannot be written: {error.strerror or error}')}[/red]", highlight=False
        )
        raise typer.Exit(EXIT_NOT_WRITTEN) from error


def _refuse(detail: str) -> NoReturn:
    console.print(f"[red]{escape(detail)}[/red]", highlight=False)
    raise typer.Exit(EXIT_BAD_INPUT)

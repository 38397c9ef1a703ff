"""`campusloop workshop survey`: a simulated survey drive, and the map that mapping makes of it."""

from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape

from campusloop.commands.localizing import POINT_MAPS
from campusloop.commands.workshop.bars import StageBars, stage_bars
from campusloop.commands.workshop.residual_table import print_residuals
from campusloop.commands.workshop.site_maps import make_parent
from campusloop.kernels.compiling import ensure_kernels
from campusloop.kernels.groups import CLOUD_MAPPING, SIMULATOR
from campusloop.shipped import DEFAULT_MAP
from contract.point_map.map_files import INDEX
from contract.roads.load import MapError, load_map
from simulator.sensors.scene.changes import SceneError

console = Console(soft_wrap=True)

EXIT_BAD_INPUT = 2
EXIT_NOT_WRITTEN = 3
# Another day than those of the drives, whose seeds are small.
SURVEY_DAY = 9_001


def survey(
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the map, the report and a picture; var/point-maps/CAMPUS without it."),
    ] = None,
    stops: Annotated[
        str, typer.Option(help="Stop ids in the drive's order, with commas; all without it.")
    ] = "",
    campus_map: Annotated[Path, typer.Option("--map", help="Campus map.")] = DEFAULT_MAP,
    scene_seed: Annotated[int, typer.Option(help="Of facades, trees and hills; --scene has 1.")] = 1,
    seed: Annotated[int, typer.Option(help="Of noise and of what is parked that day.")] = SURVEY_DAY,
) -> None:
    """Drive a simulated vehicle from stop to stop through the scene, and map what its lidar sees."""
    from campusloop.scenes.survey_drive import NoWay, SurveyDrive
    from workshop.cloud_mapping.map_folder import MapFolderError, write_map_folder
    from workshop.cloud_mapping.mapping import CloudMappingParams, map_scans

    try:
        road_map = load_map(campus_map)
        out = out or POINT_MAPS / road_map.campus_id
        if out.exists() and any(out.iterdir() if out.is_dir() else (out,)):
            _refuse(f"{out} is not empty; remove it, or give another --out")
        make_parent(out)
        ensure_kernels((*SIMULATOR, *CLOUD_MAPPING))
        ids = [stop_id.strip() for stop_id in stops.split(",") if stop_id.strip()]
        drive = SurveyDrive(road_map, ids or [stop.stop_id for stop in road_map.stops], scene_seed, seed)
    except (MapError, NoWay, SceneError) as error:
        _refuse(str(error))
    console.print(f"{drive.length_m / 1e3:.1f} km, {drive.scans} scans", highlight=False)
    params = CloudMappingParams(lever_sensor_m=drive.lever_sensor_m)
    with stage_bars(console) as bars:
        cloud_map = map_scans(drive.clouds(), drive.scans, drive.fixes(), params, StageBars(bars))
    names = [f"simulated survey of {road_map.name}, scene {scene_seed}, day {seed}"]
    try:
        report = write_map_folder(out, cloud_map, params, names, cloud_map.notes, None)
    except (MapFolderError, OSError) as error:
        console.print(f"[red]{escape(f'{out} cannot be written: {error}')}[/red]", highlight=False)
        raise typer.Exit(EXIT_NOT_WRITTEN) from error
    print_residuals(console, report)
    console.print(f"written: {out / INDEX}", highlight=False)


def _refuse(detail: str) -> NoReturn:
    console.print(f"[red]{escape(detail)}[/red]", highlight=False)
    raise typer.Exit(EXIT_BAD_INPUT)

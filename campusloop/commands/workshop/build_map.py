"""`campusloop workshop map`: a map of cells from a laser log, or of surfaces from lidar scans."""

from pathlib import Path
from typing import Annotated, NoReturn

import msgspec
import typer
from rich.console import Console
from rich.markup import escape

from campusloop.commands.workshop.bars import StageBars, stage_bars
from campusloop.commands.workshop.residual_table import print_residuals
from campusloop.commands.workshop.site_maps import check_empty, map_laser_site

console = Console(soft_wrap=True)

EXIT_BAD_INPUT = 2
EXIT_NOT_WRITTEN = 3


def build_map(
    out: Annotated[Path, typer.Option(help="Folder for map, drive, report and picture.")],
    laser: Annotated[
        Path | None, typer.Option(help="CARMEN log of a planar laser, plain, .gz or .bz2.")
    ] = None,
    clouds: Annotated[
        list[Path] | None,
        typer.Option(
            help="Lidar scans of one drive: folder of PCD, PLY or KITTI files, or ROS bag; repeatable."
        ),
    ] = None,
    gnss: Annotated[
        Path | None, typer.Option(help="CSV of fixes in the scans' clock (docs/workshop/mapping.md).")
    ] = None,
    road_map: Annotated[
        Path | None, typer.Option(help="Road map whose origin the fixes are laid on; else the first fix.")
    ] = None,
    lever: Annotated[
        tuple[float, float, float],
        typer.Option(help="Where the fixes' place is in the lidar's frame: x y z, m."),
    ] = (0.0, 0.0, 0.0),
    truth: Annotated[
        Path | None, typer.Option(help="Reference trajectory (TUM or KITTI): the report then has the error.")
    ] = None,
) -> None:
    """Build a map, of cells from a laser log or of surfaces from lidar scans, and say how well it agrees."""
    if (laser is None) == (not clouds):
        _refuse("give either --laser or --clouds")
    if laser is not None and gnss is not None:
        map_placed_log(laser, gnss, road_map, out)
        return
    if laser is not None:
        map_laser_log(laser, out)
        return
    from campusloop.commands.workshop.cloud_maps import NotWritten, RefusedInput, map_clouds

    try:
        map_clouds(clouds or [], out, gnss, truth, road_map, lever)
    except RefusedInput as error:
        _refuse(str(error))
    except NotWritten as error:
        console.print(f"[red]{escape(str(error))}[/red]", highlight=False)
        raise typer.Exit(EXIT_NOT_WRITTEN) from error


def map_placed_log(laser: Path, gnss: Path, road_map: Path | None, out: Path) -> None:
    """Occupancy tiles in the road map's frame; the fixes are of the vehicle's base."""
    from campusloop.kernels.compiling import ensure_kernels
    from campusloop.kernels.groups import WORKSHOP
    from contract.roads.load import MapError, load_map
    from workshop.carmen.laser_logs import read_laser_log
    from workshop.carmen.log_files import LogFileError
    from workshop.cloud_mapping.gnss_fixes import FixFileError, read_fixes

    check_empty(out)
    try:
        log = read_laser_log(laser)
        fixes = read_fixes(gnss, None if road_map is None else load_map(road_map).origin)
    except (LogFileError, FixFileError, MapError) as error:
        _refuse(str(error))
    for note in log.notes:
        console.print(f"[yellow]{note}[/yellow]", highlight=False)
    ensure_kernels(WORKSHOP)
    map_laser_site(log, fixes, out)


def map_laser_log(laser: Path, out: Path) -> None:
    from campusloop.kernels.compiling import ensure_kernels
    from campusloop.kernels.groups import WORKSHOP
    from workshop.carmen.laser_logs import read_laser_log
    from workshop.carmen.log_files import LogFileError
    from workshop.laser_mapping.map_folder import MAP, write_map_folder
    from workshop.laser_mapping.mapping import MappingParams, map_log
    from workshop.laser_mapping.occupancy import MapTooLarge

    if (out / MAP).exists():
        _refuse(f"{out} holds a map already; give another --out")
    try:
        log = read_laser_log(laser)
    except LogFileError as error:
        _refuse(str(error))
    for note in log.notes:
        console.print(f"[yellow]{note}[/yellow]", highlight=False)
    ensure_kernels(WORKSHOP)
    with stage_bars(console) as bars:
        try:
            laser_map = map_log(log, MappingParams(), StageBars(bars))
        except MapTooLarge as error:
            _refuse(f"{error} No map is made of it.")
    print_residuals(console, msgspec.structs.asdict(laser_map.residuals))
    try:
        written = write_map_folder(out, laser_map, log, laser.name)
    except OSError as error:
        _refuse(f"{out} cannot be written: {error.strerror or error}")
    for path in written:
        console.print(f"written: {path}", highlight=False)


def _refuse(detail: str) -> NoReturn:
    console.print(f"[red]{escape(detail)}[/red]", highlight=False)
    raise typer.Exit(EXIT_BAD_INPUT)

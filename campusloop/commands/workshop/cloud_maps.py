"""`campusloop workshop map --clouds`: a map of surfaces from recorded lidar scans."""

from pathlib import Path

from rich.console import Console

from campusloop.commands.workshop.bars import StageBars, stage_bars
from campusloop.commands.workshop.residual_table import print_residuals
from campusloop.kernels.compiling import ensure_kernels
from campusloop.kernels.groups import CLOUD_MAPPING
from contract.point_map.map_files import INDEX
from contract.roads.load import load_map
from contract.roads.model import Origin
from workshop.cloud_mapping.drive_scans import DriveScans
from workshop.cloud_mapping.gnss_fixes import Fixes, FixFileError, read_fixes
from workshop.cloud_mapping.map_folder import MapFolderError, read_reference, write_map_folder
from workshop.cloud_mapping.mapping import CloudMappingParams, TooFewScans, map_scans
from workshop.clouds.errors import CloudFileError
from workshop.clouds.recordings import find_recordings

console = Console(soft_wrap=True)


class RefusedInput(Exception):
    """The input makes no map; the message is for the person who gave it."""


class NotWritten(Exception):
    """The map could not be written, and nothing of it was left; the message says why."""


def map_clouds(
    clouds: list[Path], out: Path, gnss: Path | None, truth: Path | None, road_map: Path | None,
    lever_m: tuple[float, float, float],
) -> None:  # fmt: skip
    """Raises RefusedInput and NotWritten."""
    if out.exists() and any(out.iterdir() if out.is_dir() else (out,)):
        what = "holds a map already" if (out / INDEX).exists() else "is not empty"
        raise RefusedInput(f"{out} {what}; give another --out")
    ensure_kernels(CLOUD_MAPPING)
    try:
        scans = DriveScans([recording for path in clouds for recording in find_recordings(path)])
        fixes = _fixes(gnss, road_map)
        reference = None if truth is None else read_reference(truth)
        with stage_bars(console) as bars:
            params = CloudMappingParams(lever_sensor_m=lever_m)
            cloud_map = map_scans(scans, len(scans), fixes, params, StageBars(bars))
    except (CloudFileError, FixFileError, TooFewScans, MapFolderError) as error:
        for note in scans.notes if "scans" in locals() else ():
            console.print(f"[yellow]{note}[/yellow]", highlight=False)
        raise RefusedInput(str(error)) from error
    notes = (*scans.notes, *cloud_map.notes)
    for note in notes:
        console.print(f"[yellow]{note}[/yellow]", highlight=False)
    names = [path.name for path in clouds]
    try:
        report = write_map_folder(out, cloud_map, params, names, notes, reference)
    except MapFolderError as error:
        raise RefusedInput(str(error)) from error
    except OSError as error:
        raise NotWritten(
            f"{out} cannot be written: {error.strerror or error}. No map was left there."
        ) from error
    print_residuals(console, report)
    console.print(f"written: {out / INDEX}", highlight=False)


def _fixes(gnss: Path | None, road_map: Path | None) -> Fixes | None:
    if gnss is None:
        return None
    origin: Origin | None = None if road_map is None else load_map(road_map).origin
    return read_fixes(gnss, origin)

"""`campusloop map`: build road maps, check them, write them in others' formats; send localization maps."""

import csv
import itertools
import math
import os
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from campusloop.commands.map_upload import upload
from contract.roads.load import MapError, encode_map, load_map
from contract.roads.model import Lane, RoadMap
from contract.roads.validate import problems
from server.feeds.roads.exchange.formats import EXPORTS, ExportFormat, import_map
from server.feeds.roads.import_osm import ImportOptions, ImportReport
from server.feeds.roads.osm.osm_file import Bounds
from server.feeds.roads.schematic import snow_lion_map

app = typer.Typer(help="Build road maps and check them; send localization maps.", no_args_is_help=True)

app.command("upload")(upload)

_BAD_INPUT = 2
_DEFECTS = 1


@app.command("import")
def import_file(
    source: Annotated[Path, typer.Argument(metavar="FILE", help="OpenStreetMap, GeoJSON, Lanelet2")],
    out: Annotated[Path, typer.Option("--out", help="the map to write")],
    campus_id: Annotated[str, typer.Option(help="the campus's id in every table and topic")] = "campus",
    name: Annotated[str, typer.Option(help="the campus's name for people")] = "Campus",
    timezone: Annotated[str, typer.Option(help="IANA name, for timetables")] = "UTC",
    bounds: Annotated[
        str, typer.Option(help="SOUTH,WEST,NORTH,EAST in degrees, instead of what the file declares")
    ] = "",
    names: Annotated[
        Path | None, typer.Option(help="CSV of name,name_en: English names of stops without a name:en tag")
    ] = None,
    left_hand: Annotated[bool, typer.Option("--left-hand", help="traffic keeps left")] = False,
) -> None:
    """Build a drivable map from an OpenStreetMap, GeoJSON or Lanelet2 file and list every repair."""
    console = Console()
    try:
        options = ImportOptions(
            campus_id=campus_id,
            name=name,
            timezone=timezone,
            bounds=_bounds(bounds) if bounds else None,
            left_hand=left_hand,
            names_en=_names(names) if names else {},
        )
        with console.status(f"importing {source.name}"):
            report = import_map(source, options)
        _write(out, encode_map(report.map))
    except MapError as error:
        _refuse(console, error)
    _print_lists(console, report)
    _print_summary(console, report.map)
    console.print(f"written to {escape(str(out))}, version {report.map.map_version}", soft_wrap=True)


@app.command("check")
def check_map(map_file: Annotated[Path, typer.Argument(metavar="MAP.json")]) -> None:
    """Print the problems of a map; exit 1 if there are any."""
    console = Console()
    try:
        road_map = load_map(map_file)
    except MapError as error:
        _refuse(console, error)
    found = problems(road_map)
    _print_summary(console, road_map)
    if not found:
        console.print(f"{escape(str(map_file))} is sound, version {road_map.map_version}", soft_wrap=True)
        return
    table = Table("code", "where", "what", title=f"{len(found)} problems")
    for problem in found:
        table.add_row(problem.code, escape(problem.where), escape(problem.detail))
    console.print(table)
    raise typer.Exit(_DEFECTS)


@app.command("export")
def export_map(
    map_file: Annotated[Path, typer.Argument(metavar="MAP.json")],
    out: Annotated[Path, typer.Option("--out", help="the file to write")],
    format_: Annotated[ExportFormat, typer.Option("--format", help="geojson or lanelet2")] = "geojson",
) -> None:
    """Write a map as GeoJSON or Lanelet2; `campusloop map import` reads it back without loss."""
    console = Console()
    try:
        written = EXPORTS[format_](load_map(map_file))
        _write(out, written)
    except MapError as error:
        _refuse(console, error)
    console.print(f"written to {escape(str(out))}, {len(written) / 1e6:.1f} MB", soft_wrap=True)


@app.command("schematic")
def build_schematic(out: Annotated[Path, typer.Option("--out", help="the map to write")]) -> None:
    """Build the schematic Snow Lion network with its published timetable."""
    console = Console()
    road_map = snow_lion_map()
    try:
        _write(out, encode_map(road_map))
    except MapError as error:
        _refuse(console, error)
    _print_summary(console, road_map)
    console.print(f"written to {escape(str(out))}, version {road_map.map_version}", soft_wrap=True)


def _refuse(console: Console, error: MapError) -> NoReturn:
    console.print(f"[bold red]{error.code}[/]: {escape(error.detail)}", soft_wrap=True)
    raise typer.Exit(_BAD_INPUT) from error


def _write(out: Path, content: bytes) -> None:
    """Write atomically: a map that a full disk cuts short must not replace a good one."""
    part = out.with_name(out.name + ".part")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        part.write_bytes(content)
        os.replace(part, out)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise MapError(
            "not_written", f"cannot write {out}: {error.strerror}; choose another --out"
        ) from error


def _bounds(text: str) -> Bounds:
    try:
        south, west, north, east = (float(part) for part in text.split(","))
    except ValueError as error:
        raise MapError("bad_bounds", f"--bounds {text}: give SOUTH,WEST,NORTH,EAST in degrees") from error
    if not (-90.0 < south < north < 90.0 and -180.0 <= west < east <= 180.0):
        raise MapError("bad_bounds", f"--bounds {text}: south must be below north and west below east")
    return Bounds(south, west, north, east)


def _names(path: Path) -> dict[str, str]:
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise MapError("bad_names", f"cannot read {path}: {error}; give a UTF-8 CSV: name,name_en") from error
    if any(not row.get("name") or not row.get("name_en") for row in rows):
        raise MapError("bad_names", f"{path}: every row needs a name and a name_en; the first row names them")
    return {row["name"]: row["name_en"] for row in rows}


def _print_lists(console: Console, report: ImportReport) -> None:
    for title, lines in (("repaired", report.repairs), ("left out", report.dropped)):
        console.print(f"[bold]{title}: {len(lines)}[/]")
        for line in lines:
            console.print(f"  {escape(line)}", soft_wrap=True, highlight=False)


def _print_summary(console: Console, road_map: RoadMap) -> None:
    table = Table("what", "count", "detail", title=escape(road_map.name))
    for kind in ("road", "turn", "turnaround"):
        lanes = [lane for lane in road_map.lanes if lane.kind == kind]
        table.add_row(f"{kind} lanes", str(len(lanes)), f"{sum(map(_length_m, lanes)) / 1000.0:.1f} km")
    narrow = sum(1 for lane in road_map.lanes if lane.kind == "road" and not lane.can_pass)
    table.add_row("roads too narrow to pass", str(narrow), "lanes that exclude their opposite")
    table.add_row("sections", str(len(road_map.sections)))
    for how, noun in (("tag", "tagged"), ("rule", "placed by rule"), ("hand", "placed by hand")):
        stops = [stop for stop in road_map.stops if stop.placed_by == how]
        if stops:
            table.add_row(f"stops {noun}", str(len(stops)), escape(", ".join(stop.name for stop in stops)))
    table.add_row("resting places", str(len(road_map.resting_places)))
    table.add_row("buildings", str(len(road_map.buildings)))
    table.add_row("timetable trips", str(len(road_map.timetable)))
    console.print(table)


def _length_m(lane: Lane) -> float:
    return sum(math.dist(a, b) for a, b in itertools.pairwise(lane.points))

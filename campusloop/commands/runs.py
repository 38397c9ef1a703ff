"""`campusloop runs`: recorded runs on disk, listed, summed up, and exported for other programs."""

import json
import shlex
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from rich.console import Console

from campusloop.run_logs.folders import RecordedRun, RunNotFound, one_run, runs_found
from campusloop.run_logs.positions import positions_csv, positions_geojson, positions_of
from campusloop.run_logs.summary import RunSummary, ending, run_summary
from campusloop.run_logs.viewer_file import write_viewer_file
from contract.roads.load import MapError
from contract.runlog.reader import RunLogError

EXIT_BAD_INPUT = 2
VAR = Path("var")

app = typer.Typer(no_args_is_help=True)

RunName = Annotated[
    str, typer.Argument(metavar="RUN", help="A run's folder, a segment (.mcap), or VEHICLE/BOOT as listed.")
]
Place = Annotated[Path, typer.Option("--in", metavar="DIR", help="Where VEHICLE/BOOT is looked for.")]
AsJson = Annotated[bool, typer.Option("--json", help="For programs.")]


@app.command("list")
def list_runs(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="A folder with run logs below it, or a segment.")
    ] = VAR,
    as_json: AsJson = False,
) -> None:
    """List the runs in a folder, newest first. Times are UTC."""
    errors = Console(stderr=True, soft_wrap=True, highlight=False)
    try:
        found = runs_found(folder)
    except RunNotFound as error:
        _refuse(errors, str(error))
    if as_json:
        unreadable = [{"code": error.code, "detail": error.detail} for error in found.unreadable.values()]
        typer.echo(
            json.dumps({"runs": [_facts(run) for run in found.runs], "unreadable": unreadable}, indent=1)
        )
    elif found.runs:
        _print_table(found.runs)
    if not as_json:
        _print_defects(errors, tuple(found.unreadable.values()))
    if not found.runs:
        raise typer.Exit(EXIT_BAD_INPUT)


@app.command("show")
def show(run: RunName, place: Place = VAR, as_json: AsJson = False) -> None:
    """Say when and with what a run was driven, how far, which events there were, and how it ended."""
    errors = Console(stderr=True, soft_wrap=True, highlight=False)
    chosen = _chosen(errors, run, place)
    summary = run_summary(chosen)
    if as_json:
        told = {
            "distance_m": round(summary.distance_m, 1),
            "events": summary.events,
            "ended": ending(summary),
            "defects": [{"code": error.code, "detail": error.detail} for error in summary.defects],
        }
        typer.echo(json.dumps(_facts(chosen) | told, indent=1))
        return
    console = Console(soft_wrap=True, highlight=False)
    for label, text in _lines(chosen, summary):
        console.print(f"{label:<10}{text}", markup=False)
    _print_defects(errors, summary.defects)


@app.command("export")
def export(
    run: RunName,
    out: Annotated[
        Path,
        typer.Option("--out", help="New file: .mcap for Foxglove; .csv or .geojson for positions at 5 Hz."),
    ],
    place: Place = VAR,
) -> None:
    """Write a run as one file for another program."""
    errors = Console(stderr=True, soft_wrap=True, highlight=False)
    kind = out.suffix.lower()
    if kind not in (".mcap", ".csv", ".geojson"):
        _refuse(errors, f"{out}: end the name with .mcap (Foxglove), .csv or .geojson (positions)")
    if out.exists():
        _refuse(errors, f"{out} exists; give another --out")
    chosen = _chosen(errors, run, place)
    try:
        if kind == ".mcap":
            defects = write_viewer_file(chosen, out)
        else:
            positions = positions_of(chosen)
            if not positions.found:
                _refuse(
                    errors,
                    f"{chosen.name}: the vehicle never knew where it was in this run; nothing is written",
                )
            is_table = kind == ".csv"
            data = positions_csv(positions.found) if is_table else positions_geojson(chosen, positions.found)
            out.write_bytes(data)
            defects = positions.defects
    except RunLogError as error:
        _refuse(errors, _remedied(error))
    except MapError as error:
        _refuse(errors, f"the map in {chosen.name} cannot be used: {error.detail}")
    except OSError as error:
        _refuse(errors, f"{out} cannot be written ({error}); give another --out")
    Console(soft_wrap=True, highlight=False).print(f"written: {out}", markup=False)
    _print_defects(errors, defects)


def _chosen(errors: Console, run: str, place: Path) -> RecordedRun:
    """The run; says which files beside it cannot be used."""
    try:
        chosen, unreadable = one_run(run, place)
    except RunNotFound as error:
        _refuse(errors, str(error))
    except RunLogError as error:
        _refuse(errors, _remedied(error))
    _print_defects(errors, unreadable)
    return chosen


def _facts(run: RecordedRun) -> dict[str, Any]:
    header = run.header
    return {
        "run": run.name,
        "vehicle_id": header.vehicle_id,
        "boot_id": header.boot_id,
        "campus_id": header.campus_id,
        "map_version": header.map_version,
        "stack": header.stack,
        "software": header.software,
        "began_at": run.began_at.isoformat(),
        "duration_s": round(run.duration_s, 3),
        "size_bytes": run.size_bytes,
        "segments": [str(path) for path in run.paths],
        "missing_segments": list(run.missing_numbers),
    }


def _print_table(runs: tuple[RecordedRun, ...]) -> None:
    """Nothing is cut off: names and folders are typed again."""
    rows = [("run", "began (UTC)", "duration", "stack", "segments", "MB", "folder")]
    rows += [
        (
            run.name,
            f"{run.began_at:%Y-%m-%d %H:%M:%S}",
            _duration(run.duration_s),
            run.header.stack,
            str(len(run.segments)),
            f"{run.size_bytes / 1e6:.1f}",
            str(run.folder),
        )
        for run in runs
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        typer.echo("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def _lines(run: RecordedRun, summary: RunSummary) -> list[tuple[str, str]]:
    header = run.header
    events = ", ".join(f"{number} {name.replace('_', ' ')}" for name, number in summary.events.items())
    paths = " ".join(shlex.quote(str(path)) for path in run.paths)
    # A server's copies lie one a folder, beside those of other runs.
    is_alone = all(path.parent == run.folder for path in run.paths)
    target = shlex.quote(str(run.folder)) if is_alone else paths
    count = "1 segment" if len(run.segments) == 1 else f"{len(run.segments)} segments"
    lines = [
        ("run", run.name),
        ("began", f"{run.began_at:%Y-%m-%d %H:%M:%S} UTC, for {_duration(run.duration_s)}"),
        ("vehicle", header.vehicle_id),
        ("stack", f"{header.stack}, software {header.software}"),
        ("campus", f"{header.campus_id}, map {header.map_version}"),
        ("distance", f"{summary.distance_m:.0f} m"),
        ("events", events or "none"),
        ("ended", ending(summary)),
        ("files", f"{count}, {run.size_bytes / 1e6:.1f} MB in {run.folder}"),
    ]
    if run.missing_numbers:
        lines.append(
            ("missing", f"segments {', '.join(map(str, run.missing_numbers))}; the server may have them")
        )
    return [*lines, ("view", f"campusloop view {target}"), ("replay", f"campusloop replay {target}")]


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d} min"


def _print_defects(errors: Console, defects: tuple[RunLogError, ...]) -> None:
    for error in defects:
        errors.print(_remedied(error), style="yellow", markup=False)


def _remedied(error: RunLogError) -> str:
    """What is wrong with a file, and what to do."""
    if error.code == "truncated":
        return f"{error.detail}. The vehicle still records it, or was killed: then use the server's copy"
    return error.detail


def _refuse(errors: Console, text: str) -> NoReturn:
    errors.print(text, style="red", markup=False)
    raise typer.Exit(EXIT_BAD_INPUT)

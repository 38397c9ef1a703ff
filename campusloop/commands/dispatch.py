"""`campusloop dispatch`: published dial-a-ride instances."""

import json
import math
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.table import Table

from campusloop.bound_run import BoundRun, run_bound
from server.dispatch.bound.events import TooManyEvents
from server.dispatch.bound.proof import Progress
from server.dispatch.instance import InstanceBroken
from server.feeds.instances.load import load_instance

app = typer.Typer(no_args_is_help=True)
# Without a callback, an app of one command would take that command's name for an argument.
app.callback()(lambda: None)

_BAD_INPUT = 2


@app.command()
def bound(
    instance_path: Annotated[
        Path, typer.Argument(metavar="INSTANCE", help="a dial-a-ride instance (Cordeau's or Berbeglia's format)")
    ],
    seconds: Annotated[float, typer.Option(min=0.0, help="wall time after which the best bound is printed")] = 600.0,
    upper: Annotated[
        float | None, typer.Option(min=0.0, help="cost of a solution known from elsewhere; spares work")
    ] = None,
    json_path: Annotated[Path | None, typer.Option("--json", help="write the result here")] = None,
) -> None:
    """Prove a lower bound of the distance that any plan of the instance needs."""
    errors = Console(stderr=True)
    try:
        instance = load_instance(instance_path)
        with errors.status(f"{instance.name}: building the event graph") as status:

            def show(progress: Progress) -> None:
                status.update(f"{instance.name}: {_line(progress)}")

            run = run_bound(instance, seconds, math.inf if upper is None else upper, show)
    except (InstanceBroken, TooManyEvents) as error:
        _refuse(errors, str(error))
    except OSError as error:
        _refuse(errors, f"{instance_path}: {error.strerror}")
    Console().print(_table(instance.name, run))
    if json_path is not None:
        try:
            json_path.write_text(json.dumps(_report(instance.name, run), indent=2, allow_nan=False) + "\n")
        except OSError as error:
            _refuse(errors, f"{json_path}: {error.strerror}")


def _line(progress: Progress) -> str:
    best = f"{progress.upper:.2f}" if progress.solution else "none yet"
    return f"{progress.stage}, bound {progress.bound:.2f}, best solution {best}, {progress.columns} columns"


def _table(name: str, run: BoundRun) -> Table:
    proven = run.proven
    gap_pct = run.gap_pct
    table = Table("", "", title=name, title_justify="left", show_header=False)
    for label, value in (
        # Rounded down: a bound that is rounded up is none.
        ("bound", f"{math.floor(proven.bound * 1e4) / 1e4:.4f}"),
        ("best solution", f"{proven.upper:.4f}, {len(proven.solution)} routes" if proven.solution else "none found"),
        ("gap", "unknown" if gap_pct is None else f"{gap_pct:.4f} %"),
        ("closed", "yes" if proven.closed else "no"),
        ("columns", str(proven.columns)),
        ("rounds", str(proven.rounds)),
        ("cuts", str(proven.cuts)),
        ("tree nodes", str(proven.nodes)),
        ("CPU", f"{run.cpu_s:.1f} s"),
        ("wall", f"{run.wall_s:.1f} s"),
    ):
        table.add_row(label, value)
    return table


def _report(name: str, run: BoundRun) -> dict[str, object]:
    proven = run.proven
    return {
        "instance": name,
        "bound": proven.bound,
        "upper": proven.upper if proven.solution else None,
        "gap_pct": run.gap_pct,
        "closed": proven.closed,
        "columns": proven.columns,
        "rounds": proven.rounds,
        "cuts": proven.cuts,
        "nodes": proven.nodes,
        "cpu_s": run.cpu_s,
        "wall_s": run.wall_s,
        "routes": [list(route) for route in proven.solution],
    }


def _refuse(errors: Console, text: str) -> NoReturn:
    errors.print(text, style="red", markup=False, highlight=False, soft_wrap=True)
    raise typer.Exit(_BAD_INPUT)

"""`campusloop dispatch bound`: a lower bound of the cost of a published dial-a-ride instance."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar
from rich.table import Table

from campusloop.commands.dispatch.output import JsonPath, refuse, write_json
from campusloop.studies.bound.events import TooManyEvents
from campusloop.studies.bound.progress import Progress
from campusloop.studies.dispatch.bound_run import BoundRun, run_bound
from campusloop.studies.instances.instance import InstanceBroken
from campusloop.studies.instances.load import load_instance


def bound(
    instance_path: Annotated[
        Path,
        typer.Argument(
            metavar="INSTANCE", help="a dial-a-ride instance (Cordeau's, Berbeglia's or Li and Lim's format)"
        ),
    ],
    seconds: Annotated[
        float, typer.Option(min=0.0, help="wall time after which the best bound is printed")
    ] = 600.0,
    upper: Annotated[float | None, typer.Option(min=0.0, help="cost of a known solution; saves work")] = None,
    json_path: JsonPath = None,
) -> None:
    """Prove a lower bound of the distance that any plan of the instance needs."""
    errors = Console(stderr=True)
    try:
        instance = load_instance(instance_path)
        with _bar(errors, instance.name, seconds) as show:
            run = run_bound(instance, seconds, math.inf if upper is None else upper, show)
    except (InstanceBroken, TooManyEvents) as error:
        refuse(errors, str(error))
    except OSError as error:
        refuse(errors, f"{instance_path}: {error.strerror}")
    if json_path is None or not write_json(errors, json_path, _report(instance.name, run)):
        Console().print(_table(instance.name, run))


@contextmanager
def _bar(console: Console, name: str, seconds: float) -> Iterator[Callable[[Progress], None]]:
    """A progress bar of the time limit, with the bound that is proven so far."""
    with Bar(
        TextColumn("{task.description}"),
        BarColumn(),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        # Drawing slows down the proof, which runs in the same process.
        refresh_per_second=2,
    ) as bar:
        task = bar.add_task(f"{name}: looking for a good plan", total=max(seconds, 1e-9))

        def show(progress: Progress) -> None:
            description = f"{name}: {progress.stage}, bound {progress.bound:.2f}, {progress.columns} columns"
            bar.update(task, description=description, completed=bar.tasks[0].elapsed or 0.0)

        yield show


def _table(name: str, run: BoundRun) -> Table:
    proven, best = run.proven, run.best
    table = Table("", "", title=name, title_justify="left", show_header=False)
    for label, value in (
        # Rounded down: a value above the proven one is not a bound.
        ("bound", f"{math.floor(proven.bound * 1e4) / 1e4:.4f}"),
        ("best solution", "none found" if math.isinf(best.cost) else _solution_text(run)),
        ("gap", "unknown" if run.gap_pct is None else f"{run.gap_pct:.4f} %"),
        ("limited by", run.limited_by or "nothing: the best solution is optimal"),
        ("columns", f"{proven.columns} in {proven.rounds} rounds"),
        ("cuts", str(proven.cuts)),
        ("tree nodes", str(proven.nodes)),
        ("CPU", f"{run.cpu_s:.1f} s"),
        ("wall", f"{run.wall_s:.1f} s"),
    ):
        table.add_row(label, value)
    return table


def _solution_text(run: BoundRun) -> str:
    return f"{run.best.cost:.4f}, {len(run.best.routes)} routes"


def _report(name: str, run: BoundRun) -> dict[str, object]:
    proven, best = run.proven, run.best
    return {
        "instance": name,
        "bound": proven.bound,
        "solution": None if math.isinf(best.cost) else best.cost,
        "gap_pct": run.gap_pct,
        "closed": run.closed,
        "limited_by": run.limited_by,
        "columns": proven.columns,
        "rounds": proven.rounds,
        "cuts": proven.cuts,
        "nodes": proven.nodes,
        "cpu_s": run.cpu_s,
        "wall_s": run.wall_s,
        "routes": [list(route) for route in best.routes],
    }

"""`campusloop dispatch bound`: a lower bound of the cost of a published dial-a-ride instance."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar
from rich.table import Table

from campusloop.campaigns.campaign import CampaignError
from campusloop.campaigns.choice import open_campaign
from campusloop.commands.dispatch.output import JsonPath, refuse, write_json
from campusloop.studies.bound.events import TooManyEvents
from campusloop.studies.bound.progress import Progress
from campusloop.studies.dispatch.bound_run import BoundRun, run_bound
from campusloop.studies.instances.instance import Instance, InstanceBroken
from campusloop.studies.instances.load import load_instance


@dataclass(frozen=True, slots=True)
class BoundJob:
    """One instance of a campaign; seconds of wall time for it."""

    instance: Instance
    seconds: float


def bound(
    instance_paths: Annotated[
        list[Path],
        typer.Argument(
            metavar="INSTANCE...",
            help="dial-a-ride instances (Cordeau's, Berbeglia's or Li and Lim's format), or folders of them",
        ),
    ],
    seconds: Annotated[
        float,
        typer.Option(min=0.0, help="wall time for each instance, after which its best bound is printed"),
    ] = 600.0,
    upper: Annotated[
        float | None, typer.Option(min=0.0, help="cost of a known solution; saves work (for one instance)")
    ] = None,
    json_path: JsonPath = None,
    workers: Annotated[
        int, typer.Option(min=0, help="processes for several instances; 0: one for each core")
    ] = 1,
    cluster: Annotated[
        str | None,
        typer.Option(help="Dask scheduler (tcp://HOST:8786) whose workers prove several instances"),
    ] = None,
) -> None:
    """Prove a lower bound of the distance that any plan of an instance needs."""
    errors = Console(stderr=True)
    try:
        instances = _instances(instance_paths)
        if len(instances) == 1:
            _one(errors, instances[0], seconds, upper, json_path)
            return
        if upper is not None:
            refuse(errors, "--upper is the cost of one instance's solution; several instances are given")
        _several(errors, instances, seconds, json_path, workers, cluster)
    except (InstanceBroken, TooManyEvents, CampaignError) as error:
        refuse(errors, str(error))


def prove_bound(job: BoundJob) -> BoundRun | str:
    """The run, or why there is no bound: the instance has no solution or is too large."""
    try:
        return run_bound(job.instance, job.seconds)
    except (InstanceBroken, TooManyEvents) as error:
        return str(error)


def _instances(paths: list[Path]) -> list[Instance]:
    found = []
    for path in paths:
        inside = sorted(one for one in path.iterdir() if one.is_file()) if path.is_dir() else [path]
        if not inside:
            raise InstanceBroken(f"{path}: no instances there")
        for one in inside:
            try:
                found.append(load_instance(one))
            except OSError as error:
                raise InstanceBroken(f"{one}: {error.strerror}") from error
    return found


def _one(
    errors: Console, instance: Instance, seconds: float, upper: float | None, json_path: Path | None
) -> None:
    with _bar(errors, instance.name, seconds) as show:
        run = run_bound(instance, seconds, math.inf if upper is None else upper, show)
    if json_path is None or not write_json(errors, json_path, _report(instance.name, run)):
        Console().print(_table(instance.name, run))


def _several(
    errors: Console,
    instances: list[Instance],
    seconds: float,
    json_path: Path | None,
    workers: int,
    cluster: str | None,
) -> None:
    table = Table("instance", "bound", "best solution", "gap %", "limited by", title_justify="left")
    reports: list[dict[str, object]] = []
    jobs = [BoundJob(instance, seconds) for instance in instances]
    with open_campaign(cluster, workers) as campaign:
        for instance, run in zip(instances, campaign.run(prove_bound, jobs), strict=True):
            if isinstance(run, str):
                table.add_row(instance.name, "-", "-", "-", run)
                reports.append({"instance": instance.name, "bound": None, "limited_by": run})
                continue
            gap = "unknown" if run.gap_pct is None else f"{run.gap_pct:.4f}"
            solution = "none found" if math.isinf(run.best.cost) else _solution_text(run)
            table.add_row(instance.name, _rounded_down(run.proven.bound), solution, gap, run.limited_by)
            reports.append(_report(instance.name, run))
            errors.print(f"{instance.name}: bound {_rounded_down(run.proven.bound)}", highlight=False)
    if json_path is None or not write_json(errors, json_path, {"instances": reports}):
        Console().print(table)


def _rounded_down(bound: float) -> str:
    # A value above the proven one is not a bound.
    return f"{math.floor(bound * 1e4) / 1e4:.4f}"


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
        ("bound", _rounded_down(proven.bound)),
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

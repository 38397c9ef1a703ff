"""`campusloop infrastructure`: cameras at crossings, and the time that they save."""

import json
import platform
import time
from importlib.resources import files
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

from campusloop.campaigns.campaign import CampaignError
from campusloop.commands.crossing_watch import watch
from campusloop.studies.infrastructure.infrastructure_gain import (
    GainCase,
    GainRow,
    as_dict,
    plot_fleet,
    plot_single,
    run_cases,
    summary,
)
from vehicle_agent.config import ProfileError, load_profile

app = typer.Typer(help="Cameras at crossings, and the time that they save.", no_args_is_help=True)
app.command()(watch)

EXIT_BAD_INPUT = 2
# As many as fit on the loop with the carts' gap at 2 m/s.
VEHICLES_MAX = 20
SPEED_MPS_MAX = 2.0


@app.callback()
def infrastructure() -> None:
    """Cameras at crossings: watch one, or compute what they save."""


@app.command()
def gain(
    out: Annotated[Path, typer.Option(help="Folder for gain.json and the two plots.")],
    vehicles: Annotated[str, typer.Option(help="Fleet sizes, up to 20.")] = "1,2,5,10,20",
    speeds: Annotated[str, typer.Option(help="m/s, up to 2.")] = "1,2",
    rates: Annotated[
        str, typer.Option("--lambda", help="People per second who come to cross.")
    ] = "0.02,0.1,1",
    laps: Annotated[int, typer.Option(min=1, help="A vehicle's laps.")] = 20,
    seed: Annotated[int, typer.Option(help="Of people and camera.")] = 1,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0: one for each core.")] = 1,
    cluster: Annotated[
        str | None, typer.Option(help="Dask scheduler (tcp://HOST:8786) whose workers compute.")
    ] = None,
    profile: Annotated[Path | None, typer.Option(help="Vehicle profile; the golf cart's without it.")] = None,
) -> None:
    """Time gained by a crossing's camera over laps: the NUS paper's Fig. 12 (plots and JSON)."""
    console = Console()
    sizes = [int(value) for value in _numbers(console, "--vehicles", vehicles, 1.0, VEHICLES_MAX)]
    speeds_mps = _numbers(console, "--speeds", speeds, 0.2, SPEED_MPS_MAX)
    rates_1ps = _numbers(console, "--lambda", rates, 1e-6, 10.0)
    path = Path(str(files("vehicle_agent") / "profiles" / "nus-cart.toml")) if profile is None else profile
    try:
        cart = load_profile(path)
        out.mkdir(parents=True, exist_ok=True)
    except (ProfileError, OSError) as error:
        _refuse(console, str(error))
    cases = [
        GainCase(size, speed, rate, laps, seed)
        for rate in rates_1ps
        for speed in speeds_mps
        for size in sizes
    ]
    begun_s, begun_cpu_s = time.perf_counter(), time.process_time()
    rows: list[GainRow] = []
    with Progress(console=console, transient=True) as progress:
        bar = progress.add_task("cases", total=len(cases))
        try:
            for row in run_cases(cart, cases, workers, cluster):
                rows.append(row)
                progress.advance(bar)
        except CampaignError as error:
            _refuse(console, str(error))
    report = {
        "name": "infrastructure_gain",
        "machine": f"{platform.machine()}, Python {platform.python_version()}",
        "arguments": {
            "vehicles": sizes, "speeds_mps": speeds_mps, "lambda_1ps": rates_1ps, "laps": laps, "seed": seed,
        },
        "wall_s": round(time.perf_counter() - begun_s, 1),
        "cpu_s": round(time.process_time() - begun_cpu_s, 1),
        "rows": [as_dict(row) for row in rows],
        "summary": summary(rows),
    }  # fmt: skip
    (out / "gain.json").write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    plot_single(rows, out / "gain-one-vehicle.png")
    plot_fleet(rows, out / "gain-fleet.png")
    _print(console, rows)
    console.print(f"gain.json, gain-one-vehicle.png and gain-fleet.png are in {out}", soft_wrap=True)


def _print(console: Console, rows: list[GainRow]) -> None:
    table = Table("people/s", "m/s", "vehicles", "laps", "lap without, s", "with, s", "total gain, s")
    for row in rows:
        total = f"{row.cumulative_s[-1]:.1f}" if row.cumulative_s else "-"
        table.add_row(
            f"{row.rate_1ps:g}", f"{row.speed_mps:g}", str(row.vehicles), str(row.laps_finished),
            f"{row.base_lap_s:.1f}", f"{row.infra_lap_s:.1f}", total,
        )  # fmt: skip
    console.print(table)


def _numbers(console: Console, option: str, text: str, low: float, high: float) -> list[float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        _refuse(console, f"{option} {text}: give numbers with commas between them")
    if not values or not all(low <= value <= high for value in values):
        _refuse(console, f"{option} {text}: give numbers from {low:g} to {high:g}")
    return values


def _refuse(console: Console, detail: str) -> NoReturn:
    console.print(f"[red]{escape(detail)}[/red]", soft_wrap=True, highlight=False)
    raise typer.Exit(EXIT_BAD_INPUT)

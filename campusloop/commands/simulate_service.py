"""`campusloop simulate-service`: the service in virtual time under faults; exit 1 if a rule was broken."""

import gc
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import msgspec
import structlog
import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from campusloop.kernels.compiling import ensure_kernels
from campusloop.kernels.groups import SERVER, for_vehicle
from campusloop.shipped import DEFAULT_MAP
from campusloop.simulation.faults import KINDS
from campusloop.simulation.service import SETTLE_S, SimulatedService, SimulationOptions, SimulationResult
from contract.roads.load import MapError, load_map

console = Console()

EXIT_BROKEN = 1
EXIT_BAD_INPUT = 2
# Files of the simulated disks are many and small: they belong in memory, where the system has such a folder.
_IN_MEMORY = Path("/dev/shm")
# Objects: few of them are in cycles, so that Python's own number only costs time.
_COLLECT_AFTER = 50_000


def simulate_service(
    seed: Annotated[int, typer.Option(help="Everything is drawn from it.")] = 1,
    vehicles: Annotated[int, typer.Option(min=1)] = 20,
    hours: Annotated[float, typer.Option(min=0.05, help="Virtual hours of bookings and faults.")] = 8.0,
    faults: Annotated[str, typer.Option(help="Kinds with commas, 'none' or 'all'.")] = "all",
    rides_per_hour: Annotated[float, typer.Option(min=0.1)] = 120.0,
    settle_minutes: Annotated[
        float, typer.Option(min=4.0, help="Without faults and bookings, at the end.")
    ] = SETTLE_S / 60.0,
    map_path: Annotated[Path, typer.Option("--map", help="A campus map.")] = DEFAULT_MAP,
    json_path: Annotated[Path | None, typer.Option("--json", help="Write the result there.")] = None,
) -> None:
    """Server, vehicles, people and wire under one virtual clock, with faults from a seed; checks its history.

    The same seed and options give the same history, bit for bit: its digest is printed.
    """
    kinds = _kinds(faults)
    try:
        road_map = load_map(map_path)
    except MapError as error:
        _refuse(f"{map_path}: {error.detail}")
    if vehicles > len(road_map.resting_places):
        _refuse(f"{road_map.name} has {len(road_map.resting_places)} resting places: fewer vehicles, please")
    ensure_kernels((*SERVER, *for_vehicle("gem")))
    # Failures are what this is about: each one is in the history, and the log would only repeat them.
    structlog.configure(processors=[_drop])
    begun_cpu_s, begun_s = time.process_time(), time.perf_counter()
    with TemporaryDirectory(dir=_IN_MEMORY if _IN_MEMORY.is_dir() else None) as folder:
        service = SimulatedService(
            SimulationOptions(
                road_map, Path(folder), seed, vehicles, hours, kinds, rides_per_hour, settle_minutes * 60.0
            )
        )
        # What is there now stays to the end: the collector need not look at it again and again.
        gc.collect()
        gc.freeze()
        gc.set_threshold(_COLLECT_AFTER)
        result = service.run()
    cpu_s, wall_s = time.process_time() - begun_cpu_s, time.perf_counter() - begun_s
    again = (
        f"campusloop simulate-service --seed {seed} --vehicles {vehicles} --hours {hours:g} "
        f"--faults {faults} --rides-per-hour {rides_per_hour:g} "
        f"--settle-minutes {settle_minutes:g} --map {map_path}"
    )
    _print(result, cpu_s, wall_s, again)
    if json_path is not None:
        times = {"cpu_s": cpu_s, "wall_s": wall_s}
        ratios = {"cpu_ratio": result.virtual_s / cpu_s, "wall_ratio": result.virtual_s / wall_s}
        found = {"arguments": again, **times, **ratios, **msgspec.to_builtins(result)}
        json_path.write_bytes(msgspec.json.format(msgspec.json.encode(found), indent=2))
    if result.violations:
        raise typer.Exit(EXIT_BROKEN)


def _drop(_logger: object, _method: str, _event: structlog.typing.EventDict) -> structlog.typing.EventDict:
    raise structlog.DropEvent


def _kinds(faults: str) -> tuple[str, ...]:
    if faults in ("none", "all"):
        return tuple(KINDS) if faults == "all" else ()
    kinds = tuple(faults.split(","))
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown:
        _refuse(f"no faults of the kind {', '.join(unknown)}; there are: {', '.join(KINDS)}")
    return kinds


def _refuse(text: str) -> None:
    console.print(f"[red]{escape(text)}[/red]", soft_wrap=True, highlight=False)
    raise typer.Exit(EXIT_BAD_INPUT)


def _print(result: SimulationResult, cpu_s: float, wall_s: float, again: str) -> None:
    table = Table(title="Service in virtual time", title_justify="left", show_header=False)
    rows = {
        "virtual time": f"{result.virtual_s / 3600.0:.2f} h",
        "CPU time": f"{cpu_s:.0f} s: {result.virtual_s / cpu_s:.0f} x",
        "wall time": f"{wall_s:.0f} s: {result.virtual_s / wall_s:.0f} x",
        "faults": _counts(result.faults),
        "server started": f"{result.starts} times",
        "bookings acknowledged": str(result.bookings),
        "rides": _counts(result.rides),
        "events of vehicles": str(result.events),
        "driven": f"{result.driven_m / 1000.0:.1f} km",
        "history": f"{result.lines} lines, digest {result.digest}",
        "violations": str(len(result.violations)),
    }
    for name, value in rows.items():
        table.add_row(name, value)
    console.print(table)
    for violation in result.violations:
        console.print(
            f"{violation.at_s:.1f} s  {violation.rule}  {violation.subject}: {violation.text}",
            soft_wrap=True,
            highlight=False,
            markup=False,
        )
        for line in result.context[violation.subject]:
            console.print(f"    {line}", soft_wrap=True, highlight=False, markup=False)
    if result.violations:
        console.print(f"run it again: {again}", soft_wrap=True, highlight=False, markup=False)


def _counts(counts: dict[str, int]) -> str:
    return ", ".join(f"{number} {name}" for name, number in counts.items()) or "none"

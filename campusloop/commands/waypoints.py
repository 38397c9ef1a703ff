"""`campusloop waypoints`: waypoint files, one for each speed, of a route or of a recorded drive."""

import itertools
import math
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape

from campusloop.commands.replay import segment_paths
from contract.roads.load import MapError, load_map
from contract.roads.model import RoadMap, Stop
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route, route_line
from contract.runlog.reader import RunLogError
from vehicle_agent.planning.waypoint.waypoints import WaypointRules
from vehicle_agent.waypoints.files import write_recording, write_route
from vehicle_agent.waypoints.recorded_runs import recorded_waypoints

app = typer.Typer(no_args_is_help=True)
console = Console()

EXIT_BAD_INPUT = 2

Speeds = Annotated[
    list[float] | None,
    typer.Option(
        "--speed", min=0.1, help="Desired speed (m/s), repeated for more files; default: 1, 2 and 3."
    ),
]
Out = Annotated[Path, typer.Option("--out", help="Folder to write to.")]
Name = Annotated[str, typer.Option(help="Prefix of the files' names.")]

DEFAULT_SPEEDS_MPS = (1.0, 2.0, 3.0)


@app.command()
def record(
    runs: Annotated[list[Path], typer.Argument(help="Segments (.mcap) or folders, in the order driven.")],
    out: Out = Path("waypoints"),
    speeds: Speeds = None,
    name: Name = "drive",
    spacing_m: Annotated[float, typer.Option(min=0.1, help="Between waypoints.")] = 1.0,
) -> None:
    """Write the waypoints of a recorded drive, manual or autonomous: latitude, longitude, speed."""
    paths = segment_paths(runs)
    if not paths:
        _refuse("No segments (*.mcap) there. A run lies in VEHICLE/runs/BOOT/.")
    try:
        waypoints, origin = recorded_waypoints(paths, spacing_m)
    except (RunLogError, MapError) as error:
        _refuse(str(error))
    if len(waypoints) < 2:
        _refuse("the vehicle did not move, or was never localized, in these segments")
    length_m = sum(math.dist((a.x_m, a.y_m), (b.x_m, b.y_m)) for a, b in itertools.pairwise(waypoints))
    console.print(f"{len(waypoints)} waypoints over {length_m:.0f} m")
    _print_written(write_recording(out, name, waypoints, origin, speeds or DEFAULT_SPEEDS_MPS))


@app.command()
def route(
    from_stop: Annotated[str, typer.Argument(help="A stop's id.")],
    to_stop: Annotated[str, typer.Argument(help="A stop's id.")],
    campus_map: Annotated[Path, typer.Option("--map", help="Campus map.")],
    out: Out = Path("waypoints"),
    speeds: Speeds = None,
    name: Name = "",
) -> None:
    """Write the fastest route between two stops as waypoints: latitude, longitude, speed."""
    try:
        road_map = load_map(campus_map)
    except MapError as error:
        _refuse(str(error))
    origin, target = _stop(road_map, from_stop), _stop(road_map, to_stop)
    network = RoadNetwork(road_map)
    found = find_route(network, origin.lane_id, origin.s_m, target.lane_id, target.s_m)
    if found is None or origin is target:
        _refuse(f"there is no route from {from_stop} to {to_stop}")
    console.print(f"{origin.name} to {target.name}: {found.length_m:.0f} m")
    title = name or f"{from_stop}-to-{to_stop}"
    line = route_line(network, found)
    _print_written(
        write_route(out, title, line, road_map.origin, speeds or DEFAULT_SPEEDS_MPS, WaypointRules())
    )


def _stop(road_map: RoadMap, stop_id: str) -> Stop:
    for stop in road_map.stops:
        if stop.stop_id == stop_id:
            return stop
    known = ", ".join(stop.stop_id for stop in road_map.stops)
    _refuse(f"{road_map.name} has no stop {stop_id}; there are: {known}")


def _print_written(written: list[Path]) -> None:
    for path in written:
        console.print(f"written: {path}", soft_wrap=True, highlight=False)


def _refuse(detail: str) -> NoReturn:
    console.print(f"[red]{escape(detail)}[/red]", soft_wrap=True, highlight=False)
    raise typer.Exit(EXIT_BAD_INPUT)

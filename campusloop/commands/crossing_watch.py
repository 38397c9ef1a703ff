"""`campusloop infrastructure watch`: a camera over a crossing, from video to presence reports."""

import asyncio
import re
import ssl
from pathlib import Path
from typing import Annotated, NoReturn

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape

from campusloop.clients.connection_variables import SERVER_VARIABLE, TOKEN_VARIABLE
from campusloop.crossing_cameras.ground_pixels import GroundPixels, MappingError
from campusloop.crossing_cameras.people_counter import PeopleCounter
from campusloop.crossing_cameras.report_link import ReportLink, VehicleDatagrams
from campusloop.crossing_cameras.video import VideoFailure
from campusloop.crossing_cameras.watch import CrossingWatch, WatchOptions
from contract.geometry import Array
from contract.roads.areas import outline_array
from contract.roads.load import MapError, load_map
from contract.wire.messages import PresenceReport
from vehicle_agent.perception.camera.people_detector import CameraLibraryMissing, opencv

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2
_NUMBERS = re.compile(r"[,\s=]+")


def watch(
    source: Annotated[str, typer.Argument(help="Video file, /dev/videoN, or rtsp://HOST/PATH.")],
    area: Annotated[str, typer.Option(help="Id of the observation area that is reported.")],
    point: Annotated[
        list[str],
        typer.Option(
            metavar="U,V=X,Y", help="Pixel and its place on the map, m; give four or more, none on one line."
        ),
    ],
    road_map: Annotated[
        Path | None, typer.Option("--map", help="Road map that has the area; its outline is used.")
    ] = None,
    outline: Annotated[
        str,
        typer.Option(metavar="X,Y X,Y X,Y ...", help="The area's corners on the map, m, in place of --map."),
    ] = "",
    server: Annotated[
        str,
        typer.Option(
            envvar=SERVER_VARIABLE, metavar="URL", help="http(s)://HOST:PORT that gets the reports."
        ),
    ] = "",
    token: Annotated[
        str,
        typer.Option(
            envvar=TOKEN_VARIABLE,
            help="Developer token of scope infrastructure. Better the variable: other users see options.",
            show_default=False,
        ),
    ] = "",
    certificate: Annotated[
        Path | None, typer.Option(help="PEM certificate to trust, if the server's is self-signed.")
    ] = None,
    vehicle: Annotated[
        list[str] | None,
        typer.Option(metavar="HOST:PORT", help="A vehicle that gets them without the server."),
    ] = None,
    rate_hz: Annotated[float, typer.Option("--rate", min=1.0, max=10.0, help="Reports per second.")] = 5.0,
    once: Annotated[bool, typer.Option(help="End with the video; otherwise it is opened again.")] = False,
) -> None:
    """Count the people on a crossing by its camera and report them to the server and to vehicles.

    Without --server and --vehicle the counts are only printed. If the video is absent, broken or at its end,
    the command says so and opens it again.
    """
    console = Console(soft_wrap=True, highlight=False)
    if server and not token:
        _refuse(console, "no developer token: set CAMPUSLOOP_TOKEN to what `campusloop token create` prints")
    try:
        opencv()
        ground, corners = _ground(point), _outline(road_map, outline, area)
        vehicles = [VehicleDatagrams(address) for address in vehicle or ()]
        tls = _trusted(certificate) if server.startswith("https") else None
    except (CameraLibraryMissing, MappingError, MapError, OSError, ValueError) as error:
        _refuse(console, str(error))
    link = ReportLink(server, token, tls, lambda text: console.print(text)) if server else None
    shown = _Shown(console)

    def put(report: PresenceReport) -> None:
        shown.put(report)
        for one in vehicles:
            one.put(report)
        if link is not None:
            link.put(report)

    watching = CrossingWatch(
        source, lambda: PeopleCounter(ground, corners), WatchOptions(area, rate_hz, once), put,
        lambda text: console.print(text),
    )  # fmt: skip
    try:
        asyncio.run(_run(watching, link))
    except VideoFailure as failure:
        console.print(f"{failure}; {watching.reports} reports")
        if not failure.has_ended:
            raise typer.Exit(EXIT_FAILED) from failure
    except KeyboardInterrupt:
        console.print(f"{watching.reports} reports")


async def _run(watching: CrossingWatch, link: ReportLink | None) -> None:
    """Both tasks; when one ends with an error, so does the command."""
    tasks = [asyncio.create_task(watching.run())]
    if link is not None:
        tasks.append(asyncio.create_task(link.run()))
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for task in done:
            task.result()
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


class _Shown:
    """Prints a count when it changes."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._count: int | None = None

    def put(self, report: PresenceReport) -> None:
        if report.count != self._count:
            self._count = report.count
            self._console.print(f"{report.area_id}: {report.count} people, {1e3 * report.age_s:.0f} ms old")


def _ground(points: list[str]) -> GroundPixels:
    rows = [_row(text, 4, "--point", "U,V=X,Y") for text in points]
    return GroundPixels([(row[0], row[1]) for row in rows], [(row[2], row[3]) for row in rows])


def _outline(road_map: Path | None, outline: str, area: str) -> Array:
    """(n, 2). Raises MapError, ValueError."""
    if outline:
        corners = np.array([_row(text, 2, "--outline", "X,Y") for text in outline.split()])
        if len(corners) < 3:
            raise ValueError("--outline needs three or more corners")
        return corners
    if road_map is None:
        raise ValueError("give --map with the area, or its --outline")
    areas = {one.area_id: one for one in load_map(road_map).observation_areas}
    if area not in areas:
        raise ValueError(
            f"{road_map} has no observation area {area}; it has {', '.join(sorted(areas)) or 'none'}"
        )
    return outline_array(areas[area])


def _row(text: str, size: int, option: str, form: str) -> list[float]:
    try:
        row = [float(part) for part in _NUMBERS.split(text.strip())]
    except ValueError as error:
        raise ValueError(f"{option} {text}: give {form} in numbers") from error
    if len(row) != size or not np.isfinite(row).all():
        raise ValueError(f"{option} {text}: give {form}")
    return row


def _trusted(certificate: Path | None) -> ssl.SSLContext:
    return ssl.create_default_context(cafile=None if certificate is None else str(certificate))


def _refuse(console: Console, detail: str) -> NoReturn:
    console.print(f"[red]{escape(detail)}[/red]")
    raise typer.Exit(EXIT_BAD_INPUT)

"""`campusloop demo`: a campus on this machine, live or in virtual time."""

import asyncio
import logging
from pathlib import Path
from typing import Annotated
from zoneinfo import ZoneInfo

import structlog
import typer
from rich.console import Console
from rich.markup import escape

from campusloop.commands.filming import FilmingError, check_cameras
from campusloop.commands.localizing import Localization, chosen_point_map, chosen_profile
from campusloop.commands.perceiving import Perception, perceiving_profile, tell_lacks
from campusloop.kernels.compiling import KernelError, prepare_kernels
from campusloop.kernels.groups import for_campus
from campusloop.live.campus import CampusStartError, LiveOptions
from campusloop.live.carried_shuttles import VEHICLES_MAX, carried, cores, pace, scan_cpu_s
from campusloop.live.demo import LiveDemo
from campusloop.live.run_folder import ForeignFolder, empty_folder
from campusloop.scenes.stacks import PROFILE_OF_STACK
from campusloop.shipped import DEFAULT_MAP, PROFILES
from campusloop.telemetry.journal_console import journal_console
from campusloop.telemetry.otlp_spans import TracingUnavailable
from contract.localization_maps import LocalizationMapError
from contract.roads.load import MapError, load_map
from simulator.sensors.scene_lidars import SceneOptions, scene_of_run
from vehicle_agent.config import Profile, ProfileError, load_profile
from vehicle_agent.perception.camera.people_detector import CameraLibraryMissing, opencv
from vehicle_agent.perception.pillars.detector_file import DetectorFileError
from vehicle_agent.runtime.screen.screen_settings import WEB_PAGES
from vehicle_agent.stacks.choice import worker_tracks

# Of tables in a file or pipe.
WIDTH_WITHOUT_TERMINAL = 120

HEADLESS = Path("var/headless")

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2


def demo(
    headless: Annotated[bool, typer.Option("--headless", help="Virtual time, as fast as possible.")] = False,
    rides: Annotated[int, typer.Option(min=1, help="How many rides (headless).")] = 6,
    seed: Annotated[int, typer.Option(help="Of people, noise and bookings.")] = 1,
    vehicles: Annotated[int, typer.Option(min=0, help="0: three, or as many as the machine carries.")] = 0,
    host: Annotated[str, typer.Option(help="0.0.0.0 serves phones on the LAN, with TLS.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="TCP port of the pages.")] = 8080,
    tls_cert: Annotated[Path | None, typer.Option(help="PEM certificate chain.")] = None,
    tls_key: Annotated[Path | None, typer.Option(help="PEM private key.")] = None,
    campus_map: Annotated[Path, typer.Option("--map", help="Campus map.")] = DEFAULT_MAP,
    folder: Annotated[
        Path | None,
        typer.Option(help="Where runs, logs and the database go; var/demo, headless var/headless (emptied)."),
    ] = None,
    people: Annotated[bool, typer.Option(help="Simulated passengers book rides.")] = True,
    profile: Annotated[
        Path | None,
        typer.Option(
            help="Vehicle profile (TOML). Without it Snow Lions that find road users by themselves (with "
            "--scene); headless, or with --perception, the campus shuttle."
        ),
    ] = None,
    plant_seed: Annotated[
        int | None, typer.Option(help="Of the shuttles' dynamics; nominal ones without it.")
    ] = None,
    scene: Annotated[
        bool,
        typer.Option("--scene", help="Hills, kerbs, trees, parked vehicles, and lidars that see them."),
    ] = False,
    localization: Annotated[
        Localization,
        typer.Option(help="gnss; or scans: the shuttles compare their lidar's scans with a point map."),
    ] = Localization.GNSS,
    point_map: Annotated[
        Path | None, typer.Option(help="For scans: folder of a point map; var/point-maps/CAMPUS without it.")
    ] = None,
    perception: Annotated[
        Perception | None,
        typer.Option(help="own: road users are found in the lidars' scans (needs --scene); tracker: given."),
    ] = None,
    campus_sky: Annotated[
        bool,
        typer.Option("--campus-sky", help="Headless: buildings hide satellites and reflect their signals."),
    ] = False,
    crossing_detector: Annotated[
        bool,
        typer.Option(
            "--crossing-detector",
            help="Headless: crossings' cameras count people in their pictures, in place of true counts.",
        ),
    ] = False,
    cameras: Annotated[
        bool,
        typer.Option("--cameras", help="Each shuttle records four cameras of the scene; wants another core."),
    ] = False,
    begin: Annotated[str, typer.Option("--from", help="Headless timetable from HH:MM, campus time.")] = "",
    end: Annotated[str, typer.Option("--to", help="... to HH:MM.")] = "",
) -> None:
    """Run a campus: book at the printed address, watch at /console."""
    console = Console() if headless else journal_console()
    if headless:
        if not console.is_terminal:
            console = Console(width=WIDTH_WITHOUT_TERMINAL)
        structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.ERROR))
    count = vehicles or (2 if cores() <= 2 else VEHICLES_MAX)
    sees_itself = (
        not headless and profile is None and perception is None and localization is Localization.GNSS
    )
    if sees_itself:
        profile, perception, scene = PROFILES / PROFILE_OF_STACK["snow_lion"], Perception.OWN, True
    try:
        profile = chosen_profile(localization, profile)
        kept = folder or (HEADLESS if headless else Path("var/demo"))
        profile = perceiving_profile(perception, profile, kept.parent, has_scene=scene)
        chosen = Profile() if profile is None else load_profile(profile)
        points = chosen_point_map(localization, point_map, campus_map, has_scene=scene, profile=profile)
        kernels = for_campus(chosen.stack, by_scans=points is not None, own_perception=worker_tracks(chosen))
        tell_lacks(console, chosen)
        if crossing_detector and not (headless and scene):
            raise CampusStartError("--crossing-detector is for --headless with --scene: it looks at pictures")
        if crossing_detector:
            _check_detector()
        prepare_kernels(kernels, console)
        if sees_itself:
            count = vehicles_that_see(console, chosen, vehicles)
        surroundings = scene_of_run(seed) if scene else None
        if cameras:
            if headless:
                raise CampusStartError("--cameras is for the demo in real time: leave out --headless")
            check_cameras(scene)
        if campus_sky and (not headless or begin):
            raise CampusStartError("--campus-sky is for the rides of --headless")
        if headless and begin and end:
            if points is not None:
                raise LocalizationMapError(
                    "a timetable's shuttles localize by gnss: leave out --localization"
                )
            _timetable(
                console, campus_map, count, seed, begin, end, folder or HEADLESS, plant_seed, surroundings
            )
            return
        if headless:
            _headless(
                console,
                campus_map,
                count,
                rides,
                seed,
                folder or HEADLESS,
                chosen,
                plant_seed,
                surroundings,
                points,
                campus_sky,
                crossing_detector,
            )
            return
        options = LiveOptions(
            campus_map,
            folder or Path("var/demo"),
            count,
            host,
            port,
            tls_cert,
            tls_key,
            seed,
            profile_path=profile,
            paced=True,
            plant_seed=plant_seed,
            scene=surroundings,
            point_map=points,
            screen_pages=WEB_PAGES if (WEB_PAGES / "onboard.html").is_file() else None,
            cameras=cameras,
        )
        asyncio.run(LiveDemo(options, console, people_book=people).run())
    except (
        MapError,
        LocalizationMapError,
        ProfileError,
        DetectorFileError,
        FilmingError,
        CampusStartError,
        ForeignFolder,
        KernelError,
        TracingUnavailable,
    ) as error:
        console.print(f"[red]{escape(str(error))}[/red]", soft_wrap=True, highlight=False)
        raise typer.Exit(EXIT_BAD_INPUT) from error


def vehicles_that_see(console: Console, profile: Profile, wanted: int) -> int:
    """How many shuttles find road users by themselves here: as many as wanted, or 0: as the machine carries.

    Tells how many, and how fast that is. Raises DetectorFileError.
    """
    scan_s = scan_cpu_s(profile)
    count = wanted or carried(cores(), scan_s)
    shuttles = (
        "1 shuttle finds road users in its" if count == 1 else f"{count} shuttles find road users in their"
    )
    console.print(
        f"{shuttles} own scans ({1e3 * scan_s:.0f} ms a scan on one of {cores()} cores): "
        f"about {pace(count, cores(), scan_s):.1f} of real time",
        highlight=False,
    )
    if not wanted and count < VEHICLES_MAX:
        console.print("for more shuttles: --vehicles 3, slower, or --perception tracker", highlight=False)
    return count


def _check_detector() -> None:
    try:
        opencv()
    except CameraLibraryMissing as error:
        raise CampusStartError(str(error)) from error


def _timetable(
    console: Console,
    campus_map: Path,
    vehicles: int,
    seed: int,
    begin: str,
    end: str,
    folder: Path,
    plant_seed: int | None,
    scene: SceneOptions | None,
) -> None:
    # Imported here, because they import the whole server, which is another process in the live demo.
    from campusloop.virtual.campus import CampusOptions
    from campusloop.virtual.timetable_run import local_moment, run_timetable

    road_map = load_map(campus_map)
    zone = ZoneInfo(road_map.timezone)
    if not road_map.timetable:
        console.print(f"[red]{escape(road_map.name)} has no timetable[/red]; try maps/snow-lion/map.json")
        raise typer.Exit(EXIT_BAD_INPUT)
    options = CampusOptions(road_map, folder, seed, vehicles, plant_seed=plant_seed, scene=scene)
    try:
        begins, ends = (local_moment(options.begins, moment, zone) for moment in (begin, end))
    except ValueError as error:
        console.print(f"[red]{escape(str(error))}[/red]; give times as HH:MM")
        raise typer.Exit(EXIT_BAD_INPUT) from error
    empty_folder(folder)
    calls, failures = run_timetable(options, begins, ends, console)
    for failure in failures:
        console.print(f"[red]{escape(str(failure))}[/red]", soft_wrap=True, highlight=False)
    if failures:
        raise typer.Exit(EXIT_FAILED)
    console.print(f"all {len(calls)} calls were on time, every run replays exactly; the runs are in {folder}")


def _headless(
    console: Console,
    campus_map: Path,
    vehicles: int,
    rides: int,
    seed: int,
    folder: Path,
    profile: Profile,
    plant_seed: int | None,
    scene: SceneOptions | None,
    point_map: Path | None,
    campus_sky: bool,
    crossing_detector: bool,
) -> None:
    from campusloop.virtual.campus import CampusOptions
    from campusloop.virtual.headless import run_headless

    road_map = load_map(campus_map)
    options = CampusOptions(
        road_map,
        empty_folder(folder),
        seed,
        vehicles,
        profile,
        plant_seed=plant_seed,
        scene=scene,
        point_map=point_map,
        campus_sky=campus_sky,
        crossing_detector=crossing_detector,
    )
    result = run_headless(options, rides, console)
    for failure in result.failures:
        console.print(f"[red]{escape(str(failure))}[/red]", soft_wrap=True, highlight=False)
    if result.failures:
        raise typer.Exit(EXIT_FAILED)
    console.print(f"all {rides} rides completed, every run replays exactly; the runs are in {folder}")

"""`campusloop shuttles`: simulated shuttles, with their real agents, for a server that runs elsewhere."""

import asyncio
import os
import signal
import ssl
import time
from pathlib import Path
from typing import Annotated, NoReturn

import httpx
import typer
from rich.markup import escape

from campusloop.clients.operator_client import OperatorClient, OperatorError
from campusloop.commands.filming import FilmingError, check_cameras
from campusloop.commands.localizing import Localization, chosen_point_map, chosen_profile
from campusloop.commands.perceiving import Perception, perceiving_profile, tell_lacks
from campusloop.kernels.compiling import KernelError, prepare_kernels
from campusloop.kernels.groups import SIMULATOR, for_vehicle
from campusloop.live.shuttles import ShuttleOptions, SimulatedShuttles
from campusloop.shipped import DEFAULT_MAP
from campusloop.telemetry.journal_console import journal_console
from campusloop.telemetry.otlp_spans import TracingUnavailable
from contract.localization_maps import LocalizationMapError
from contract.roads.load import MapError
from server.settings import SettingsError, settings_from
from simulator.live.ports import BASE_PORT
from simulator.sensors.scene_lidars import scene_of_run
from vehicle_agent.config import Profile, ProfileError, load_profile
from vehicle_agent.runtime.processes.supervisor import CHECK_EVERY_S
from vehicle_agent.stacks.choice import worker_tracks

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2
PASSWORD = "CAMPUSLOOP_OPERATOR_PASSWORD"
POLL_EVERY_S = 1.0
REQUEST_TIMEOUT_S = 30.0

console = journal_console()


def shuttles(
    server: Annotated[str, typer.Option(help="The server's address, https://HOST:PORT.")],
    count: Annotated[int, typer.Option(min=1, max=20, help="How many shuttles.")] = 2,
    campus_map: Annotated[Path, typer.Option("--map", help="Campus map, the server's.")] = DEFAULT_MAP,
    folder: Annotated[Path, typer.Option(help="Keys, runs and logs; kept for the next start.")] = Path(
        "var/shuttles"
    ),
    operator: Annotated[str, typer.Option(help=f"Who enrols them; the password is {PASSWORD}.")] = "operator",
    certificate: Annotated[
        Path | None, typer.Option(help="PEM certificate that is trusted besides the system's.")
    ] = None,
    profile: Annotated[
        Path | None, typer.Option(help="Vehicle profile (TOML); the campus shuttle without it.")
    ] = None,
    held: Annotated[bool, typer.Option("--held", help="Leave it to the console to resume them.")] = False,
    people: Annotated[bool, typer.Option(help="Pedestrians around the shuttles.")] = True,
    seed: Annotated[int, typer.Option(help="Of noise and people.")] = 1,
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
    cameras: Annotated[
        bool,
        typer.Option("--cameras", help="Each shuttle records four cameras of the scene; wants another core."),
    ] = False,
    base_port: Annotated[int, typer.Option(help="First of the loopback ports used.")] = BASE_PORT,
    wait_s: Annotated[float, typer.Option(min=0.0, help="How long the server may take to be ready.")] = 120.0,
) -> None:
    """Run simulated shuttles until Ctrl-C: bodies, sensors and people are simulated, agents are real."""
    try:
        password = settings_from(os.environ).operator_password
        if not password:
            _refuse(f"set {PASSWORD}, or {PASSWORD}_FILE to a file with it: the password of {operator}")
        profile = chosen_profile(localization, profile)
        profile = perceiving_profile(perception, profile, folder, has_scene=scene)
        points = chosen_point_map(localization, point_map, campus_map, has_scene=scene, profile=profile)
        chosen = Profile() if profile is None else load_profile(profile)
        kernels = for_vehicle(chosen.stack, by_scans=points is not None, own_perception=worker_tracks(chosen))
        tell_lacks(console, chosen)
        if cameras:
            check_cameras(scene)
        prepare_kernels((*SIMULATOR, *kernels), console)
        options = ShuttleOptions(
            map_path=campus_map.absolute(),
            folder=folder.absolute(),
            vehicle_ids=tuple(f"shuttle-{number + 1}" for number in range(count)),
            server_url=server.rstrip("/"),
            server_certificate=None if certificate is None else certificate.absolute(),
            seed=seed,
            base_port=base_port,
            pedestrians=people,
            profile_path=None if profile is None else profile.absolute(),
            plant_seed=plant_seed,
            scene=scene_of_run(seed) if scene else None,
            point_map=points,
            cameras=cameras,
        )
        trusted = True if certificate is None else ssl.create_default_context(cafile=certificate)
        simulated = SimulatedShuttles(options)
    except (
        SettingsError,
        MapError,
        LocalizationMapError,
        ProfileError,
        FilmingError,
        KernelError,
        TracingUnavailable,
        OSError,
    ) as error:
        _refuse(str(error))
    raise typer.Exit(asyncio.run(_run(simulated, operator, password, trusted, held, wait_s)))


async def _run(
    simulated: SimulatedShuttles,
    name: str,
    password: str,
    trusted: ssl.SSLContext | bool,
    held: bool,
    wait_s: float,
) -> int:
    """The exit code."""
    stopped = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, stopped.set)
    url = simulated.options.server_url
    async with httpx.AsyncClient(base_url=url, verify=trusted, timeout=REQUEST_TIMEOUT_S) as client:
        try:
            simulated.start_simulator()
            if not await _is_ready(client, wait_s, stopped):
                return 0 if stopped.is_set() else EXIT_FAILED
            await _drive(simulated, OperatorClient(client), name, password, held, stopped)
        except (OperatorError, httpx.HTTPError) as error:
            _say(f"[red]the server at {escape(url)} refused the shuttles:[/red] {escape(str(error))}")
            return EXIT_FAILED
        finally:
            _say("stopping")
            await simulated.stop()
    return 0


async def _drive(
    simulated: SimulatedShuttles,
    operator: OperatorClient,
    name: str,
    password: str,
    held: bool,
    stopped: asyncio.Event,
) -> None:
    """Until `stopped` is set. Raises OperatorError, httpx.HTTPError."""
    await operator.sign_in(name, password)
    await simulated.start_agents(operator)
    _say(
        f"{len(simulated.options.vehicle_ids)} shuttles are enrolled; "
        f"runs and logs: {simulated.options.folder}"
    )
    releasing = None if held else asyncio.create_task(simulated.release_all(operator))
    try:
        while not stopped.is_set():
            simulated.restart_ended()
            if releasing is not None and releasing.done():
                releasing.result()
                releasing = None
                _say("all shuttles drive")
            try:
                await asyncio.wait_for(stopped.wait(), CHECK_EVERY_S)
            except TimeoutError:
                continue
    finally:
        if releasing is not None:
            releasing.cancel()
            await asyncio.gather(releasing, return_exceptions=True)


async def _is_ready(client: httpx.AsyncClient, wait_s: float, stopped: asyncio.Event) -> bool:
    """True as soon as the server is ready; False after `wait_s`, or when `stopped` is set."""
    begun_s = time.monotonic()
    reason = ""
    while time.monotonic() - begun_s < wait_s and not stopped.is_set():
        try:
            answer = await client.get("/api/v1/ready")
            if answer.is_success:
                return True
            reason = f"it is not ready: {answer.text[:500]}"
        except httpx.TransportError as error:
            reason = str(error) or type(error).__name__
        await asyncio.sleep(POLL_EVERY_S)
    if not stopped.is_set():
        _say(
            f"[red]no server was ready at {escape(str(client.base_url))} within {wait_s:g} s:[/red] "
            f"{escape(reason)}"
        )
    return False


def _say(text: str) -> None:
    console.print(text, highlight=False, soft_wrap=True)


def _refuse(reason: str) -> NoReturn:
    journal_console(level="error").print(f"[red]campusloop shuttles:[/red] {escape(reason)}", soft_wrap=True)
    raise typer.Exit(EXIT_BAD_INPUT)

"""`campusloop agent`: the agent on a vehicle, from enrolment to driving."""

import tempfile
from pathlib import Path
from typing import Annotated, NoReturn

import httpx
import typer
from rich.console import Console
from rich.markup import escape

from campusloop.kernels.compiling import ensure_kernels
from campusloop.kernels.groups import for_vehicle
from campusloop.telemetry.journal_console import journal_console
from campusloop.telemetry.otlp_spans import TracingUnavailable, span_source
from contract.localization_maps import LocalizationMapError
from contract.roads.load import MapError, load_map
from contract.roads.model import RoadMap
from vehicle_agent.config import Profile, ProfileError, load_profile
from vehicle_agent.link.keys import VehicleKeyError, load_or_create_key, public_key_text
from vehicle_agent.perception.pillars.detector_file import DetectorFileError
from vehicle_agent.receivers.gnss_receiver import GnssReceiver, ReceiverError
from vehicle_agent.runtime.devices.hmi_devices import HmiDeviceError, output_devices
from vehicle_agent.runtime.processes.agent import AgentPlace
from vehicle_agent.runtime.processes.agent_files import AgentFolder, AgentFolderError, VehicleFile
from vehicle_agent.runtime.processes.agent_jobs import agent_jobs
from vehicle_agent.runtime.processes.supervisor import Supervisor
from vehicle_agent.runtime.screen.screen_settings import ScreenError
from vehicle_agent.runtime.sensors.sensors_file import SensorsError
from vehicle_agent.runtime.video.cameras_file import CamerasError
from vehicle_agent.stacks.choice import check_localizes_by_scans, checked_localization_map, worker_tracks
from vehicle_agent.stacks.own_perception import tracks_worker

app = typer.Typer(no_args_is_help=True)
console = Console()

EXIT_BAD_INPUT = 2
START_ERRORS = (
    AgentFolderError,
    DetectorFileError,
    ProfileError,
    MapError,
    LocalizationMapError,
    HmiDeviceError,
    ReceiverError,
    ScreenError,
    SensorsError,
    CamerasError,
    TracingUnavailable,
)


@app.command()
def enrol(
    folder: Annotated[Path, typer.Argument(help="The vehicle's folder; created if it does not exist.")],
    server: Annotated[str, typer.Option(help="The server's address, e.g. https://shuttles.campus.edu")],
    vehicle_id: Annotated[str, typer.Option(help="As named on the console.")],
    code: Annotated[str, typer.Option(help="The enrolment code from the console; works once.")],
    campus_map: Annotated[Path, typer.Option("--map", help="The campus map that the server uses.")],
    can: Annotated[str, typer.Option(help="SocketCAN interface, or udp:ADDRESS:PORT in simulation.")],
    scan_ring: Annotated[Path, typer.Option(help="File through which the lidar driver hands over scans.")],
    profile: Annotated[Path | None, typer.Option(help="Vehicle profile (TOML).")] = None,
    values_port: Annotated[int, typer.Option(help="Loopback port of device values.")] = 47_300,
    scans_port: Annotated[int, typer.Option(help="Loopback port of finished scans.")] = 47_400,
    hmi_port: Annotated[int, typer.Option(help="Loopback port of screen, speaker and doors.")] = 47_500,
    cameras: Annotated[
        str, typer.Option(help="HOST:PORT to receive crossing cameras on, without the cloud.")
    ] = "",
    certificate: Annotated[
        str, typer.Option(help="Certificate to trust, if the server's is self-signed.")
    ] = "",
    point_map: Annotated[
        Path | None, typer.Option(help="Point map to compare the lidar's scans with (folder); copied.")
    ] = None,
    by_scans: Annotated[
        bool, typer.Option(help="Compare scans with the localization map that the server has in force.")
    ] = False,
) -> None:
    """Create the vehicle's key and enrol it with the server, once."""
    vehicle = VehicleFile(
        vehicle_id=vehicle_id,
        server_url=server.rstrip("/"),
        can_channel=can,
        values_port=values_port,
        scans_port=scans_port,
        hmi_port=hmi_port,
        scan_ring=str(scan_ring),
        server_certificate=certificate,
        cameras=cameras,
        by_scans=by_scans,
    )
    try:
        road_map = load_map(campus_map)
        chosen = Profile() if profile is None else load_profile(profile)
        if by_scans:
            check_localizes_by_scans(chosen)
        if point_map is not None:
            _check_point_map(point_map, road_map, chosen)
        key = load_or_create_key(folder / "key.pem")
    except (MapError, LocalizationMapError, ProfileError, VehicleKeyError) as error:
        _refuse(str(error))
    body = {"code": code, "vehicle_id": vehicle_id, "public_key": public_key_text(key)}
    try:
        verify = certificate or True
        answer = httpx.post(f"{vehicle.server_url}/api/v1/enrolments", json=body, verify=verify, timeout=30)
    except httpx.TransportError as error:
        _refuse(f"{vehicle.server_url} does not answer ({error}); is the address right, is the server up?")
    if answer.is_error:
        problem = answer.json()
        _refuse(f"{problem.get('title')}: {problem.get('detail')}")
    files = AgentFolder(folder)
    files.prepare(vehicle, campus_map, profile)
    if point_map is not None:
        files.install_point_map(point_map)
    console.print(f"{vehicle_id} is enrolled. Start it with: campusloop agent run {folder}")


@app.command("point-map")
def give_point_map(
    folder: Annotated[Path, typer.Argument(help="The vehicle's folder, after `enrol`.")],
    point_map: Annotated[Path, typer.Argument(help="Folder of a point map (docs/workshop/mapping.md).")],
) -> None:
    """Give an enrolled vehicle a point map, or another one; it is used from the next start on."""
    files = AgentFolder(folder)
    try:
        check_localizes_by_scans(files.profile())
        index = files.install_point_map(point_map)
    except (MapError, LocalizationMapError, ProfileError) as error:
        _refuse(str(error))
    except OSError as error:
        _refuse(f"{folder} cannot be written: {error.strerror or error}; the vehicle keeps what it has")
    console.print(f"{folder.name} has the point map {index.map_version[:12]} with {len(index.tiles)} tiles")


@app.command()
def run(
    folders: Annotated[
        list[Path], typer.Argument(help="A folder for each vehicle; several share their workers.")
    ],
) -> None:
    """Run the agent's processes until SIGTERM or Ctrl-C, and restart those that end."""
    try:
        for folder in folders:
            files = AgentFolder(folder)
            files.vehicle()
            profile = files.profile()
            if worker_tracks(profile):
                # A detector that cannot be run would end the worker again and again, and the vehicle stand.
                tracks_worker(profile)
            files.road_map()
            files.screen()
            sensors = files.sensors()
            if sensors is not None and sensors.file.receivers:
                # Says now what to install, and not from a process that ends again and again.
                GnssReceiver()
            if files.checked_point_map() is not None or files.vehicle().by_scans:
                check_localizes_by_scans(files.profile())
            hmi_devices = files.hmi_devices()
            for device in output_devices(hmi_devices) if hmi_devices is not None else ():
                device.close()
        profiles = [AgentFolder(folder).profile() for folder in folders]
        by_scans = any(AgentFolder(folder).localizes_by() is not None for folder in folders)
        groups = {
            group
            for one in profiles
            for group in for_vehicle(one.stack, by_scans=by_scans, own_perception=worker_tracks(one))
        }
        ensure_kernels(tuple(sorted(groups)))
        with tempfile.TemporaryDirectory(prefix="campusloop-") as mail:
            spans = span_source()
            places = tuple(
                AgentPlace(folder.resolve(), Path(mail) / str(number), spans=spans)
                for number, folder in enumerate(folders)
            )
            jobs = agent_jobs(places)
            journal_console().print(f"driving {', '.join(folder.name for folder in folders)}; Ctrl-C ends it")
            Supervisor(jobs).run()
    except START_ERRORS as error:
        _refuse(str(error), journal_console(level="error"))


def _check_point_map(point_map: Path, road_map: RoadMap, profile: Profile) -> None:
    """Raises LocalizationMapError, ProfileError."""
    check_localizes_by_scans(profile)
    checked_localization_map(profile, point_map, road_map.origin)


def _refuse(detail: str, console: Console = console) -> NoReturn:
    console.print(f"[red]{escape(detail)}[/red]", soft_wrap=True, highlight=False)
    raise typer.Exit(EXIT_BAD_INPUT)

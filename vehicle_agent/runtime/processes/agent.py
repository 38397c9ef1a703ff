"""A vehicle's processes and how they are connected.

One vehicle has a tick, a gate, a worker and a link process. Simulated vehicles on one machine share one link
process, and one worker if it looks for no road users; each keeps a tick and a gate of its own
(`agent_jobs.py`).
"""

import asyncio
import signal
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import msgspec
import structlog

from contract.roads.load import encode_map
from contract.roads.model import RoadMap
from contract.runlog.records import RunHeader
from contract.tracing import NO_SPANS, Spans, SpanSource
from contract.wire.messages import LATER_KINDS, SCANS_REQUESTED
from vehicle_agent.device_feed import (
    DatagramPort,
    DeviceOutputs,
    DeviceSensors,
    people_ring_path,
    planar_ring_path,
)
from vehicle_agent.link.keys import code_key
from vehicle_agent.link.outbox import read_memory
from vehicle_agent.link.session import Identity
from vehicle_agent.localization.scan_map.stored_map import is_of_place
from vehicle_agent.localization.worker import LocalizationWorker, NoMap
from vehicle_agent.mission.memory import MissionMemory, order_progress
from vehicle_agent.onboard.car import Car, initial_state
from vehicle_agent.picture_ring import PEOPLE_CAMERA, picture_ring_path
from vehicle_agent.runtime.code_mask import CodeMask
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.devices.hmi_devices import HmiDeviceProcess
from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.runtime.processes.clock import MONOTONIC, Clock, ClockSource
from vehicle_agent.runtime.processes.gate_process import GateProcess
from vehicle_agent.runtime.processes.link.camera_link import CameraLink, SensorsAndCameras
from vehicle_agent.runtime.processes.link.link_process import LinkedVehicle, serve_links
from vehicle_agent.runtime.processes.maps.localization_process import LocalizationProcess
from vehicle_agent.runtime.processes.maps.localization_switch import LocalizationSwitch
from vehicle_agent.runtime.processes.maps.map_switch import MapSwitch
from vehicle_agent.runtime.processes.planner_process import PlannerProcess
from vehicle_agent.runtime.processes.screen_process import ScreenProcess
from vehicle_agent.runtime.processes.sensing.lidar_process import LidarProcess
from vehicle_agent.runtime.processes.sensing.people_camera_process import (
    PeopleCameraProcess,
    serve_people_camera,
)
from vehicle_agent.runtime.processes.sensing.receiver_process import ReceiverProcess
from vehicle_agent.runtime.processes.sensing.scan_process import ScanningVehicle, serve_scans
from vehicle_agent.runtime.processes.sensing.scanner_process import PlacedScanner, ScannerProcess
from vehicle_agent.runtime.processes.sensing.video_process import serve_video
from vehicle_agent.runtime.processes.sensing.worker_process import ScannedVehicle, serve_percepts
from vehicle_agent.runtime.processes.tick_process import CabinReporter, Sensors, TickProcess
from vehicle_agent.runtime.processes.until_stopped import run_until_stopped
from vehicle_agent.runtime.recording.recorder import Recorder
from vehicle_agent.runtime.room_times import TickStopwatch
from vehicle_agent.runtime.screen.screen_map import encode_screen_map
from vehicle_agent.runtime.screen.screen_pages import ScreenFile, read_screen_files
from vehicle_agent.signals import HmiOutput
from vehicle_agent.stacks.choice import (
    build_car,
    build_localization_worker,
    build_perception_worker,
    build_planner,
    perception_lacks,
    warm_localization,
    worker_tracks,
)
from vehicle_agent.stacks.warm import warm_tick

log = structlog.get_logger()

SOFTWARE = "0.1.0"


@dataclass(frozen=True, slots=True)
class AgentPlace:
    """folder: the vehicle's folder on disk; mail: the folder of its mailboxes (a short path).

    clock: the processes' clock; simulated vehicles on one machine may share one
    spans: of the processes; the link sends those of tick and gate
    """

    folder: Path
    mail: Path
    clock: ClockSource = MONOTONIC
    spans: SpanSource = NO_SPANS


def run_lidars(place: AgentPlace) -> None:
    files = AgentFolder(place.folder)
    vehicle, settings = files.vehicle(), files.sensors()
    assert settings is not None, "only vehicles with a sensors.toml have this process"
    with closing(place.clock.open(f"lidars {vehicle.vehicle_id}")) as clock:
        LidarProcess(
            settings.lidars, Path(vehicle.scan_ring), vehicle.scans_port, vehicle.values_port, clock
        ).run()


def run_receivers(place: AgentPlace) -> None:
    files = AgentFolder(place.folder)
    vehicle, settings = files.vehicle(), files.sensors()
    assert settings is not None, "only vehicles with a sensors.toml have this process"
    with closing(place.clock.open(f"receivers {vehicle.vehicle_id}")) as clock:
        run_until_stopped(ReceiverProcess(settings, vehicle.values_port, clock).run)


def run_scanners(place: AgentPlace) -> None:
    files = AgentFolder(place.folder)
    vehicle, settings, profile = files.vehicle(), files.sensors(), files.profile()
    assert settings is not None, "only vehicles with a sensors.toml have this process"
    ring = Path(vehicle.scan_ring)
    params = {
        "planar_scanner": (profile.planar_scanner, planar_ring_path(ring)),
        "people_scanner": (profile.people_scanner, people_ring_path(ring)),
    }
    with closing(place.clock.open(f"scanners {vehicle.vehicle_id}")) as clock:
        scanners = [PlacedScanner(name, *params[name]) for name in settings.scanners]
        run_until_stopped(ScannerProcess(scanners, settings.scanners, clock).run)


def run_people_camera(place: AgentPlace) -> None:
    files = AgentFolder(place.folder)
    vehicle, camera = files.vehicle(), files.people_camera()
    assert camera is not None, "only vehicles whose cameras.toml names one have this process"
    ring = picture_ring_path(Path(vehicle.scan_ring), PEOPLE_CAMERA)
    with closing(place.clock.open(f"camera {vehicle.vehicle_id}")) as clock:
        serve_people_camera(PeopleCameraProcess(camera, files.profile().camera, ring, clock))


def run_video(place: AgentPlace) -> None:
    files = AgentFolder(place.folder)
    settings = files.cameras()
    assert settings is not None, "only vehicles with a cameras.toml have this process"
    with closing(place.clock.open(f"video {files.vehicle().vehicle_id}")) as clock:
        serve_video(settings, files.video, clock, place.mail)


def run_gate(place: AgentPlace) -> None:
    files = AgentFolder(place.folder)
    vehicle = files.vehicle()
    with closing(place.clock.open(f"gate {vehicle.vehicle_id}")) as clock:
        GateProcess(place.mail, vehicle.can_channel, files.profile(), clock, _traced(place)).run()


def run_planner(place: AgentPlace) -> None:
    files = AgentFolder(place.folder)
    planner = build_planner(files.profile(), files.road_map())
    assert planner is not None, "only stacks that plan beside the tick have this process"
    with closing(place.clock.open(f"planner {files.vehicle().vehicle_id}")) as clock:
        PlannerProcess(place.mail, planner, clock).run()


def run_localization(place: AgentPlace) -> None:
    files = AgentFolder(place.folder)
    vehicle = files.vehicle()
    profile = files.profile()
    ring = Path(vehicle.scan_ring)
    if profile.stack == "nus":
        ring = planar_ring_path(ring)
    with closing(place.clock.open(f"localization {vehicle.vehicle_id}")) as clock:
        process = LocalizationProcess(place.mail, ring, partial(_localization_worker, files), clock)
        process.run(partial(warm_localization, profile))


def _localization_worker(files: AgentFolder) -> LocalizationWorker:
    """On the map in force, if it lies in the road map's frame."""
    folder = files.localization.in_force()
    if folder is None or not is_of_place(files.localization_index(folder), files.road_map().origin):
        return LocalizationWorker(NoMap())
    return build_localization_worker(files.profile(), folder)


def run_hmi_devices(place: AgentPlace) -> None:
    settings = AgentFolder(place.folder).hmi_devices()
    assert settings is not None, "only vehicles with a speaking.toml have this process"
    HmiDeviceProcess(settings).run()


def run_screen(place: AgentPlace) -> None:
    files = AgentFolder(place.folder)
    settings = files.screen()
    assert settings is not None, "only vehicles with a screen.toml have this process"
    vehicle_id = files.vehicle().vehicle_id
    seats = files.profile().body.seats

    def read_pages() -> dict[str, ScreenFile]:
        return read_screen_files(Path(settings.pages), vehicle_id, encode_screen_map(files.road_map()))

    with closing(place.clock.open(f"screen {vehicle_id}")) as clock:
        screen = ScreenProcess(place.mail, vehicle_id, seats, settings, read_pages, clock)
        asyncio.run(_serve_screen(screen))


async def _serve_screen(screen: ScreenProcess) -> None:
    """Until SIGTERM."""
    stop = asyncio.Event()
    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, stop.set)
    await screen.run(stop)


def run_worker(places: tuple[AgentPlace, ...], name: str = "worker") -> None:
    scanned = []
    for place in places:
        files = AgentFolder(place.folder)
        vehicle = files.vehicle()
        lacks = perception_lacks(files.profile())
        if lacks:
            log.warning("perception.lacks", vehicle_id=vehicle.vehicle_id, what=lacks)
        scanned.append(
            ScannedVehicle(
                vehicle.vehicle_id,
                place.mail,
                vehicle.scans_port,
                Path(vehicle.scan_ring),
                build_perception_worker(files.profile()),
            )
        )
    with closing(places[0].clock.open(name)) as clock:
        serve_percepts(tuple(scanned), clock)


def run_scans(places: tuple[AgentPlace, ...]) -> None:
    """Keeps scans that operators ask for; idle without a request."""
    vehicles = []
    for place in places:
        files = AgentFolder(place.folder)
        ring = Path(files.vehicle().scan_ring)
        vehicles.append(ScanningVehicle(place.folder, place.mail, ring, files.next_boot_id("scans")))
    with closing(places[0].clock.open("scans")) as clock:
        serve_scans(tuple(vehicles), clock)


def run_links(places: tuple[AgentPlace, ...]) -> None:
    clock = places[0].clock.open("link")
    spans = places[0].spans.open("link")
    asyncio.run(serve_links([_linked(place, clock, spans) for place in places]))
    if spans is not None:
        spans.close()


def run_tick(place: AgentPlace) -> None:
    """Runs the tick from a new boot: mission memory from disk, all other states initial."""
    files = AgentFolder(place.folder)
    vehicle, profile, road_map = files.vehicle(), files.profile(), files.road_map()
    by_scans = files.localizes_by() is not None
    scans = LocalizationSwitch(files, files.checked_point_map()) if by_scans else None

    def localization_map(road_map: RoadMap) -> str:
        return "" if scans is None else scans.version_on(road_map)

    def rooms_on(road_map: RoadMap) -> Car:
        return build_car(profile, road_map, localization_map(road_map))

    car = rooms_on(road_map)
    warm_tick(profile)
    state = initial_state(car)
    state = msgspec.structs.replace(state, mission=car.mission.initial(mission_memory(files)))
    clock = place.clock.open(f"tick {vehicle.vehicle_id}")
    offset_ns = clock.utc_offset_ns()

    def begin_run(road_map: RoadMap) -> Recorder:
        """A run has one map: when it changes, another run begins, as after a start."""
        header = RunHeader(
            vehicle_id=vehicle.vehicle_id,
            boot_id=files.next_boot_id(),
            segment=0,
            campus_id=road_map.campus_id,
            map_version=road_map.map_version,
            stack=profile.stack,
            software=SOFTWARE,
            utc_offset_ns=offset_ns,
            first_tick=0,
            localization_map=localization_map(road_map),
        )
        return Recorder(header, profile.body, road_map.observation_areas, profile.perception)

    computer = VehicleComputer(
        car, state, begin_run(road_map), offset_ns, TickStopwatch(), profile.perception
    )
    maps = MapSwitch(files, rooms_on, begin_run)
    if scans is not None:
        scans.on_change(begin_run)
    outputs_port = DatagramPort()
    hmi_devices = files.hmi_devices()
    ports = (vehicle.hmi_port,) if hmi_devices is None else (vehicle.hmi_port, hmi_devices.port)

    def show(hmi_output: HmiOutput) -> None:
        for port in ports:
            outputs_port.send(port, DeviceOutputs(hmi_output))

    devices, mask = DeviceSensors(vehicle.values_port), code_mask(files)
    has_screen = files.screen() is not None
    cabin = CabinReporter(profile.limits.speed_mps_max) if has_screen else None
    with closing(clock):
        if vehicle.cameras:
            inputs: Sensors = SensorsAndCameras(devices, CameraLink(vehicle.cameras, clock))
        else:
            inputs = devices
        TickProcess(
            place.mail,
            computer,
            inputs,
            show,
            clock,
            mask,
            _traced(place),
            cabin,
            maps,
            scans,
            worker_tracks=worker_tracks(profile),
        ).run()


def _traced(place: AgentPlace) -> str:
    """The vehicle, if its rides are traced."""
    return "" if place.spans == NO_SPANS else AgentFolder(place.folder).vehicle().vehicle_id


def _linked(place: AgentPlace, clock: Clock, spans: Spans | None) -> LinkedVehicle:
    """The link's parameters. Events belong to the link's own boot id; a killed link's events keep theirs."""
    files = AgentFolder(place.folder)
    vehicle, profile, road_map = files.vehicle(), files.profile(), files.road_map()
    identity = Identity(
        vehicle_id=vehicle.vehicle_id,
        boot_id=files.next_boot_id("link"),
        software=SOFTWARE,
        stack=profile.stack,
        map_version=road_map.map_version,
        seats=profile.body.seats,
        wheelchair_places=profile.body.wheelchair_places,
        understands=(*LATER_KINDS, SCANS_REQUESTED),
        localizes_by=files.localizes_by() or "",
    )
    return LinkedVehicle(
        folder=place.folder,
        mail=place.mail,
        identity=identity,
        profile=msgspec.msgpack.encode(profile),
        road_map=encode_map(road_map),
        progress=order_progress(mission_memory(files)),
        clock=clock,
        spans=spans,
    )


def mission_memory(files: AgentFolder) -> MissionMemory:
    """The mission's memory on disk; empty on the first boot."""
    data = read_memory(files.outbox)
    if data is None:
        return MissionMemory()
    return code_mask(files).masked_memory(msgspec.msgpack.decode(data, type=MissionMemory))


def code_mask(files: AgentFolder) -> CodeMask:
    return CodeMask(code_key(files.key()))

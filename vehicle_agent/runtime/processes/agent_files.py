"""A vehicle's folder: its identity, settings, and the state that survives a crash.

vehicle.toml      vehicle id, server, CAN channel, ports (written at enrolment)
profile.toml      the kind of vehicle
map.json          the campus map; map-VERSION.json one that was published, until the vehicle changes over
speaking.toml     screens and loudspeaker, if this computer drives them (see `hmi_devices`)
screen.toml       the onboard screen for passengers, if this computer serves one (see `screen_settings`)
sensors.toml      lidars and receivers, if this computer reads them itself (see `sensors_file`)
cameras.toml      cameras that are recorded, if there are (see `cameras_file`)
key.pem           the vehicle's key
point-map/        a map that scans are compared with, given by hand
localization-maps/  maps that scans are compared with, fetched from the server (see `localization_files`)
boot.count, link.count  numbers of starts of the tick and of the link
outbox/           events and mission memory
runs/BOOT/        run-log segments
video/            video segments, named by camera and time (see `segment_names`)
"""

import os
import shutil
from pathlib import Path

import msgspec
import structlog
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from contract.localization_manifest import LocalizationMapKind
from contract.localization_maps import LocalizationMapError
from contract.occupancy import tile_files as occupancy
from contract.occupancy.tile_files import OccupancyTilesIndex
from contract.point_map import map_files as points
from contract.point_map.map_files import INDEX, PointMapIndex
from contract.roads.load import load_map
from contract.roads.model import RoadMap
from vehicle_agent.config import Profile, load_profile
from vehicle_agent.link.keys import load_or_create_key
from vehicle_agent.runtime.devices.hmi_devices import HmiDeviceSettings, load_hmi_devices
from vehicle_agent.runtime.processes.maps.localization_files import LocalizationFiles
from vehicle_agent.runtime.screen.screen_settings import ScreenSettings, load_screen_settings
from vehicle_agent.runtime.sensors.sensors_file import SensorsError, SensorSettings, load_sensors
from vehicle_agent.runtime.video.cameras_file import CamerasError, VideoSettings, load_cameras
from vehicle_agent.runtime.video.people_camera import PeopleCamera
from vehicle_agent.stacks.choice import checked_localization_map, localization_kind

log = structlog.get_logger()


class AgentFolderError(Exception):
    """The vehicle's folder is not usable; the message says what to do."""


class VehicleFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An agent's settings.

    server_url          the server's address, e.g. https://shuttles.campus.edu
    can_channel         see `can_bus.open_bus`
    values_port         loopback port on which device values come (see `device_feed`)
    scans_port          loopback port on which finished scans are announced
    hmi_port            loopback port of screen, speaker and doors
    scan_ring           file with the scans
    cameras             HOST:PORT on this vehicle's own network for reports of crossing cameras, "" for none
    by_scans            compare scans with a map: the one that the server has in force, or one given by hand
    server_certificate  path of a certificate to trust, for a server with a self-signed one
    """

    vehicle_id: str
    server_url: str
    can_channel: str
    values_port: int
    scans_port: int
    hmi_port: int
    scan_ring: str
    server_certificate: str = ""
    cameras: str = ""
    by_scans: bool = False


class AgentFolder:
    """Paths and small files of one vehicle."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.outbox = root / "outbox"
        self.runs = root / "runs"
        self.scans = root / "scans"
        self.video = root / "video"
        self.localization = LocalizationFiles(root)

    def vehicle(self) -> VehicleFile:
        path = self.root / "vehicle.toml"
        try:
            return msgspec.toml.decode(path.read_bytes(), type=VehicleFile)
        except FileNotFoundError as error:
            raise AgentFolderError(
                f"{self.root} is not a vehicle's folder yet: run `campusloop agent enrol` for it"
            ) from error
        except msgspec.DecodeError as error:
            raise AgentFolderError(f"{path}: {error}") from error

    def save_vehicle(self, vehicle: VehicleFile) -> None:
        self._save("vehicle.toml", vehicle)

    def save_screen(self, settings: ScreenSettings) -> None:
        self._save("screen.toml", settings)

    def save_cameras(self, text: str) -> None:
        """text: of cameras.toml. One that is there, written by hand perhaps, stays."""
        path = self.root / "cameras.toml"
        self.root.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            path.write_text(text)

    def remove_cameras(self, text: str) -> None:
        """Removes cameras.toml if it is this text; any other stays."""
        path = self.root / "cameras.toml"
        if path.is_file() and path.read_text() == text:
            path.unlink()

    def _save(self, name: str, settings: VehicleFile | ScreenSettings) -> None:
        self.root.mkdir(parents=True, exist_ok=True)
        fields = msgspec.to_builtins(settings)
        lines = [f"{field} = {msgspec.json.encode(value).decode()}" for field, value in fields.items()]
        (self.root / name).write_text("\n".join(lines) + "\n")

    def prepare(self, vehicle: VehicleFile, campus_map: Path, profile: Path | None) -> None:
        """Writes everything that an agent needs except its key and a point map."""
        self.save_vehicle(vehicle)
        shutil.copyfile(campus_map, self.root / "map.json")
        if profile is not None:
            shutil.copyfile(profile, self.root / "profile.toml")

    def profile(self) -> Profile:
        path = self.root / "profile.toml"
        return load_profile(path) if path.exists() else Profile()

    def hmi_devices(self) -> HmiDeviceSettings | None:
        """Raises HmiDeviceError."""
        return load_hmi_devices(self.root / "speaking.toml")

    def screen(self) -> ScreenSettings | None:
        """Raises ScreenError."""
        return load_screen_settings(self.root / "screen.toml")

    def sensors(self) -> SensorSettings | None:
        """Raises SensorsError, also for a scanner that the profile does not have."""
        path = self.root / "sensors.toml"
        settings = load_sensors(path)
        for name in settings.scanners if settings is not None else ():
            profile = self.profile()
            if getattr(profile, name).rate_hz <= 0.0:
                raise SensorsError(f"{path}: {profile.name} has no [{name}]: its rate_hz is 0")
        return settings

    def cameras(self) -> VideoSettings | None:
        """Of the cameras that are recorded; None without any. Raises CamerasError."""
        settings = self._cameras()
        return settings if settings is not None and settings.cameras else None

    def people_camera(self) -> PeopleCamera | None:
        """Raises CamerasError, also for a profile without a camera."""
        settings = self._cameras()
        if settings is None or settings.people is None:
            return None
        profile = self.profile()
        if profile.camera.rate_hz <= 0.0:
            raise CamerasError(
                f"{self.root / 'cameras.toml'}: {profile.name} has no [camera]: its rate_hz is 0"
            )
        return settings.people

    def _cameras(self) -> VideoSettings | None:
        return load_cameras(self.root / "cameras.toml", Path(self.vehicle().scan_ring))

    def road_map(self) -> RoadMap:
        """Raises MapError."""
        return load_map(self.root / "map.json")

    def map_bytes(self) -> bytes:
        """The campus map as it lies on the disk. Raises OSError."""
        return (self.root / "map.json").read_bytes()

    def install_point_map(self, source: Path) -> PointMapIndex | OccupancyTilesIndex:
        """Copies a point map beside the campus map, which is there; the one before is replaced as a whole.

        Raises LocalizationMapError for a damaged map, one of another place or kind, OSError.
        """
        index = checked_localization_map(self.profile(), source, self.road_map().origin)
        point_map = self.localization.by_hand
        fresh, old = self.root / ".point-map.new", self.root / ".point-map.old"
        for folder in (fresh, old):
            shutil.rmtree(folder, ignore_errors=True)
        fresh.mkdir(parents=True)
        shutil.copyfile(source / INDEX, fresh / INDEX)
        for entry in index.tiles:
            (fresh / entry.file).parent.mkdir(exist_ok=True)
            shutil.copyfile(source / entry.file, fresh / entry.file)
        if point_map.exists():
            point_map.rename(old)
        fresh.rename(point_map)
        self.localization.forget()
        shutil.rmtree(old, ignore_errors=True)
        return index

    def remove_point_map(self) -> None:
        """From the next start on the vehicle has GNSS/INS alone."""
        shutil.rmtree(self.localization.by_hand, ignore_errors=True)
        shutil.rmtree(self.localization.root, ignore_errors=True)

    def localizes_by(self) -> LocalizationMapKind | None:
        """The kind of map that scans are compared with; None for GNSS/INS alone. Raises AgentFolderError."""
        is_asked = self.vehicle().by_scans or self.localization.in_force() is not None
        return localization_kind(self.profile().stack) if is_asked else None

    def localization_index(self, folder: Path) -> PointMapIndex | OccupancyTilesIndex:
        """The index of a map of the stack's kind; its tiles are not read. Raises LocalizationMapError."""
        if localization_kind(self.profile().stack) == "occupancy":
            return occupancy.read_index(folder)
        return points.read_index(folder)

    def checked_point_map(self) -> PointMapIndex | OccupancyTilesIndex | None:
        """The index of the map that scans are compared with, every tile checked; None if there is none.

        A fetched map that is damaged is removed, and the server sends it again.
        Raises LocalizationMapError for one that was given by hand, MapError.
        """
        folder = self.localization.in_force()
        if folder is None:
            return None
        profile, road_map = self.profile(), self.road_map()
        if self.localization.is_fetched():
            try:
                return checked_localization_map(profile, folder, road_map.origin)
            except LocalizationMapError as error:
                log.error("localization_map.damaged", folder=str(folder), error=str(error))
                self.localization.discard_in_force()
                return self.checked_point_map()
        return checked_localization_map(profile, folder, road_map.origin)

    def save_next_map(self, map_version: str, data: bytes) -> None:
        """Writes a checked map beside the present one; others that wait there are gone.

        Raises OSError, e.g. for a full disk; then nothing of it is left.
        """
        path = self._next_map(map_version)
        for other in self.root.glob("map-*.json"):
            other.unlink()
        try:
            with path.open("wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
        except OSError:
            path.unlink(missing_ok=True)
            raise

    def next_map(self, map_version: str) -> RoadMap:
        """Raises MapError."""
        return load_map(self._next_map(map_version))

    def adopt_next_map(self, map_version: str) -> None:
        """From now on it is the campus map. Needs no room on the disk. Raises OSError."""
        self._next_map(map_version).replace(self.root / "map.json")
        folder = os.open(self.root, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)

    def _next_map(self, map_version: str) -> Path:
        return self.root / f"map-{map_version}.json"

    def key(self) -> Ed25519PrivateKey:
        return load_or_create_key(self.root / "key.pem")

    def next_boot_id(self, who: str = "boot") -> str:
        """A new id for every start of the tick ("boot") or of the link ("link"), in order."""
        path = self.root / f"{who}.count"
        number = int(path.read_text()) + 1 if path.exists() else 1
        fresh = path.with_suffix(".new")
        fresh.write_text(str(number))
        fresh.replace(path)
        return f"{who}-{number:06d}"

"""sensors.toml: the sensors of a vehicle, where they are on it, and how they are reached.

Places are in the vehicle's frame: from the middle of the rear axle on the ground, x forward, y left, z up.
Angles are in degrees, about its fixed axes x, y, z in this order, as `workshop calibrate` writes them.
"""

import math
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np

from contract.geometry import Array
from contract.transforms import transform_of
from vehicle_agent.lidar.angle_file import AngleFileError, with_angle_file
from vehicle_agent.lidar.models import MODELS, LidarModel
from vehicle_agent.runtime.sensors.addresses import Address, AddressError, address_of
from vehicle_agent.runtime.sensors.ntrip import Caster, caster_of


class SensorsError(Exception):
    """sensors.toml cannot be used; the message says what to do."""


class Place(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Of a sensor on the vehicle, metres and degrees."""

    x_m: float
    y_m: float
    z_m: float
    roll_deg: float = 0.0
    pitch_deg: float = 0.0
    yaw_deg: float = 0.0

    def transform(self) -> Array:
        """(4, 4) T_base_sensor."""
        roll_rad, pitch_rad, yaw_rad = np.radians([self.roll_deg, self.pitch_deg, self.yaw_deg])
        return transform_of(roll_rad, pitch_rad, yaw_rad, np.array([self.x_m, self.y_m, self.z_m]))


class LidarEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """listen    udp:PORT, to which the lidar sends
    place     T_base_sensor of the frame in which its maker gives points; without it from `extrinsics`
    model     as in `campusloop sensors check`; needed with `angles`, else the packets tell
    angles    a Hesai's own file of angles, beside this file
    required  without it the vehicle stops
    """

    listen: str
    place: Place | None = None
    model: str = ""
    angles: str = ""
    required: bool = True


class ReceiverEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """source   a device (/dev/ttyACM0), tcp:HOST:PORT or udp:PORT
    baud     of a device; 0: as it is set
    place    of the antenna; its yaw is that of the direction from the first to the second antenna
    """

    source: str
    place: Place
    baud: int = 0


class InertialEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A VectorNav; place as above, of a frame with x forward, y left, z up on the sensor.

    gives  samples alone, or also the position that the sensor reckons
    """

    source: str
    place: Place
    baud: int = 0
    gives: Literal["samples", "samples and position"] = "samples"


class ScannerEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A planar scanner that talks CoLa A (SICK LMS1xx, TiM5xx); its place is in the profile.

    source   tcp:HOST:PORT
    """

    source: str


class CorrectionsEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Corrections (RTCM) of an NTRIP caster for one receiver.

    url            http(s)://HOST:PORT/MOUNTPOINT
    user, password_file  the file lies beside this one, readable by the agent's user only
    to             the receiver's name
    tell_place     the caster is told where the vehicle is, for a virtual reference station
    """

    url: str
    to: str
    user: str = ""
    password_file: str = ""
    tell_place: bool = False


class SensorsFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """extrinsics  a file of `workshop calibrate`, beside this one: lidars without a place are placed by it,
    from its reference lidar, whose place is here
    planar_scanner, people_scanner  of the tables with these names in the profile"""

    lidars: dict[str, LidarEntry] = {}
    receivers: dict[str, ReceiverEntry] = {}
    inertial: dict[str, InertialEntry] = {}
    planar_scanner: ScannerEntry | None = None
    people_scanner: ScannerEntry | None = None
    corrections: CorrectionsEntry | None = None
    extrinsics: str = ""


class PlacedLidar(msgspec.Struct, frozen=True):
    """model: None where the packets tell."""

    name: str
    port: int
    T_base_sensor: Array
    model: LidarModel | None
    is_required: bool


class SensorSettings(msgspec.Struct, frozen=True):
    """A sensors.toml that was checked.

    addresses  of receivers and inertial sensors, by name
    scanners   addresses of planar scanners, by their names in the profile
    caster     of the corrections, None without them
    """

    file: SensorsFile
    lidars: tuple[PlacedLidar, ...]
    addresses: dict[str, Address]
    scanners: dict[str, Address] = {}
    caster: Caster | None = None


def load_sensors(path: Path) -> SensorSettings | None:
    """The settings; None without the file: other processes give scans and values. Raises SensorsError."""
    try:
        file = msgspec.toml.decode(path.read_bytes(), type=SensorsFile)
    except FileNotFoundError:
        return None
    except (msgspec.DecodeError, OSError) as error:
        raise SensorsError(f"{path}: {error}") from error
    try:
        return _checked(file, path.parent)
    except (AddressError, AngleFileError, OSError, UnicodeDecodeError, ValueError) as error:
        raise SensorsError(f"{path}: {error}") from error


def _checked(file: SensorsFile, folder: Path) -> SensorSettings:
    scanners = _scanners(file)
    if not (file.lidars or file.receivers or file.inertial or scanners):
        raise ValueError("it names no sensor")
    if repeated := set(file.receivers) & set(file.inertial):
        raise ValueError(f"{', '.join(sorted(repeated))}: a receiver and an inertial sensor have one name")
    lidars = _lidars(file, folder)
    ports = [lidar.port for lidar in lidars]
    others: list[tuple[str, ReceiverEntry | InertialEntry]] = [
        *file.receivers.items(),
        *file.inertial.items(),
    ]
    addresses = {name: address_of(name, entry.source, entry.baud) for name, entry in others}
    ports += [address.port for address in addresses.values() if address.kind == "udp"]
    if len(set(ports)) < len(ports):
        raise ValueError("two sensors have the same UDP port")
    _check_finite(entry.place for _, entry in others)
    caster = None
    if file.corrections is not None:
        if file.corrections.to not in file.receivers:
            raise ValueError(f"corrections are for {file.corrections.to!r}, which is no receiver here")
        if addresses[file.corrections.to].kind == "udp":
            raise ValueError("corrections need a receiver that can be written to: a device or tcp:HOST:PORT")
        secret = file.corrections.password_file
        password = (folder / secret).read_text().strip() if secret else ""
        caster = caster_of(file.corrections.url, file.corrections.user, password)
    return SensorSettings(file, lidars, addresses, scanners, caster)


def _scanners(file: SensorsFile) -> dict[str, Address]:
    entries = {"planar_scanner": file.planar_scanner, "people_scanner": file.people_scanner}
    found = {name: address_of(name, entry.source) for name, entry in entries.items() if entry is not None}
    for name, address in found.items():
        if address.kind != "tcp":
            raise ValueError(f"{name}: a planar scanner is reached by tcp:HOST:PORT")
    if len({(address.host, address.port) for address in found.values()}) < len(found):
        raise ValueError("planar_scanner and people_scanner have the same address")
    return found


def _lidars(file: SensorsFile, folder: Path) -> tuple[PlacedLidar, ...]:
    _check_finite(entry.place for entry in file.lidars.values() if entry.place is not None)
    calibrated = _calibrated(file, folder)
    placed = []
    for name, entry in file.lidars.items():
        if entry.place is not None:
            pose = entry.place.transform()
        elif name in calibrated:
            pose = calibrated[name]
        else:
            raise ValueError(f"lidar {name} has no place, here or in the extrinsics")
        address = address_of(name, entry.listen)
        if address.kind != "udp":
            raise ValueError(f"lidar {name}: give udp:PORT instead of {entry.listen!r}")
        placed.append(PlacedLidar(name, address.port, pose, _model(name, entry, folder), entry.required))
    return tuple(placed)


def _calibrated(file: SensorsFile, folder: Path) -> dict[str, Array]:
    """T_base_sensor of the lidars in the file of extrinsics."""
    if not file.extrinsics:
        return {}
    read = tomllib.loads((folder / file.extrinsics).read_text(encoding="utf-8"))
    try:
        reference = str(read["reference"])
        own = {
            name: Place(*(float(values[key]) for key in Place.__struct_fields__)).transform()
            for name, values in read["lidars"].items()
        }
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{file.extrinsics} is no file of `workshop calibrate` ({error})") from error
    entry = file.lidars.get(reference)
    if entry is None or entry.place is None:
        raise ValueError(f"the extrinsics' reference, {reference}, needs a place here")
    found = {name: entry.place.transform() @ pose for name, pose in own.items()}
    if not all(np.isfinite(pose).all() for pose in found.values()):
        raise ValueError(f"{file.extrinsics}: a pose is not finite")
    return found


def _model(name: str, entry: LidarEntry, folder: Path) -> LidarModel | None:
    if not entry.model:
        if entry.angles:
            raise ValueError(f"lidar {name}: angles need a model")
        return None
    known = {model.name.casefold(): model for model in MODELS.values()}
    model = known.get(entry.model.casefold())
    if model is None:
        raise ValueError(f"lidar {name}: no model {entry.model!r}; there are: {', '.join(MODELS)}")
    if not entry.angles:
        return model
    return with_angle_file(model, (folder / entry.angles).read_text(encoding="utf-8-sig"))


def _check_finite(places: Iterable[Place]) -> None:
    for place in places:
        if not all(math.isfinite(getattr(place, name)) for name in Place.__struct_fields__):
            raise ValueError("a place has a value that is not finite")

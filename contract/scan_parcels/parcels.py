"""One parcel: lidar scans of a piece of one drive, with the fixes and poses of that time, in one file.

A parcel is a ZIP file, so that any tool opens it:

  parcel.json   `ParcelHeader`
  fixes.csv     stamp_s,latitude_deg,longitude_deg,position_std_m   of the rear axle's centre
  poses.csv     stamp_s,x_m,y_m,yaw_rad,speed_mps                   the vehicle's own estimate, map frame
  scans/        NNNNNNNNNNNNNNNNNNN.pcd, named by the stamp in ns; `pcd.py`

Points are in the vehicle's base frame (x forward, y left, z up, from the rear axle's centre). Stamps are the
vehicle's clock. `campusloop workshop map` reads the folder that `unpack` makes (`--clouds`), and its fixes
(`--gnss`).
"""

import json
import re
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import numpy as np

from contract.roads.model import Origin
from contract.scan_parcels.pcd import PcdError, encoded_points, points_in
from contract.wire.bounds import Id

FORMAT = 1
HEADER, FIXES, POSES, SCANS = "parcel.json", "fixes.csv", "poses.csv", "scans"
FIX_COLUMNS = "stamp_s,latitude_deg,longitude_deg,position_std_m"
POSE_COLUMNS = "stamp_s,x_m,y_m,yaw_rad,speed_mps"
# A vehicle ends a parcel long before.
SCANS_MAX = 2_000
MEMBER_BYTES_MAX = 16 * 1024 * 1024
UNPACKED_BYTES_MAX = 1024 * 1024 * 1024
_SCAN_NAME = re.compile(r"scans/(\d{19})\.pcd")
# Equal content gives equal bytes.
_DATE = (1980, 1, 1, 0, 0, 0)

Positive = Annotated[int, msgspec.Meta(ge=1)]
Stamp = Annotated[int, msgspec.Meta(ge=0, le=(1 << 63) - 1)]


class ParcelError(Exception):
    """The file is no parcel that can be used; the message is one sentence."""


class ParcelHeader(msgspec.Struct, frozen=True):
    """What is in a parcel, and where it comes from.

    drive_id   the vehicle's way through the area without a gap; `number` counts its parcels from 0
    origin     of the map frame by which the vehicle drove, and the versions of its maps; "" for no point map
    way_m      driven between the first scan and the last
    first_ns, last_ns  stamps of the scans, the vehicle's clock
    """

    format: int
    request_id: Id
    vehicle_id: Id
    campus_id: Id
    drive_id: Id
    number: Annotated[int, msgspec.Meta(ge=0)]
    origin: Origin
    map_version: str
    localization_map: str
    scans: Annotated[int, msgspec.Meta(ge=1, le=SCANS_MAX)]
    way_m: Annotated[float, msgspec.Meta(ge=0.0, le=1e6)]
    first_ns: Stamp
    last_ns: Stamp
    frame: Literal["base"] = "base"


class FixRow(msgspec.Struct, frozen=True, array_like=True):
    """A GNSS fix, moved to the rear axle's centre by the receiver's driver."""

    stamp_ns: int
    latitude_deg: float
    longitude_deg: float
    position_std_m: float


class PoseRow(msgspec.Struct, frozen=True, array_like=True):
    """The vehicle's estimate of its pose, map frame."""

    stamp_ns: int
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float


class ParcelWriter:
    """Writes one parcel. Without `finish` the file is no parcel. Raises OSError."""

    def __init__(self, path: Path) -> None:
        self._zip = zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1)

    def add_scan(self, stamp_ns: int, points_base: np.ndarray, offsets_s: np.ndarray | None = None) -> int:
        """points_base: (n, 3), metres; offsets_s (n,) of each after the first, whose time is the stamp.

        How many bytes the file has now.
        """
        return self._write(f"{SCANS}/{stamp_ns:019d}.pcd", encoded_points(points_base, offsets_s))

    def finish(self, header: ParcelHeader, fixes: Sequence[FixRow], poses: Sequence[PoseRow]) -> None:
        lines = [f"{f.stamp_ns / 1e9:.6f},{f.latitude_deg:.9f},{f.longitude_deg:.9f},{f.position_std_m:.4f}"
                 for f in fixes]  # fmt: skip
        self._write(FIXES, "\n".join([FIX_COLUMNS, *lines, ""]).encode())
        lines = [
            f"{p.stamp_ns / 1e9:.6f},{p.x_m:.4f},{p.y_m:.4f},{p.yaw_rad:.5f},{p.speed_mps:.3f}" for p in poses
        ]
        self._write(POSES, "\n".join([POSE_COLUMNS, *lines, ""]).encode())
        self._write(HEADER, msgspec.json.format(msgspec.json.encode(header), indent=1))
        self._zip.close()

    def abandon(self) -> None:
        """Closes the file; what is in it is no parcel."""
        self._zip.close()

    def _write(self, name: str, data: bytes) -> int:
        member = zipfile.ZipInfo(name, _DATE)
        member.compress_type = zipfile.ZIP_DEFLATED
        self._zip.writestr(member, data)
        return int(self._zip.start_dir)


def read_header(path: Path) -> ParcelHeader:
    """The header of a parcel, without a look at its scans. Raises ParcelError, OSError."""
    with _opened(path) as file:
        return _header(file)


def checked_parcel(path: Path) -> ParcelHeader:
    """The header of a parcel of which everything was read and is sound. Raises ParcelError, OSError."""
    with _opened(path) as file:
        header = _header(file)
        stamps = []
        for member in file.infolist():
            found = _SCAN_NAME.fullmatch(member.filename)
            if found is None:
                if member.filename not in (HEADER, FIXES, POSES):
                    raise ParcelError(f"{member.filename} does not belong into a parcel.")
                continue
            try:
                points_in(_read(file, member.filename))
            except PcdError as error:
                raise ParcelError(f"{member.filename}: {error}") from error
            stamps.append(int(found[1]))
        if len(stamps) != header.scans:
            raise ParcelError(f"{len(stamps)} scans are in it, and it says {header.scans}.")
        if (min(stamps), max(stamps)) != (header.first_ns, header.last_ns):
            raise ParcelError("its scans are of another time than it says.")
        for name, columns in ((FIXES, FIX_COLUMNS), (POSES, POSE_COLUMNS)):
            if _read(file, name).split(b"\n", 1)[0] != columns.encode():
                raise ParcelError(f"{name} does not begin with {columns}.")
        return header


def unpack(path: Path, folder: Path) -> ParcelHeader:
    """Writes scans, fixes and poses into a folder: those of one drive's parcels go into one.

    Raises ParcelError, OSError.
    """
    header = checked_parcel(path)
    (folder / SCANS).mkdir(parents=True, exist_ok=True)
    with _opened(path) as file:
        for member in file.infolist():
            if _SCAN_NAME.fullmatch(member.filename):
                (folder / member.filename).write_bytes(_read(file, member.filename))
        for name in (FIXES, POSES):
            first, _, rest = _read(file, name).partition(b"\n")
            with (folder / name).open("ab") as out:
                out.write(rest if out.tell() else first + b"\n" + rest)
    return header


def _opened(path: Path) -> zipfile.ZipFile:
    try:
        file = zipfile.ZipFile(path)
    except zipfile.BadZipFile as error:
        raise ParcelError(f"it is no ZIP file, or is cut off: {error}.") from error
    members = file.infolist()
    sizes = [member.file_size for member in members]
    if (
        len(members) > SCANS_MAX + 3
        or max(sizes, default=0) > MEMBER_BYTES_MAX
        or sum(sizes) > UNPACKED_BYTES_MAX
    ):
        file.close()
        raise ParcelError("it holds more than a parcel may.")
    if len({member.filename for member in members}) != len(members):
        file.close()
        raise ParcelError("a name is in it twice.")
    return file


def _header(file: zipfile.ZipFile) -> ParcelHeader:
    data = _read(file, HEADER)
    try:
        version = json.loads(data).get("format")
        if version != FORMAT:
            raise ParcelError(f"{HEADER} has format {version}, not {FORMAT}.")
        return msgspec.json.decode(data, type=ParcelHeader)
    except (msgspec.MsgspecError, ValueError, AttributeError) as error:
        raise ParcelError(f"{HEADER} is no header of a parcel: {error}.") from error


def _read(file: zipfile.ZipFile, name: str) -> bytes:
    try:
        with file.open(name) as member:
            # What a member says of its size is checked against what it holds.
            data = member.read(MEMBER_BYTES_MAX + 1)
    except KeyError as error:
        raise ParcelError(f"it has no {name}.") from error
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise ParcelError(f"{name} is damaged: {error}.") from error
    if len(data) > MEMBER_BYTES_MAX:
        raise ParcelError(f"{name} holds more than a parcel may.")
    return data

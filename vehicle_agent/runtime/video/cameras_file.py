"""cameras.toml: the cameras of a vehicle that are recorded, and how each is reached."""

import re
from pathlib import Path
from typing import Annotated, Literal
from urllib.parse import quote, urlsplit

import msgspec

from contract.video import CAMERA
from vehicle_agent.picture_ring import PEOPLE_CAMERA, picture_ring_path

CAMERAS_MAX = 8
_DEVICE = re.compile(r"/dev/video\d{1,3}$")

Upload = Literal["asked", "all", "never"]
Blur = Literal["whole", "none"]
Size = Annotated[int, msgspec.Meta(ge=64, le=1920, multiple_of=2)]


class CamerasError(Exception):
    """cameras.toml cannot be used; the message says what to do."""


class CameraEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """source   /dev/videoN, rtsp://HOST/PATH, a video file (played again and again), or "ring": a process
             writes pictures into the ring beside the scan ring, as the simulator does
    turned   the camera hangs upside down
    user, password_file  of an RTSP camera; the file lies beside this one
    """

    source: str
    width_px: Size = 640
    height_px: Size = 480
    rate_hz: Annotated[float, msgspec.Meta(ge=1.0, le=30.0)] = 10.0
    kbps: Annotated[int, msgspec.Meta(ge=50, le=20_000)] = 800
    turned: bool = False
    user: str = ""
    password_file: str = ""


class CamerasFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """segment_s  of one file
    keep_gib   of all segments; the oldest is deleted for the newest
    upload     "asked": what lies in recordings and around marks of operators; "all"; "never"
    blur       "whole": pictures that leave the vehicle are so coarse that they show no face and no plate;
               "none": they leave as they are
    """

    cameras: dict[str, CameraEntry]
    segment_s: Annotated[int, msgspec.Meta(ge=5, le=300)] = 60
    keep_gib: Annotated[float, msgspec.Meta(ge=0.001, le=10_000.0)] = 20.0
    upload: Upload = "asked"
    blur: Blur = "whole"


class RecordedCamera(msgspec.Struct, frozen=True):
    """address: what is opened, with its password; never logged."""

    name: str
    entry: CameraEntry
    address: str


class VideoSettings(msgspec.Struct, frozen=True):
    """A cameras.toml that was checked."""

    cameras: tuple[RecordedCamera, ...]
    segment_s: int = 60
    keep_gib: float = 20.0
    upload: Upload = "asked"
    blur: Blur = "whole"


def load_cameras(path: Path, scan_ring: Path) -> VideoSettings | None:
    """The settings; None without the file: no video is recorded. Raises CamerasError."""
    try:
        file = msgspec.toml.decode(path.read_bytes(), type=CamerasFile)
        cameras = tuple(
            RecordedCamera(name, entry, _address(name, entry, path.parent, scan_ring))
            for name, entry in file.cameras.items()
        )
        if not 0 < len(cameras) <= CAMERAS_MAX:
            raise ValueError(f"it names {len(cameras)} cameras; 1 to {CAMERAS_MAX} are recorded")
        if len({camera.address for camera in cameras}) < len(cameras):
            raise ValueError("two cameras have the same source")
    except FileNotFoundError as error:
        if error.filename == str(path):
            return None
        raise CamerasError(f"{path}: {error}") from error
    except (msgspec.DecodeError, OSError, ValueError) as error:
        raise CamerasError(f"{path}: {error}") from error
    return VideoSettings(cameras, file.segment_s, file.keep_gib, file.upload, file.blur)


def _address(name: str, entry: CameraEntry, folder: Path, scan_ring: Path) -> str:
    if re.fullmatch(CAMERA, name) is None:
        raise ValueError(f"camera {name!r}: a name has small letters, digits and _, and begins with a letter")
    if entry.source == "ring":
        if name == PEOPLE_CAMERA:
            raise ValueError(
                f"camera {name}: this ring is of the profile's [camera], and sharp only where people are "
                "looked for; choose another name"
            )
        return str(picture_ring_path(scan_ring, name))
    if _DEVICE.match(entry.source):
        return entry.source
    if "://" not in entry.source:
        return str(folder / entry.source)
    parts = urlsplit(entry.source)
    if parts.scheme != "rtsp" or not parts.hostname:
        raise ValueError(
            f"camera {name}: {entry.source!r} is none of /dev/videoN, rtsp://HOST/PATH, a file, ring"
        )
    if parts.username or parts.password:
        raise ValueError(f"camera {name}: give user and password_file instead of a password in the URL")
    if not entry.user:
        return entry.source
    password = (folder / entry.password_file).read_text().strip() if entry.password_file else ""
    return entry.source.replace("://", f"://{quote(entry.user, '')}:{quote(password, '')}@", 1)

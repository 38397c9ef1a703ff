"""cameras.toml: the cameras of a vehicle, those that are recorded and the one that looks for people."""

import re
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from contract.video import CAMERA
from vehicle_agent.perception.camera.lens import LensError
from vehicle_agent.picture_ring import PEOPLE_CAMERA, picture_ring_path
from vehicle_agent.runtime.video.camera_addresses import Size, camera_address
from vehicle_agent.runtime.video.people_camera import PeopleCamera, PeopleCameraEntry, people_camera_of

CAMERAS_MAX = 8

Upload = Literal["asked", "all", "never"]
Blur = Literal["whole", "none"]


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
    """cameras    that are recorded. people_camera: of the profile's [camera]
    segment_s  of one file
    keep_gib   of all segments; the oldest is deleted for the newest
    upload     "asked": what lies in recordings and around marks of operators; "all"; "never"
    blur       "whole": pictures that leave the vehicle are so coarse that they show no face and no plate;
               "none": they leave as they are
    """

    cameras: dict[str, CameraEntry] = {}
    people_camera: PeopleCameraEntry | None = None
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
    """A cameras.toml that was checked; without cameras nothing is recorded."""

    cameras: tuple[RecordedCamera, ...]
    segment_s: int = 60
    keep_gib: float = 20.0
    upload: Upload = "asked"
    blur: Blur = "whole"
    people: PeopleCamera | None = None


def load_cameras(path: Path, scan_ring: Path) -> VideoSettings | None:
    """The settings; None without the file. Raises CamerasError."""
    try:
        file = msgspec.toml.decode(path.read_bytes(), type=CamerasFile)
        cameras = tuple(
            RecordedCamera(name, entry, _address(name, entry, path.parent, scan_ring))
            for name, entry in file.cameras.items()
        )
        people = None if file.people_camera is None else people_camera_of(file.people_camera, path.parent)
        if len(cameras) > CAMERAS_MAX or not (cameras or people):
            raise ValueError(f"it names {len(cameras)} cameras; 1 to {CAMERAS_MAX} are recorded")
        addresses = [camera.address for camera in cameras] + ([people.address] if people else [])
        if len(set(addresses)) < len(addresses):
            raise ValueError("two cameras have the same source")
    except FileNotFoundError as error:
        if error.filename == str(path):
            return None
        raise CamerasError(f"{path}: {error}") from error
    except (msgspec.DecodeError, LensError, OSError, ValueError) as error:
        raise CamerasError(f"{path}: {error}") from error
    return VideoSettings(cameras, file.segment_s, file.keep_gib, file.upload, file.blur, people)


def _address(name: str, entry: CameraEntry, folder: Path, scan_ring: Path) -> str:
    if re.fullmatch(CAMERA, name) is None:
        raise ValueError(f"camera {name!r}: a name has small letters, digits and _, and begins with a letter")
    if entry.source != "ring":
        return camera_address(f"camera {name}", entry.source, folder, entry.user, entry.password_file)
    if name == PEOPLE_CAMERA:
        raise ValueError(
            f"camera {name}: this ring is of the profile's [camera], and sharp only where people are "
            "looked for; choose another name"
        )
    return str(picture_ring_path(scan_ring, name))

"""The camera that looks for people, in cameras.toml: where it is, and its lens. Nothing of it is recorded."""

from pathlib import Path
from typing import Annotated

import msgspec

from vehicle_agent.perception.camera.lens import Lens, load_lens
from vehicle_agent.runtime.video.camera_addresses import Size, camera_address


class PeopleCameraEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The camera of the profile's [camera], which has its place.

    source   /dev/videoN, rtsp://HOST/PATH, or a video file beside this one (played again and again)
    width_px, height_px, rate_hz  that a device is asked for; turned: the camera hangs upside down
    calibration  a file of `workshop calibrate-camera`, beside this one; empty: pictures have no distortion,
                 and the size and field of the profile
    latency_ms   from the moment of a picture to its arrival
    """

    source: str
    width_px: Size = 640
    height_px: Size = 480
    rate_hz: Annotated[float, msgspec.Meta(ge=1.0, le=30.0)] = 30.0
    turned: bool = False
    user: str = ""
    password_file: str = ""
    calibration: str = ""
    latency_ms: Annotated[float, msgspec.Meta(ge=0.0, le=500.0)] = 0.0


class PeopleCamera(msgspec.Struct, frozen=True):
    """address: what is opened, with its password; never logged. lens: None without distortion."""

    entry: PeopleCameraEntry
    address: str
    lens: Lens | None


def people_camera_of(entry: PeopleCameraEntry, folder: Path) -> PeopleCamera:
    """folder: of the files that it names. Raises ValueError, OSError, LensError."""
    if entry.source == "ring":
        raise ValueError("people_camera: without this table another process writes into its ring")
    address = camera_address("people_camera", entry.source, folder, entry.user, entry.password_file)
    return PeopleCamera(entry, address, load_lens(folder / entry.calibration) if entry.calibration else None)

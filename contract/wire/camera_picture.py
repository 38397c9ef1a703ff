"""A picture of one camera, on request: for an operator who wants to see what stands before the vehicle."""

from typing import Annotated, Literal

import msgspec

from contract.wire.base import Message
from contract.wire.bounds import Count, Id, LongText, StampNs

CAMERAS_SHOWN_MAX = 16
PICTURE_BYTES_MAX = 100_000

# "recording" to "failed": how it stands with the camera; pictures of a black and of a frozen one come, too.
# "no_cameras": the vehicle has none; "unknown_camera": none of that name; "private": nothing may leave it.
ShownCameraState = Literal[
    "recording",
    "black",
    "frozen",
    "no_picture",
    "disk_full",
    "failed",
    "no_cameras",
    "unknown_camera",
    "private",
]


class CameraPicture(Message, frozen=True, tag="camera_picture"):
    """What a camera sees, or why nothing comes of it.

    stamp_ns  of the picture, by the vehicle's monotonic clock, as in its run log
    cameras   the names of all that the vehicle has
    coarse    the vehicle shows no face and no plate: the picture is made of wide blocks
    jpeg      empty without a picture
    """

    epoch: Count
    stamp_ns: StampNs
    camera: Id
    state: ShownCameraState
    cameras: Annotated[tuple[Id, ...], msgspec.Meta(max_length=CAMERAS_SHOWN_MAX)] = ()
    detail: LongText = ""
    coarse: bool = False
    jpeg: Annotated[bytes, msgspec.Meta(max_length=PICTURE_BYTES_MAX)] = b""

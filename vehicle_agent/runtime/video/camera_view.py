"""Which cameras operators look at, and what they are sent."""

from collections.abc import Mapping

import msgspec

from contract.wire.camera_picture import CameraPicture
from vehicle_agent.runtime.video.camera_recorder import CameraRecorder

# Why no picture comes is said again after so long.
SAY_EVERY_NS = 1_000_000_000
CAMERAS_MAX = 16


class ShowCamera(msgspec.Struct, frozen=True, tag="show_camera"):
    """To the process that records video: send pictures of this camera until then; "" is the first one."""

    camera: str
    until_ns: int


class CameraShown(msgspec.Struct, frozen=True, tag="camera_shown"):
    """To the link: for the operators who look."""

    picture: CameraPicture


class CameraView:
    """Call `ask` for each request, and `news` some times a second."""

    def __init__(self, recorders: Mapping[str, CameraRecorder], *, is_private: bool, is_coarse: bool) -> None:
        """is_private: no picture may leave the vehicle. is_coarse: see `PictureTaker`."""
        self._recorders, self._is_private, self._is_coarse = recorders, is_private, is_coarse
        self._until_ns: dict[str, int] = {}
        self._sent_ns: dict[str, int] = {}
        self._said_ns: dict[str, int] = {}

    def ask(self, request: ShowCamera) -> None:
        camera = request.camera or next(iter(self._recorders))
        # Names that no camera has come from outside.
        if camera not in self._until_ns and len(self._until_ns) >= CAMERAS_MAX:
            return
        self._until_ns[camera] = request.until_ns
        self._said_ns.pop(camera, None)
        recorder = self._recorders.get(camera)
        if recorder is not None and not self._is_private:
            recorder.taker.until_ns = request.until_ns

    def news(self, now_ns: int) -> tuple[CameraPicture, ...]:
        """What has not been sent yet."""
        self._until_ns = {name: until_ns for name, until_ns in self._until_ns.items() if now_ns < until_ns}
        found = (self._of(name, now_ns) for name in self._until_ns)
        return tuple(picture for picture in found if picture is not None)

    def _of(self, camera: str, now_ns: int) -> CameraPicture | None:
        names, recorder = tuple(self._recorders), self._recorders.get(camera)
        if self._is_private:
            return self._said(CameraPicture(0, now_ns, camera, "private", names), now_ns)
        if recorder is None:
            return self._said(CameraPicture(0, now_ns, camera, "unknown_camera", names), now_ns)
        condition, taken = recorder.condition, recorder.taker.newest
        picture = CameraPicture(
            0, now_ns, camera, condition.state, names, condition.detail, coarse=self._is_coarse
        )
        if taken is not None and taken.stamp_ns != self._sent_ns.get(camera):
            self._sent_ns[camera] = taken.stamp_ns
            return msgspec.structs.replace(picture, stamp_ns=taken.stamp_ns, jpeg=taken.jpeg)
        # Of a camera that works the next picture is about to come.
        return None if condition.state == "recording" else self._said(picture, now_ns)

    def _said(self, picture: CameraPicture, now_ns: int) -> CameraPicture | None:
        said_ns = self._said_ns.get(picture.camera)
        if said_ns is not None and now_ns - said_ns < SAY_EVERY_NS:
            return None
        self._said_ns[picture.camera] = now_ns
        return picture

"""The camera that looks for people, on a real vehicle: its pictures, freed of the lens, into their ring.

Only the newest picture matters: what comes oftener than the profile looks is skipped. The camera is read in a
thread, for libraries that read cameras wait in them.
"""

import signal
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import structlog

from vehicle_agent.config import Camera
from vehicle_agent.perception.camera.lens import Pixels, Rectification
from vehicle_agent.picture_ring import PEOPLE_CAMERA, PictureRing
from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.video.cameras_file import CameraEntry, RecordedCamera
from vehicle_agent.runtime.video.people_camera import PeopleCamera
from vehicle_agent.runtime.video.sources import Source, SourceFailure, open_source
from vehicle_agent.signals.pictures import pinhole_matrix

log = structlog.get_logger()

RETRY_S = 1.0
# Less of the profile's picture is a lens of another camera, or a wrong field of view.
_SEEN_SHARE_MIN = 0.9


class PeopleCameraProcess:
    """Reads the camera in a thread; its pictures have the profile's size and field."""

    def __init__(
        self,
        camera: PeopleCamera,
        params: Camera,
        ring: Path,
        clock: Clock,
        open_camera: Callable[[RecordedCamera, Callable[[], int]], Source] = open_source,
    ) -> None:
        """Raises CameraLibraryMissing for a lens without OpenCV, and DeviceFeedError."""
        self._camera, self._params, self._clock, self._open = camera, params, clock, open_camera
        self._rectification: Rectification | None = None
        if camera.lens is not None:
            K = pinhole_matrix(params.width_px, params.height_px, params.field_rad)
            self._rectification = Rectification(camera.lens, K, params.width_px, params.height_px)
            share = self._rectification.seen_share()
            if share < _SEEN_SHARE_MIN:
                log.warning("camera.narrow_lens", seen_share=round(share, 2), field_rad=params.field_rad)
        self._ring = PictureRing(ring, create=True)
        self._latency_ns = round(1e6 * camera.entry.latency_ms)
        self._period_ns = round(1e9 / params.rate_hz)
        self._due_ns, self._state = 0, ""
        self._stop = threading.Event()

    def run(self) -> None:
        """Until `stop`."""
        while not self._stop.is_set():
            try:
                source = self._open(_as_recorded(self._camera), self._clock.now_ns)
                try:
                    self._follow(source)
                finally:
                    source.close()
            except SourceFailure as error:
                self._tell(str(error))
            self._stop.wait(RETRY_S)

    def stop(self) -> None:
        self._stop.set()

    def _follow(self, source: Source) -> None:
        """Raises SourceFailure."""
        while not self._stop.is_set():
            stamp_ns, frame, _missed, _damaged = source.read()
            if frame is None or stamp_ns < self._due_ns:
                continue
            picture = frame.to_ndarray(format="rgb24")
            try:
                pixels = self._straight(picture[::-1, ::-1] if self._camera.entry.turned else picture)
            except ValueError as error:
                raise SourceFailure(str(error)) from error
            # The next picture is the one nearest to its time, of a camera whose pictures jitter.
            self._due_ns = stamp_ns + self._period_ns * 3 // 4
            self._ring.write(stamp_ns - self._latency_ns, pixels)
            self._tell("")

    def _straight(self, picture: Pixels) -> Pixels:
        if self._rectification is not None:
            return self._rectification.pixels(np.ascontiguousarray(picture))
        width_px, height_px = self._params.width_px, self._params.height_px
        if picture.shape[:2] != (height_px, width_px):
            raise ValueError(
                f"pictures have {picture.shape[1]} x {picture.shape[0]} px, and the profile's [camera] "
                f"{width_px} x {height_px}; name a `calibration` of the lens"
            )
        return picture

    def _tell(self, state: str) -> None:
        """When it changes; empty: pictures come."""
        if state == self._state and state:
            return
        if state:
            log.warning("sensor.not_open", name="camera", error=state)
        elif self._state != "open":
            log.info("sensor.open", name="camera")
        self._state = state or "open"


def _as_recorded(camera: PeopleCamera) -> RecordedCamera:
    """As the library that opens recorded cameras takes one."""
    entry = camera.entry
    asked = CameraEntry(
        entry.source, width_px=entry.width_px, height_px=entry.height_px, rate_hz=entry.rate_hz
    )
    return RecordedCamera(PEOPLE_CAMERA, asked, camera.address)


def serve_people_camera(process: PeopleCameraProcess) -> None:
    """Until SIGTERM. A camera that hangs does not keep the process."""
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    reader = _Reader(process)
    reader.start()
    while not ended.wait(0.5):
        reader.check()
    process.stop()
    reader.join(1.0)


class _Reader(threading.Thread):
    """The camera's thread; what ends it ends the process, which its supervisor starts again."""

    def __init__(self, process: PeopleCameraProcess) -> None:
        super().__init__(name="camera for people", daemon=True)
        self._process = process
        self._failure: BaseException | None = None

    def run(self) -> None:
        try:
            self._process.run()
        except BaseException as error:  # handed over to the process's main thread
            self._failure = error
            raise

    def check(self) -> None:
        """Raises what ended the thread."""
        if self._failure is not None:
            raise self._failure

"""The planar scanner and the camera with which a vehicle looks for people, in the worker's process."""

from pathlib import Path

import structlog

from vehicle_agent.device_feed import DeviceFeedError, people_ring_path
from vehicle_agent.perception.people_worker import PeopleWorker
from vehicle_agent.picture_ring import PEOPLE_CAMERA, PictureRing, RingPicture, picture_ring_path
from vehicle_agent.picture_windows import PictureWindows, picture_windows_path
from vehicle_agent.runtime.processes.sensing.new_scans import NewScans
from vehicle_agent.signals.pictures import Picture

log = structlog.get_logger()

# A scanner or camera that is silent for so long is told of, once.
SILENT_NS = 1_000_000_000


class PeopleFeed:
    """What the drivers of both write beside the ring of the vehicle's lidar; `take` often: scans are short.

    Drivers may start later, or again. One that is silent is told of, and the other and the lidar go on.
    """

    def __init__(self, vehicle_id: str, worker: PeopleWorker, scan_ring: Path) -> None:
        self._vehicle_id, self._worker = vehicle_id, worker
        self._scans = NewScans(people_ring_path(scan_ring))
        self._pictures_path = picture_ring_path(scan_ring, PEOPLE_CAMERA)
        self._pictures: PictureRing | None = None
        self._windows: PictureWindows | None = None
        if worker.looks_at_pictures:
            self._windows = PictureWindows(picture_windows_path(scan_ring, PEOPLE_CAMERA), create=True)
        self._scanner, self._camera = _Silence("people_scanner"), _Silence("camera")
        self._is_refused = False

    def take(self, now_ns: int) -> None:
        """Takes the newest scan and picture, if they are new, and says which picture is wanted next."""
        ready = self._scans.peek()
        rows = None if ready is None else self._scans.take_rows(ready)
        if ready is not None and rows is not None:
            self._worker.planar(rows, ready.stamp_ns)
        self._scanner.note(self._vehicle_id, now_ns, heard=rows is not None)
        if self._windows is None:
            return
        picture = self._newest_picture()
        if picture is not None:
            self._worker.look(Picture(PEOPLE_CAMERA, picture.stamp_ns, picture.pixels))
        wanted = self._worker.windows(now_ns)
        self._windows.ask(wanted)
        self._camera.note(self._vehicle_id, now_ns, heard=picture is not None or wanted is None)

    def _newest_picture(self) -> RingPicture | None:
        """Older ones are skipped."""
        if self._pictures is None:
            try:
                self._pictures = PictureRing(self._pictures_path, create=False)
            except DeviceFeedError:
                # `_Silence` tells of it.
                return None
        newest = None
        while (picture := self._pictures.read()) is not None:
            newest = picture
        if newest is not None and newest.pixels.shape[:2] != self._worker.picture_px:
            if not self._is_refused:
                log.error(
                    "worker.picture_refused",
                    vehicle_id=self._vehicle_id,
                    rows_columns=newest.pixels.shape[:2],
                    profile=self._worker.picture_px,
                )
            self._is_refused = True
            return None
        return newest


class _Silence:
    """Tells once that a sensor is silent, and once that it is back."""

    def __init__(self, sensor: str) -> None:
        self._sensor, self._is_silent = sensor, False
        self._heard_ns: int | None = None

    def note(self, vehicle_id: str, now_ns: int, *, heard: bool) -> None:
        if heard and self._is_silent:
            log.info("worker.sensor_back", vehicle_id=vehicle_id, sensor=self._sensor)
        if heard or self._heard_ns is None:
            self._heard_ns, self._is_silent = now_ns, False
        elif not self._is_silent and now_ns - self._heard_ns > SILENT_NS:
            self._is_silent = True
            log.warning("worker.sensor_silent", vehicle_id=vehicle_id, sensor=self._sensor)

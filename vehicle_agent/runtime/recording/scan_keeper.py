"""All requests for scans of one vehicle: what the process that keeps scans does, without clock and mail."""

import shutil
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np

from contract.scan_parcels.parcels import FixRow, PoseRow
from contract.wire.scans import ScanArea, ScanState
from vehicle_agent.runtime.recording.scan_parcels import (
    PARCEL_BYTES,
    RequestKeeper,
    Totals,
    Track,
    VehicleFrame,
    kept_bytes,
    remove_unfinished,
)

# Parcels that wait for their upload take no more, and leave so much of the disk free for run logs and maps.
KEPT_BYTES_MAX = 2 * 1024 * 1024 * 1024
FREE_BYTES_MIN = 1024 * 1024 * 1024
SILENT_NS = 3_000_000_000
# The disk is looked at so often.
LOOK_NS = 2_000_000_000


class RequestReport(msgspec.Struct, frozen=True):
    """How it stands with a request on this vehicle."""

    request_id: str
    state: ScanState
    detail: str
    totals: Totals


class ScanKeeper:
    """Takes requests, track and scans; `reports` says what became of them."""

    def __init__(
        self,
        folder: Path,
        boot: str,
        frame: Callable[[], VehicleFrame],
        free_bytes: Callable[[Path], int] | None = None,
    ) -> None:
        """folder: of all parcels. boot: names this process. frame: by what the vehicle drives now."""
        self._folder = folder
        self._boot = boot
        self._read_frame = frame
        self._free_bytes = free_bytes or (lambda path: shutil.disk_usage(path).free)
        self._track = Track()
        self._keepers: dict[str, RequestKeeper] = {}
        self._over: list[RequestReport] = []
        self._seen_ns: int | None = None
        self._looked_ns = -LOOK_NS
        self._full = ""
        self._frame: VehicleFrame | None = None
        folder.mkdir(parents=True, exist_ok=True)
        remove_unfinished(folder)

    @property
    def is_busy(self) -> bool:
        return bool(self._keepers)

    def set_requests(self, areas: tuple[ScanArea, ...], now_ns: int) -> None:
        """All that are open. One that is missing has ended: what was kept of it stays for the upload."""
        wanted = {area.request_id: area for area in areas}
        for request_id in [name for name in self._keepers if name not in wanted]:
            keeper = self._keepers.pop(request_id)
            self._end(keeper)
            self._over.append(RequestReport(request_id, "ended", keeper.detail, keeper.totals))
        for request_id, area in wanted.items():
            if request_id not in self._keepers:
                folder = self._folder / request_id
                self._keepers[request_id] = RequestKeeper(area, folder, self._boot)
                self._seen_ns = now_ns if self._seen_ns is None else self._seen_ns
        if not self._keepers:
            self._seen_ns = None

    def add_track(self, poses: tuple[PoseRow, ...], fixes: tuple[FixRow, ...]) -> None:
        self._track.poses.extend(poses)
        self._track.fixes.extend(fixes)

    def is_wanted(self, stamp_ns: int, utc_ns: int) -> bool:
        """A scan of this time is worth copying. It notes that there is one. utc_ns: the time now."""
        self._seen_ns = stamp_ns
        pose = self._track.pose_at(stamp_ns)
        found = False
        for keeper in self._keepers.values():
            if pose is None:
                self._leave(keeper, "waiting")
            elif keeper.is_full or utc_ns >= keeper.area.until_ns:
                self._leave(keeper, "ended")
            elif not keeper.is_inside(pose):
                self._leave(keeper, "waiting")
            elif self._full:
                self._leave(keeper, "disk_full", self._full)
            elif keeper.is_wanted(pose):
                found = True
        return found

    def take(self, stamp_ns: int, rows: np.ndarray, utc_ns: int) -> None:
        """Keeps a scan, (n, 5) as in the scan ring, for every request that wants it."""
        pose = self._track.pose_at(stamp_ns)
        if pose is None:
            return
        for keeper in self._keepers.values():
            if keeper.is_full or utc_ns >= keeper.area.until_ns or not keeper.is_wanted(pose) or self._full:
                continue
            try:
                if not keeper.is_driving or self._frame is None:
                    self._frame = self._read_frame()
                keeper.add(stamp_ns, rows, pose, self._frame, self._track)
                keeper.state, keeper.detail = "collecting", ""
            except OSError as error:
                keeper.give_up()
                keeper.state, keeper.detail = "disk_full", str(error)

    def look(self, now_ns: int) -> None:
        """At the disk, and whether the lidar is silent."""
        if now_ns - self._looked_ns < LOOK_NS or not self._keepers:
            return
        self._looked_ns = now_ns
        kept, free = kept_bytes(self._folder), self._free_bytes(self._folder)
        self._full = ""
        if kept + PARCEL_BYTES > KEPT_BYTES_MAX:
            self._full = f"{kept} bytes of scans wait for their upload"
        elif free < FREE_BYTES_MIN:
            self._full = f"{free} bytes of the disk are free"
        if self._seen_ns is not None and now_ns - self._seen_ns > SILENT_NS:
            for keeper in self._keepers.values():
                self._leave(keeper, "no_scans", "no scan for 3 s")

    def reports(self) -> tuple[RequestReport, ...]:
        """Of the open requests, and once of each that is over."""
        over, self._over = self._over, []
        return (
            *over,
            *(
                RequestReport(name, keeper.state, keeper.detail, keeper.totals)
                for name, keeper in self._keepers.items()
            ),
        )

    def close(self) -> None:
        """The process ends: what is open becomes a parcel."""
        for keeper in self._keepers.values():
            self._end(keeper)

    def _leave(self, keeper: RequestKeeper, state: ScanState, detail: str = "") -> None:
        self._end(keeper)
        keeper.state, keeper.detail = state, detail

    def _end(self, keeper: RequestKeeper) -> None:
        try:
            keeper.end_drive(self._track)
        except OSError as error:
            keeper.give_up()
            keeper.state, keeper.detail = "disk_full", str(error)

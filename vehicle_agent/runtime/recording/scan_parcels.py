"""What a vehicle keeps of its scans for one request: which scans, in which drive, in which parcel.

A parcel is written beside its place and moved there when it is whole, named by its hash. What a killed
process left half written is removed at the next start.
"""

import hashlib
import math
from collections import deque
from pathlib import Path

import msgspec
import numpy as np

from contract.roads.areas import inside
from contract.roads.model import Origin
from contract.scan_parcels.parcels import FORMAT, FixRow, ParcelHeader, ParcelWriter, PoseRow
from contract.wire.scans import ScanArea, ScanState
from vehicle_agent.localization.odometry.voxel_map import first_of_voxels

PARCEL_BYTES, PARCEL_SCANS = 8 * 1024 * 1024, 400
# A scan is not kept where the pose is older than this, and so far it is extrapolated.
POSE_AGE_NS = 1_000_000_000
# More way between two scans is another drive, and so is this long without one that was taken while moving.
GAP_M = 4.0
# What mapping needs: nearer points are the vehicle, farther ones blur, and closer ones say the same.
RANGE_M, THINNED_M = (1.5, 60.0), 0.1
# A scan with fewer points shows no place.
POINTS_MIN = 200
_TRACK_MAX = 4_000
_UNFINISHED, PARCEL = ".part", ".zip"


class VehicleFrame(msgspec.Struct, frozen=True):
    """By what the vehicle drives; each drive has one."""

    vehicle_id: str
    campus_id: str
    origin: Origin
    map_version: str
    localization_map: str


class Totals(msgspec.Struct, frozen=True):
    """Kept for a request since it began, by this vehicle; drives: begun so far."""

    scans: int = 0
    way_m: float = 0.0
    bytes_kept: int = 0
    drives: int = 0


class Track:
    """The vehicle's poses and fixes of the last minutes, as the tick reported them."""

    def __init__(self) -> None:
        self.poses: deque[PoseRow] = deque(maxlen=_TRACK_MAX)
        self.fixes: deque[FixRow] = deque(maxlen=_TRACK_MAX)

    def pose_at(self, stamp_ns: int) -> PoseRow | None:
        """Interpolated, or extrapolated from the newest one by its speed; None if it is not known then."""
        if not self.poses:
            return None
        later = None
        for row in reversed(self.poses):
            if row.stamp_ns <= stamp_ns:
                return self._between(row, later, stamp_ns)
            later = row
        return None

    def _between(self, row: PoseRow, later: PoseRow | None, stamp_ns: int) -> PoseRow | None:
        age_ns = stamp_ns - row.stamp_ns
        if later is not None and later.stamp_ns - row.stamp_ns <= POSE_AGE_NS:
            share = age_ns / (later.stamp_ns - row.stamp_ns)
            turn = math.remainder(later.yaw_rad - row.yaw_rad, math.tau)
            return PoseRow(
                stamp_ns,
                row.x_m + share * (later.x_m - row.x_m),
                row.y_m + share * (later.y_m - row.y_m),
                row.yaw_rad + share * turn,
                row.speed_mps,
            )
        if age_ns > POSE_AGE_NS:
            return None
        way_m = row.speed_mps * age_ns * 1e-9
        return PoseRow(
            stamp_ns,
            row.x_m + way_m * math.cos(row.yaw_rad),
            row.y_m + way_m * math.sin(row.yaw_rad),
            row.yaw_rad,
            row.speed_mps,
        )


class RequestKeeper:
    """The drives and parcels of one request. Raises OSError where the disk is full; then `give_up`."""

    def __init__(self, area: ScanArea, folder: Path, drive_prefix: str) -> None:
        """folder: of this request's parcels; drive_prefix: no earlier process had it."""
        self.area = area
        self._folder = folder
        self._prefix = drive_prefix
        self._outline = np.array([(corner.x_m, corner.y_m) for corner in area.outline]).reshape(-1, 2)
        self.totals = _read_totals(folder)
        self.state: ScanState = "waiting"
        self.detail = ""
        self._frame: VehicleFrame | None = None
        self._last: PoseRow | None = None
        self._number = 0
        self._open: _OpenParcel | None = None

    def is_wanted(self, pose: PoseRow) -> bool:
        """A scan taken here is to be kept."""
        if len(self._outline) and not inside(self._outline, np.array([[pose.x_m, pose.y_m]]))[0]:
            return False
        return self._last is None or _apart_m(self._last, pose) >= self.area.every_m

    def is_inside(self, pose: PoseRow) -> bool:
        return not len(self._outline) or bool(inside(self._outline, np.array([[pose.x_m, pose.y_m]]))[0])

    @property
    def is_full(self) -> bool:
        return self.totals.bytes_kept >= self.area.bytes_max

    @property
    def is_driving(self) -> bool:
        return self._frame is not None

    def add(self, stamp_ns: int, rows: np.ndarray, pose: PoseRow, frame: VehicleFrame, track: Track) -> None:
        """Keeps a scan. rows: (n, 5) as in the scan ring. pose: at its stamp."""
        chosen = _chosen(rows)
        if len(chosen) < POINTS_MIN:
            return
        if self._last is not None and (_apart_m(self._last, pose) > GAP_M or frame != self._frame):
            self.end_drive(track)
        if self._frame is None:
            self._frame, self._number = frame, 0
            self.totals = msgspec.structs.replace(self.totals, drives=self.totals.drives + 1)
        if self._open is None:
            self._folder.mkdir(parents=True, exist_ok=True)
            self._open = _OpenParcel(self._folder / f"{self._prefix}{_UNFINISHED}", stamp_ns)
        way_m = 0.0 if self._last is None else _apart_m(self._last, pose)
        offsets_s = chosen[:, 4] - chosen[:, 4].min()
        timed = bool(offsets_s.any())
        # The stamp is that of the first point, as mapping expects it.
        first_ns = stamp_ns + round(1e9 * float(chosen[:, 4].min()))
        self._open.add(first_ns, chosen[:, :3], offsets_s if timed else None, way_m)
        self._last = pose
        self.totals = msgspec.structs.replace(
            self.totals, scans=self.totals.scans + 1, way_m=self.totals.way_m + way_m
        )
        if self._open.size_bytes >= PARCEL_BYTES or self._open.scans >= PARCEL_SCANS:
            self._finish(track)

    def end_drive(self, track: Track) -> None:
        """The vehicle has left the area, or its pose is not known."""
        self._finish(track)
        self._frame, self._last = None, None

    def give_up(self) -> None:
        """What is open cannot be written: it is removed, and nothing that is whole is lost."""
        if self._open is not None:
            self._open.abandon()
        self._open, self._frame, self._last = None, None, None

    def _finish(self, track: Track) -> None:
        parcel, self._open = self._open, None
        if parcel is None:
            return
        assert self._frame is not None
        drive_id = f"{self._prefix}-{self.totals.drives}"
        header = ParcelHeader(
            format=FORMAT,
            request_id=self.area.request_id,
            vehicle_id=self._frame.vehicle_id,
            campus_id=self._frame.campus_id,
            drive_id=drive_id,
            number=self._number,
            origin=self._frame.origin,
            map_version=self._frame.map_version,
            localization_map=self._frame.localization_map,
            scans=parcel.scans,
            way_m=round(parcel.way_m, 2),
            first_ns=parcel.first_ns,
            last_ns=parcel.last_ns,
        )
        try:
            size_bytes = parcel.finish(header, track)
        except OSError:
            parcel.abandon()
            raise
        self._number += 1
        self.totals = msgspec.structs.replace(self.totals, bytes_kept=self.totals.bytes_kept + size_bytes)
        _write_totals(self._folder, self.totals)


class _OpenParcel:
    """The file that is being written."""

    def __init__(self, path: Path, first_ns: int) -> None:
        self._path = path
        self._writer = ParcelWriter(path)
        self.first_ns, self.last_ns = 0, 0
        self.begun_ns = first_ns
        self.scans, self.way_m, self.size_bytes = 0, 0.0, 0

    def add(self, stamp_ns: int, points: np.ndarray, offsets_s: np.ndarray | None, way_m: float) -> None:
        # A parcel's way begins at its first scan.
        self.way_m += way_m if self.scans else 0.0
        self.first_ns = self.first_ns or stamp_ns
        self.last_ns = stamp_ns
        self.size_bytes = self._writer.add_scan(stamp_ns, points, offsets_s)
        self.scans += 1

    def finish(self, header: ParcelHeader, track: Track) -> int:
        """Its size. The file is at its place, under its hash."""
        around_ns = (header.first_ns - POSE_AGE_NS, header.last_ns + POSE_AGE_NS)
        fixes = [row for row in track.fixes if around_ns[0] <= row.stamp_ns <= around_ns[1]]
        poses = [row for row in track.poses if around_ns[0] <= row.stamp_ns <= around_ns[1]]
        self._writer.finish(header, fixes, poses)
        data = self._path.read_bytes()
        self._path.rename(self._path.with_name(hashlib.sha256(data).hexdigest() + PARCEL))
        return len(data)

    def abandon(self) -> None:
        # A full disk refuses the ZIP file's directory too.
        self._writer.abandon()
        self._path.unlink(missing_ok=True)


def remove_unfinished(folder: Path) -> None:
    """What a killed process left half written."""
    for path in folder.glob(f"*/*{_UNFINISHED}"):
        path.unlink(missing_ok=True)


def kept_bytes(folder: Path) -> int:
    """Of all parcels of a vehicle that wait for their upload, refused ones too."""
    total = 0
    for path in folder.glob("*/*"):
        try:
            total += path.stat().st_size
        except FileNotFoundError:
            continue  # It was uploaded meanwhile.
    return total


def _chosen(rows: np.ndarray) -> np.ndarray:
    squared = np.einsum("ij,ij->i", rows[:, :3], rows[:, :3])
    near = rows[(squared >= RANGE_M[0] ** 2) & (squared <= RANGE_M[1] ** 2)]
    kept: np.ndarray = near[first_of_voxels(near[:, :3].astype(np.float64), THINNED_M)]
    return kept


def _apart_m(one: PoseRow, other: PoseRow) -> float:
    return math.hypot(one.x_m - other.x_m, one.y_m - other.y_m)


def _totals_path(folder: Path) -> Path:
    return folder.with_suffix(".json")


def _read_totals(folder: Path) -> Totals:
    try:
        return msgspec.json.decode(_totals_path(folder).read_bytes(), type=Totals)
    except (FileNotFoundError, msgspec.DecodeError):
        return Totals()


def _write_totals(folder: Path, totals: Totals) -> None:
    fresh = _totals_path(folder).with_suffix(".new")
    fresh.write_bytes(msgspec.json.encode(totals))
    fresh.replace(_totals_path(folder))

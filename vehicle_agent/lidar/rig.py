"""Several lidars of one vehicle to one scan in the vehicle's frame. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array
from vehicle_agent.lidar.mount_watch import MountDrift, MountWatch
from vehicle_agent.lidar.plausibility import CloudLimits, cloud_faults
from vehicle_agent.signals.point_cloud import PointCloud

# Why a lidar is missing in a scan, besides the codes of `plausibility`.
SILENT = "silent"


@dataclass(frozen=True, slots=True, eq=False)
class RigLidar:
    """One lidar of the rig.

    T_base_sensor  (4, 4), of the frame in which its maker gives points
    is_required    without it the vehicle is blind, and stops
    """

    name: str
    T_base_sensor: Array
    is_required: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class RigScan:
    """One scan of the whole rig, in the vehicle's frame at stamp_ns, which is the end of the newest turn.

    points_base  (n, 3) float32; intensities (n,) float32; offsets_s (n,) float32: of each from stamp_ns
    missing      lidars that are not in it, by the code of what is wrong
    is_blind     a required one is among them: the scan has no points
    drifts       lidars that seem not to be where they were calibrated; their points are in it all the same
    """

    stamp_ns: int
    points_base: np.ndarray
    intensities: np.ndarray
    missing: dict[str, str]
    is_blind: bool
    drifts: dict[str, MountDrift]
    offsets_s: np.ndarray


class LidarRig:
    """Takes the turns of all lidars, and gives a scan with each turn of the first one that is there.

    The other lidars' newest turns go with it. A turn that no working lidar gives is not used. A lidar whose
    last usable turn is older than `age_ns_max` is missing. Vehicles move between the turns that are put
    together, by up to a turn's time; that is left in.
    """

    def __init__(
        self, lidars: Sequence[RigLidar], age_ns_max: int = 300_000_000, limits: CloudLimits | None = None
    ) -> None:
        self._lidars = tuple(lidars)
        self._age_ns_max, self._limits = age_ns_max, limits or CloudLimits()
        self._newest: dict[str, tuple[int, PointCloud]] = {}
        self._before: dict[str, PointCloud] = {}
        self._wrong: dict[str, str] = {}
        self._watches = {lidar.name: MountWatch() for lidar in self._lidars}
        self._mounts = {lidar.name: lidar.T_base_sensor for lidar in self._lidars}
        self._drifts: dict[str, MountDrift] = {}
        self._given_ns: int | None = None

    def add(self, name: str, cloud: PointCloud) -> RigScan | None:
        """A whole turn of one lidar; the rig's scan if it is the leading lidar's."""
        faults = [fault.code for fault in cloud_faults(cloud, self._before.get(name), self._limits)]
        self._before[name] = cloud
        if faults:
            self._wrong[name] = faults[0]
            return None
        self._wrong.pop(name, None)
        self._watch(name, cloud)
        end_ns = cloud.stamp_ns + int(cloud.offsets_ns.max())
        self._newest[name] = (end_ns, cloud)
        return self._scan(end_ns) if name == self._leading(end_ns) else None

    def _watch(self, name: str, cloud: PointCloud) -> None:
        watch = self._watches[name]
        if not watch.is_due(cloud.stamp_ns):
            return
        watch.add(cloud.stamp_ns, _in_base(cloud.points_sensor, self._mounts[name]))
        if watch.drift is None:
            self._drifts.pop(name, None)
        else:
            self._drifts[name] = watch.drift

    def silence(self, now_ns: int) -> RigScan | None:
        """A blind scan once a required lidar has been missing for too long and no scan says so."""
        if self._given_ns is None:
            # The vehicle cannot drive before its first scan, and sensors take time to start.
            self._given_ns = now_ns
        if now_ns - self._given_ns <= self._age_ns_max:
            return None
        scan = self._scan(now_ns)
        return scan if scan.is_blind else None

    def _leading(self, now_ns: int) -> str:
        """The first lidar of the rig that is not missing."""
        return next(lidar.name for lidar in self._lidars if self._is_there(lidar.name, now_ns))

    def _is_there(self, name: str, now_ns: int) -> bool:
        return name in self._newest and now_ns - self._newest[name][0] <= self._age_ns_max

    def _scan(self, now_ns: int) -> RigScan:
        there = [lidar for lidar in self._lidars if self._is_there(lidar.name, now_ns)]
        missing = {
            lidar.name: self._wrong.get(lidar.name, SILENT) for lidar in self._lidars if lidar not in there
        }
        is_blind = not there or any(lidar.is_required and lidar.name in missing for lidar in self._lidars)
        self._given_ns = now_ns
        if is_blind:
            nothing = np.zeros((0, 3), dtype=np.float32)
            none = np.zeros(0, dtype=np.float32)
            return RigScan(now_ns, nothing, none, missing, is_blind, dict(self._drifts), none)
        parts = [(lidar, self._newest[lidar.name][1]) for lidar in there]
        points = np.vstack([_in_base(cloud.points_sensor, lidar.T_base_sensor) for lidar, cloud in parts])
        intensities = np.concatenate([cloud.intensities for _, cloud in parts])
        since_ns = [cloud.stamp_ns - now_ns + cloud.offsets_ns for _, cloud in parts]
        offsets_s = (1e-9 * np.concatenate(since_ns)).astype(np.float32)
        return RigScan(now_ns, points, intensities, missing, is_blind, dict(self._drifts), offsets_s)


def _in_base(points_sensor: np.ndarray, T_base_sensor: Array) -> np.ndarray:
    turn, shift = T_base_sensor[:3, :3].astype(np.float32), T_base_sensor[:3, 3].astype(np.float32)
    points: np.ndarray = points_sensor @ turn.T + shift
    return points

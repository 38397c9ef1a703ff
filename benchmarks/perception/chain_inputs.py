"""What a perception chain gets of a sweep: joined, straightened points, and what the network finds."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.perception.campus_sweeps import PERIOD_NS, Sweep
from contract.geometry import Pose2
from vehicle_agent.config import Body
from vehicle_agent.perception.pillars import sweeps as detector_sweeps
from vehicle_agent.perception.pillars.detector import PillarDetector
from vehicle_agent.perception.pillars.detector_file import DetectorFileError
from vehicle_agent.perception.points.deskew import straightened
from vehicle_agent.signals.objects import SeenObjects
from vehicle_agent.stacks.own_perception import own_outline

# Points (n, 3), intensities (n,), stamp, pose -> the objects that a network finds.
Network = Callable[[np.ndarray, np.ndarray, int, Pose2], SeenObjects]


def load_network(path: Path, body: Body) -> Network:
    """The detector of a file, which remembers the turns before."""
    try:
        detector = PillarDetector(path, own_outline(body))
    except DetectorFileError as error:
        raise SystemExit(f"cannot measure: {error}") from error
    memory: tuple[detector_sweeps.Sweep, ...] = ()

    def found(points: np.ndarray, intensities: np.ndarray, stamp_ns: int, pose_map: Pose2) -> SeenObjects:
        nonlocal memory
        newest = detector_sweeps.Sweep(stamp_ns, pose_map, points, intensities)
        older, memory = detector_sweeps.step(memory, newest)
        return detector.seen(points, intensities, stamp_ns, older)

    return found


def joined(sweep: Sweep, speed_mps: float, yaw_rate_radps: float) -> tuple[np.ndarray, np.ndarray]:
    """((n, 3) points of all lidars in the base frame at the sweep's stamp, (n,) intensities)."""
    points = np.concatenate([scan.points_base for scan in sweep.scans])
    offsets_ns = np.concatenate([scan.cloud.offsets_ns for scan in sweep.scans])
    offsets_s = (1e-9 * (offsets_ns - PERIOD_NS)).astype(np.float32)
    intensities = np.concatenate([scan.cloud.intensities for scan in sweep.scans])
    return straightened(points, offsets_s, speed_mps, yaw_rate_radps), intensities


def yaw_rate_between(before: Pose2 | None, after: Pose2) -> float:
    """In rad/s, of poses a turn apart; 0 without one before."""
    if before is None:
        return 0.0
    return math.remainder(after.yaw_rad - before.yaw_rad, 2.0 * math.pi) / (PERIOD_NS * 1e-9)

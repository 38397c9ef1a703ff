"""How many scans with a picture each the room takes in a second, on one core."""

import math
import time

import numpy as np

from benchmarks.reporting.report import Row
from contract.geometry import Array, Pose2
from simulator.sensors.cameras.mounts import CameraMount
from vehicle_agent.perception.camera.people_detector import HogPeopleDetector
from vehicle_agent.perception.laser_people.people import LaserPeople, LaserPeopleState
from vehicle_agent.perception.laser_people.verification import PersonVerification
from vehicle_agent.signals.pictures import Picture, PinholeCamera

_STEP_NS = 25_000_000
_SETTLE = 5
_FIELD_RAD = 0.41


class _CountedDetector(HogPeopleDetector):
    """Counts the regions. Its answers never verify, so that every candidate is looked at every time."""

    regions = 0

    def score(self, pixels: np.ndarray, feet_px: tuple[float, float], height_px: float) -> float:
        self.regions += 1
        return min(-0.1, super().score(pixels, feet_px, height_px))


def scan_of(candidates: int) -> tuple[Array, Array]:
    """Ranges and angles of 720 beams: things 0.4 m wide, 12 m to 28 m away, before a wall at 35 m."""
    angles = np.radians(0.25) * (np.arange(720) - 359.5)
    ranges = np.full(720, 35.0)
    for k in range(candidates):
        middle = _FIELD_RAD * (2.0 * (k + 0.5) / candidates - 1.0)
        away_m = 12.0 + 16.0 * (k * 7 % candidates) / candidates
        ranges[np.abs(angles - middle) <= 0.2 / away_m] = away_m
    return ranges, angles


def rate_row(candidates: int, mount: CameraMount, cycles: int) -> Row:
    """One row: what a scan and a picture with so many regions cost."""
    room = LaserPeople(verification=PersonVerification(relook_every=1))
    detector = _CountedDetector()
    camera = PinholeCamera(mount.name, mount.K, mount.T_base_camera, mount.width_px, mount.height_px)
    rng = np.random.default_rng(1)
    pixels = rng.integers(0, 255, (mount.height_px, mount.width_px, 3), dtype=np.uint8)
    ranges, angles = scan_of(candidates)
    T_base_laser, here = np.eye(4), Pose2(0.0, 0.0, 0.0)
    T_base_laser[0, 3] = float(mount.T_base_camera[0, 3])
    state = LaserPeopleState()
    cpu_s, wall_s, counts = [], [], []
    for number in range(1, cycles + _SETTLE + 1):
        stamp_ns, before = number * _STEP_NS, detector.regions
        noisy = ranges + rng.normal(0.0, 0.012, len(ranges))
        # Two pictures are never equal, or the camera would be taken for frozen.
        pixels[::8, ::8] = rng.integers(0, 255, pixels[::8, ::8].shape, dtype=np.uint8)
        begun_wall, begun_cpu = time.perf_counter(), time.process_time()
        state = room.after_scan(state, noisy, angles, T_base_laser, here, stamp_ns)
        state = room.after_picture(state, Picture(camera.name, stamp_ns, pixels), camera, here, detector)
        if number > _SETTLE:
            cpu_s.append(time.process_time() - begun_cpu)
            wall_s.append(time.perf_counter() - begun_wall)
            counts.append(detector.regions - before)
    mean_cpu_s = float(np.mean(cpu_s))
    return {
        "part": "rate",
        "case": f"{candidates} candidates",
        "regions_mean": float(np.mean(counts)),
        "hz": 1.0 / mean_cpu_s if mean_cpu_s > 0.0 else math.nan,
        "cpu_ms_mean": 1e3 * mean_cpu_s,
        "cpu_ms_p95": 1e3 * float(np.percentile(cpu_s, 95)),
        "wall_ms_mean": 1e3 * float(np.mean(wall_s)),
    }

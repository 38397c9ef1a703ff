"""KISS-ICP beside ours: the same scans, one after the other, in a process on the same core."""

import struct
import subprocess
from pathlib import Path

import numpy as np

from contract.geometry import Array
from vehicle_agent.signals.point_cloud import PointCloud

ROOT = Path(__file__).resolve().parents[2]
PYTHON = ROOT / "var" / "odometry-peers" / "bin" / "python"
_ANSWER = struct.Struct("<17d")


class PeerError(Exception):
    """The peer cannot be run, or ended; the message says what to do."""


class KissIcp:
    """One run over one recording."""

    def __init__(self, python: Path) -> None:
        """python: the interpreter of an environment with kiss-icp."""
        self.poses: list[Array] = []
        self.cpu_s: list[float] = []
        script = Path(__file__).with_name("kiss_icp_process.py")
        try:
            self._process = subprocess.Popen([python, script], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        except OSError as error:
            raise PeerError(f"{python} cannot be started ({error}); make odometry-peers") from error

    def step(self, cloud: PointCloud) -> None:
        """Gives it a scan, and keeps its pose and its CPU time."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        points = np.ascontiguousarray(cloud.points_sensor, dtype="<f8")
        span_ns = int(cloud.offsets_ns.max(initial=0))
        scan = struct.pack("<qq", len(points), int(span_ns > 0)) + points.tobytes()
        if span_ns > 0:
            scan += (cloud.offsets_ns / span_ns).astype("<f8").tobytes()
        try:
            self._process.stdin.write(scan)
            self._process.stdin.flush()
        except BrokenPipeError as error:
            raise PeerError("KISS-ICP has ended; is kiss-icp installed? make odometry-peers") from error
        answer = self._process.stdout.read(_ANSWER.size)
        if len(answer) < _ANSWER.size:
            raise PeerError("KISS-ICP has ended; is kiss-icp installed? make odometry-peers")
        cpu_s, *pose = _ANSWER.unpack(answer)
        self.cpu_s.append(cpu_s)
        self.poses.append(np.array(pose).reshape(4, 4))

    def close(self) -> None:
        """Ends it."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(timeout=60)

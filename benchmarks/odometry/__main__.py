"""How far lidar odometry drifts: `python -m benchmarks.odometry [DIR] [--simulated N] [--peers] [--json F]`.

DIR: recordings of scans (folders of numbered PCD, PLY or KITTI files, bags of clouds or packets), each a row.
The end gap is the distance between the first and the last position of a vehicle that came back to its start;
with a file of true poses beside the recording it is the distance from the last true position, after the
trajectories are laid over each other. --simulated N: drives around a block. --peers: KISS-ICP on the same
scans and core (make odometry- peers). --poses DIR writes all trajectories as TUM files for re-scoring.
"""

import argparse
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import Progress

from benchmarks.odometry.peer import PYTHON, KissIcp, PeerError
from benchmarks.odometry.simulated import SimulatedDrive
from benchmarks.reporting.report import Row, RunReport, Value
from contract.geometry import Array
from vehicle_agent.lidar.models import VLP16, XT16, XT32
from vehicle_agent.localization.odometry.lidar_odometry import LidarOdometry
from vehicle_agent.localization.odometry.warm import warm_odometry
from vehicle_agent.signals.point_cloud import PointCloud
from workshop.clouds.errors import CloudFileError
from workshop.clouds.poses import poses_file, read_poses
from workshop.clouds.recordings import Recording, find_recordings

_MODELS = (VLP16, XT16, XT32)
# A true pose that is farther from a scan in time is not its.
_STAMP_S = 0.06


@dataclass(slots=True, eq=False)
class Run:
    """One odometry over one recording."""

    poses: list[Array] = field(default_factory=list)
    cpu_s: list[float] = field(default_factory=list)
    wall_s: float = 0.0


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    warm_odometry()
    rows: list[Row] = []
    for number in range(arguments.simulated):
        drive = SimulatedDrive(number + 1, model=_MODELS[number % len(_MODELS)])
        name = f"simulated {number + 1}, {_MODELS[number % len(_MODELS)].name}"
        rows.append(_row(name, drive.clouds(), drive.scans, drive.truth(), None, arguments))
    if arguments.folder is not None:
        for recording in find_recordings(arguments.folder):
            truth, stamps_s = _truth(recording)
            name = _name(recording, arguments.folder)
            rows.append(_row(name, recording.scans(), len(recording), truth, stamps_s, arguments))
    plain = {
        "folder": str(arguments.folder), "simulated": arguments.simulated, "peers": arguments.peers,
        "cores_used": 1,
    }  # fmt: skip
    report.write(arguments.json, "odometry", plain, rows, _summary(rows, arguments.peers))


def _row(
    name: str, clouds: Iterator[PointCloud], expected: int, truth: Array | None, stamps_s: Array | None,
    arguments: argparse.Namespace,
) -> Row:  # fmt: skip
    ours, theirs, stamps = _runs(name, clouds, expected, arguments)
    row: dict[str, Value] = {"recording": name, "scans": len(stamps), "way_m": _way_m(ours.poses)}
    for prefix, run in (("", ours), ("kiss_icp_", theirs)):
        if run is None:
            continue
        gap_m, deviation_m = _gap_m(np.array(run.poses), truth, stamps, stamps_s)
        row |= {f"{prefix}end_gap_m": gap_m}
        if deviation_m is not None:
            row |= {f"{prefix}rms_m": deviation_m}
        row |= {
            f"{prefix}cpu_ms": 1e3 * float(np.mean(run.cpu_s)),
            f"{prefix}cpu_p95_ms": 1e3 * float(np.percentile(run.cpu_s, 95)),
        }
        if arguments.poses is not None:
            _write_poses(
                arguments.poses / f"{_file_name(name)}_{prefix or 'ours_'}poses.txt", run.poses, stamps
            )
    row |= {"wall_ms": 1e3 * ours.wall_s / max(1, len(stamps))}
    if theirs is not None:
        row |= {
            "end_gap_ratio": float(row["end_gap_m"] or 0.0)
            / max(float(row["kiss_icp_end_gap_m"] or 0.0), 1e-9),
            "cpu_ratio": float(row["cpu_ms"] or 0.0) / float(row["kiss_icp_cpu_ms"] or 1.0),
        }
    return row


def _runs(
    name: str, clouds: Iterator[PointCloud], expected: int, arguments: argparse.Namespace
) -> tuple[Run, Run | None, list[int]]:
    """Both over the same scans, one after the other, so that no recording has to fit into memory."""
    ours, odometry, stamps = Run(), LidarOdometry(), []
    peer = KissIcp(arguments.peer_python) if arguments.peers else None
    with Progress(console=Console(stderr=True), transient=True) as progress:
        bar = progress.add_task(name, total=expected)
        for cloud in clouds:
            began_cpu, began_wall = time.process_time(), time.perf_counter()
            step = odometry.step(cloud)
            ours.cpu_s.append(time.process_time() - began_cpu)
            ours.wall_s += time.perf_counter() - began_wall
            ours.poses.append(step.pose)
            stamps.append(cloud.stamp_ns)
            if peer is not None:
                peer.step(cloud)
            progress.advance(bar)
    if peer is None:
        return ours, None, stamps
    peer.close()
    return ours, Run(peer.poses, peer.cpu_s), stamps


def _gap_m(
    poses: Array, truth: Array | None, stamps_ns: list[int], truth_s: Array | None
) -> tuple[float, float | None]:
    """(end gap, root mean square deviation from the truth if there is one)."""
    places = poses[:, :3, 3]
    if truth is None:
        return float(np.linalg.norm(places[-1] - places[0])), None
    ours, theirs = _paired(places, truth[:, :3, 3], stamps_ns, truth_s)
    centred, true = ours - ours.mean(axis=0), theirs - theirs.mean(axis=0)
    u, _, vt = np.linalg.svd(centred.T @ true)
    # Trajectories are laid over each other: a file of poses may be of another frame (KITTI's are the
    # camera's).
    rotation = vt.T @ np.diag([1.0, 1.0, np.sign(np.linalg.det(vt.T @ u.T))]) @ u.T
    apart = np.linalg.norm(centred @ rotation.T - true, axis=1)
    return float(apart[-1]), float(np.sqrt(np.mean(apart**2)))


def _paired(places: Array, true: Array, stamps_ns: list[int], truth_s: Array | None) -> tuple[Array, Array]:
    """Positions (n, 3) of the same moments: by time, or one for one."""
    if truth_s is None:
        count = min(len(places), len(true))
        return places[:count], true[:count]
    stamps_s = 1e-9 * np.array(stamps_ns)
    nearest = np.argmin(np.abs(truth_s[None, :] - stamps_s[:, None]), axis=1)
    same = np.abs(truth_s[nearest] - stamps_s) < _STAMP_S
    if same.sum() < 2:
        raise SystemExit("the true poses have no time in common with the scans")
    return places[same], true[nearest[same]]


def _truth(recording: Recording) -> tuple[Array | None, Array | None]:
    path = poses_file(recording.path)
    return read_poses(path) if path is not None else (None, None)


def _name(recording: Recording, folder: Path) -> str:
    inside = recording.path.relative_to(folder) if recording.path != folder else Path(folder.name)
    return str(inside) if recording.topic is None else f"{inside} {recording.topic.name}"


def _file_name(name: str) -> str:
    return "".join(letter if letter.isalnum() else "_" for letter in name)


def _way_m(poses: list[Array]) -> float:
    places = np.array(poses)[:, :3, 3]
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def _write_poses(path: Path, poses: list[Array], stamps_ns: list[int]) -> None:
    """TUM: time (s), x, y, z (m), quaternion x, y, z, w."""
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = []
    for pose, stamp_ns in zip(poses, stamps_ns, strict=True):
        w = 0.5 * float(np.sqrt(max(1e-12, 1.0 + np.trace(pose[:3, :3]))))
        x, y, z = (float(pose[a, b] - pose[b, a]) / (4.0 * w) for a, b in ((2, 1), (0, 2), (1, 0)))
        place = " ".join(f"{value:.6f}" for value in pose[:3, 3])
        lines.append(f"{stamp_ns // 10**9}.{stamp_ns % 10**9:09d} {place} {x:.8f} {y:.8f} {z:.8f} {w:.8f}\n")
    path.write_text("".join(lines), encoding="utf-8")


def _summary(rows: list[Row], peers: bool) -> Row:
    """Ratios of the sums over all recordings."""

    def total(key: str) -> float:
        return sum(float(row[key] or 0.0) for row in rows)

    summary: dict[str, Value] = {
        "recordings": len(rows), "end_gap_m_mean": total("end_gap_m") / max(1, len(rows)),
        "cpu_ms_mean": total("cpu_ms") / max(1, len(rows)),
    }  # fmt: skip
    if peers and rows:
        summary |= {
            "end_gap_ratio": total("end_gap_m") / max(total("kiss_icp_end_gap_m"), 1e-9),
            "end_gap_ratio_max": max(float(row["end_gap_ratio"] or 0.0) for row in rows),
            "cpu_ratio": total("cpu_ms") / max(total("kiss_icp_cpu_ms"), 1e-9),
        }
    return summary


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.odometry", description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, help="recordings of scans")
    parser.add_argument("--simulated", type=int, default=0, help="drives around a block")
    parser.add_argument("--peers", action="store_true", help="run KISS-ICP beside ours")
    parser.add_argument("--peer-python", type=Path, default=PYTHON, help="interpreter that has kiss-icp")
    parser.add_argument("--poses", type=Path, help="folder for the trajectories")
    parser.add_argument("--json", type=Path, help="where to write the report")
    arguments = parser.parse_args()
    if not arguments.simulated and arguments.folder is None:
        parser.error("give a folder of recordings, --simulated N, or both")
    return arguments


if __name__ == "__main__":
    try:
        main()
    except (CloudFileError, PeerError) as error:
        raise SystemExit(str(error)) from error

"""The detector on simulated campuses it never saw: `python -m benchmarks.detector [--scans N] [--json F]`.

Scans are of four XT16 on a vehicle that drives among people, cyclists and vehicles. The campuses are held
out: the eastern part of the Shanghai University map and the Snow Lion map, with other trees, hills and parked
vehicles. A box counts if it has 5 returns of the newer turn or more, and its middle is inside the network's
area (x -16 to 40 m, y -20 to 20 m, less 1 m). Parked vehicles count. Shares are in percent.

finder       the network, or the peer: clusters and shape fit (shape_fit.py)
ap50, ap25   average precision; a found box is right if it overlaps a true one of its kind by 0.5, or 0.25
             (intersection over union on the ground)
ap_half_m    the same where middles are within 0.5 m
recall50     share of the boxes that are found at all, by an overlap of 0.5
boxes        that count
velocity_error_mps  mean length of the difference, of right boxes (0.25) with a velocity; also median and 90 %
"""

import argparse
import time
from pathlib import Path

import numpy as np

from benchmarks.detector.shape_fit import found_by_shape
from benchmarks.reporting.report import Row, RunReport
from campusloop.scenes.detector_scenes.folder import make_scans
from vehicle_agent.perception.pillars.detector import PillarDetector
from vehicle_agent.perception.pillars.detector_file import DEFAULT_DETECTOR
from vehicle_agent.perception.pillars.grid import PillarGrid
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, TRACK_KINDS, VEHICLE
from workshop.detector.average_precision import (
    FoundBoxes,
    TrueBoxes,
    average_precision,
    closeness,
)
from workshop.detector.labeled_scans import LabeledScan, read_scan
from workshop.detector.targets import HITS_MIN

_ROOT = Path(__file__).resolve().parents[2]
_EDGE_M = 1.0

Scans = list[tuple[FoundBoxes, TrueBoxes]]


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    detector = PillarDetector(arguments.detector)
    scans = [
        read_scan(path)
        for path in make_scans(
            arguments.folder, arguments.split, arguments.seed, arguments.scans, lambda _: None
        )
    ]
    detector.found(scans[0].points, scans[0].is_older, scans[0].older_s)
    found_by_network: Scans = []
    found_by_peer: Scans = []
    network_ms, peer_ms = [], []
    for scan in scans:
        true = _true(scan, detector.grid)
        begun_s = time.process_time()
        found = detector.found(scan.points, scan.is_older, scan.older_s)
        network_ms.append(1e3 * (time.process_time() - begun_s))
        found_by_network.append((FoundBoxes(*found), true))
        begun_s = time.process_time()
        near = _in_area(scan.points[:, 0], scan.points[:, 1], detector.grid, 0.0)
        peer = found_by_shape(scan.points[near], scan.is_older[near], scan.older_s)
        peer_ms.append(1e3 * (time.process_time() - begun_s))
        found_by_peer.append((peer, true))
    rows = [
        *_rows("network", found_by_network, float(np.median(network_ms))),
        *_rows("clusters + shape fit", found_by_peer, float(np.median(peer_ms))),
    ]
    by_kind = {str(row["kind"]): row for row in rows[:3]}
    errors = _velocity_errors(found_by_network)
    summary: Row = {
        "car_ap50": by_kind["vehicle"]["ap50"],
        "pedestrian_ap50": by_kind["pedestrian"]["ap50"],
        "cyclist_ap50": by_kind["cyclist"]["ap50"],
        "velocity_error_mps": float(np.mean(errors)) if len(errors) else None,
        "velocity_error_median_mps": float(np.median(errors)) if len(errors) else None,
        "train_cpu_min": detector.record.train_cpu_min,
        "detector_cpu_ms_median": float(np.median(network_ms)),
        "detector_cpu_ms_p95": float(np.percentile(network_ms, 95)),
        "above_peer_in_every_class": all(
            float(rows[k]["ap50"] or 0.0) > float(rows[k + 3]["ap50"] or 0.0) for k in range(3)
        ),
    }
    plain = {
        "detector": detector.record.sha256, "split": arguments.split, "scans": arguments.scans,
        "seed": arguments.seed, "hits_min": HITS_MIN, "cores_used": 1,
    }  # fmt: skip
    report.write(arguments.json, "detector", plain, rows, summary)


def _rows(finder: str, scans: Scans, cpu_ms: float) -> list[Row]:
    rows: list[Row] = []
    for kind in (PEDESTRIAN, CYCLIST, VEHICLE):
        half, quarter = average_precision(scans, kind, 0.5), average_precision(scans, kind, 0.25)
        near = average_precision(scans, kind, 0.5, closeness)
        errors = quarter.velocity_errors_mps
        rows.append(
            {
                "finder": finder,
                "kind": TRACK_KINDS[kind],
                "ap50": 100.0 * half.average_precision,
                "ap25": 100.0 * quarter.average_precision,
                "ap_half_m": 100.0 * near.average_precision,
                "recall50": 100.0 * half.recall_ratio,
                "boxes": half.boxes,
                "velocity_error_mps": float(np.mean(errors)) if len(errors) else None,
                "velocity_median_mps": float(np.median(errors)) if len(errors) else None,
                "velocity_p90_mps": float(np.percentile(errors, 90)) if len(errors) else None,
                "cpu_ms_median": cpu_ms,
            }
        )
    return rows


def _velocity_errors(scans: Scans) -> np.ndarray:
    kinds = (PEDESTRIAN, CYCLIST, VEHICLE)
    return np.concatenate([average_precision(scans, kind, 0.25).velocity_errors_mps for kind in kinds])


def _true(scan: LabeledScan, grid: PillarGrid) -> TrueBoxes:
    inside = _in_area(scan.boxes[:, 0], scan.boxes[:, 1], grid, _EDGE_M)
    return TrueBoxes(scan.kinds, scan.boxes, inside & (scan.hits >= HITS_MIN))


def _in_area(x: np.ndarray, y: np.ndarray, grid: PillarGrid, edge_m: float) -> np.ndarray:
    along = (x > grid.x_m_min + edge_m) & (x < grid.x_m_max - edge_m)
    inside: np.ndarray = along & (y > grid.y_m_min + edge_m) & (y < grid.y_m_max - edge_m)
    return inside


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.detector", description=__doc__)
    parser.add_argument("--detector", type=Path, default=DEFAULT_DETECTOR, help="ONNX file with its record")
    parser.add_argument("--scans", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--split", choices=("tune", "held-out"), default="held-out")
    parser.add_argument(
        "--folder", type=Path, default=_ROOT / "var" / "detector" / "benchmark", help="scans are kept here"
    )
    parser.add_argument("--json", type=Path, help="where to write the report")
    return parser.parse_args()


if __name__ == "__main__":
    main()

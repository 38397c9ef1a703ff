"""What perception costs: `python -m benchmarks.perception [--detector FILE] [--json F]`, on one core.

A vehicle drives over a campus among people, cyclists and vehicles with four lidars of 16 beams and 1800
firings (4 x 16 x 1800 rays a tick). Each tick the whole chain runs: the four clouds are moved into the base
frame and straightened by speed and yaw rate, then ground, cells, clusters and tracker. The columns:

cpu_ms_median, cpu_ms_p95   processor time of a tick
wall_ms_median     of the same; longer where the machine does other work, too
points, cells, tracks   medians
people_tracked_pct of the people within 20 m with ten returns or more, the ones with a track of a pedestrian
velocity_error_mps median, of these tracks

p95_without_network_ms is the chain without a network, p95_ms the chain with it: the detector that ships, or
that of --detector.
"""

import argparse
import os
import time
from pathlib import Path

import numpy as np

from benchmarks.perception.campus_sweeps import CampusSweeps, Sweep
from benchmarks.perception.chain_inputs import Network, joined, load_network, yaw_rate_between
from benchmarks.reporting.report import Row, RunReport
from contract.geometry import Pose2, inverse, transform_points
from contract.roads.load import load_map
from simulator.sensors.lidars.mounts import four_lidars
from vehicle_agent.config import load_profile
from vehicle_agent.lidar.models import XT16
from vehicle_agent.perception.pillars.detector_file import DEFAULT_DETECTOR
from vehicle_agent.perception.points.chain import PointPerception
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.signals import PEDESTRIAN, TrackPercept

_ROOT = Path(__file__).resolve().parents[2]
_NEAR_M, _RETURNS_MIN, _SAME_M = 20.0, 10, 0.6
# Until tracks are confirmed.
_FIRST_TICKS = 6


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    body = load_profile(arguments.profile).body
    sweeps = CampusSweeps(
        load_map(arguments.map),
        body,
        four_lidars(body, XT16),
        arguments.seed,
        arguments.speed_mps,
        arguments.turns,
    )
    grid = PointGrid(body.height_m + 0.1, body.front_overhang_m, body.rear_overhang_m, 0.5 * body.width_m)
    recorded = list(sweeps)
    rows = [run(PointPerception(grid), recorded, arguments.speed_mps, "without a network", None)]
    network = load_network(arguments.detector, body)
    rows.append(run(PointPerception(grid), recorded, arguments.speed_mps, "with the network", network))
    summary: Row = {
        "p95_ms": rows[1]["cpu_ms_p95"],
        "p95_without_network_ms": rows[0]["cpu_ms_p95"],
        "people_tracked_pct": rows[0]["people_tracked_pct"],
        "velocity_error_mps": rows[0]["velocity_error_mps"],
    }
    plain = {
        "map": str(arguments.map), "turns": arguments.turns, "seed": arguments.seed,
        "detector": str(arguments.detector), "cores_used": 1,
    }  # fmt: skip
    report.write(arguments.json, "perception", plain, rows, summary)


def run(
    perception: PointPerception, sweeps: list[Sweep], speed_mps: float, name: str, network: Network | None
) -> Row:
    """One row: all turns through the chain."""
    state = perception.initial()
    cpu_s, wall_s, points, cells, tracks = [], [], [], [], []
    found: list[bool] = []
    errors: list[float] = []
    before: Pose2 | None = None
    for number, sweep in enumerate(sweeps):
        yaw_rate = yaw_rate_between(before, sweep.pose_map)
        before = sweep.pose_map
        begun_wall, begun_cpu = time.perf_counter(), time.process_time()
        scan, intensities = joined(sweep, speed_mps, yaw_rate)
        seen = network(scan, intensities, sweep.stamp_ns, sweep.pose_map) if network is not None else None
        obstacle, track, state = perception.step(
            state, scan, intensities, sweep.stamp_ns, sweep.pose_map, seen
        )
        spent = time.process_time() - begun_cpu, time.perf_counter() - begun_wall
        if number == 0:
            # The first turn loads the kernels.
            continue
        cpu_s.append(spent[0])
        wall_s.append(spent[1])
        points.append(len(scan))
        cells.append(len(obstacle.cells_base))
        tracks.append(len(track.ids))
        if number >= _FIRST_TICKS:
            _judge(sweep, scan, track, found, errors)
    return {
        "chain": name,
        "turns": len(cpu_s),
        "points": float(np.median(points)),
        "cells": float(np.median(cells)),
        "tracks": float(np.median(tracks)),
        "cpu_ms_median": 1e3 * float(np.median(cpu_s)),
        "cpu_ms_p95": 1e3 * float(np.percentile(cpu_s, 95)),
        "wall_ms_median": 1e3 * float(np.median(wall_s)),
        "people_tracked_pct": 100.0 * float(np.mean(found)) if found else None,
        "velocity_error_mps": float(np.median(errors)) if errors else None,
    }


def _judge(
    sweep: Sweep, scan: np.ndarray, track: TrackPercept, found: list[bool], errors: list[float]
) -> None:
    """Adds whether each person in view has a track, and how far its velocity is off."""
    bodies = sweep.bodies
    people = np.flatnonzero(bodies.people)
    places = transform_points(inverse(sweep.pose_map), bodies.poses_map[people, :2])
    turned = Pose2(0.0, 0.0, -sweep.pose_map.yaw_rad)
    velocities = transform_points(turned, bodies.velocities_map_mps[people])
    for place, velocity in zip(places, velocities, strict=True):
        if not (-10.0 < place[0] < _NEAR_M and abs(place[1]) < 14.0):
            continue
        on_it = (np.hypot(scan[:, 0] - place[0], scan[:, 1] - place[1]) < 0.35) & (scan[:, 2] > 0.3)
        if np.count_nonzero(on_it) < _RETURNS_MIN:
            continue
        apart = np.hypot(track.poses_base[:, 0] - place[0], track.poses_base[:, 1] - place[1])
        apart = np.where(track.kinds == PEDESTRIAN, apart, np.inf)
        found.append(bool(apart.min(initial=np.inf) < _SAME_M))
        if found[-1]:
            errors.append(float(np.hypot(*(track.velocities_base_mps[np.argmin(apart)] - velocity))))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="benchmarks.perception", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--map", type=Path, default=_ROOT / "maps/shanghai-university/map.json")
    parser.add_argument("--profile", type=Path, default=_ROOT / "vehicle_agent/profiles/campus-shuttle.toml")
    parser.add_argument("--turns", type=int, default=150)
    parser.add_argument("--speed-mps", type=float, default=3.0)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--detector", type=Path, default=DEFAULT_DETECTOR, help="a detector's file")
    parser.add_argument("--json", type=Path, help="where to write the report")
    return parser.parse_args()


if __name__ == "__main__":
    main()

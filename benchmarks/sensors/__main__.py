"""What a vehicle's simulated lidars cost: `python -m benchmarks.sensors [--map F] [--picture F] [--json F]`.

One vehicle drives over a campus among people and vehicles. Each row is a set of lidars at 10 Hz. All is on
one core: poses, moving scenes of five ticks, rays, noise, intensities, clouds, points in the base frame.

cpu_ms_median, cpu_ms_p95  for 0.1 s of all lidars together; real time is 100 ms, the goal 60 ms with four
wall_ms_median     of the same; longer where the machine does other work, too
rays               cast in 0.1 s, without those that the own body stops
points             returns in 0.1 s
build_cpu_s        the static scene, once for all vehicles; triangles: of it; memory_mb: of the process

--picture F draws one turn of the four lidars.
"""

import argparse
import os
import resource
import time
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row, RunReport
from benchmarks.sensors.drive import Drive, others_around, way_over
from benchmarks.sensors.picture import draw_scan
from contract.roads.load import load_map
from simulator.fleet import STEP_NS
from simulator.sensors.lidars.mounts import four_lidars, roof_lidar
from simulator.sensors.lidars.scanner import MovingBodies
from simulator.sensors.lidars.spinning_lidar import MountedLidar, SpinningLidar
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.shapes import shuttle
from simulator.sensors.scene.static_scene import CastScene, StaticScene
from vehicle_agent.config import Body, load_profile
from vehicle_agent.lidar.models import VLP16, XT16

_ROOT = Path(__file__).resolve().parents[2]
_PERIOD_NS = 100_000_000
_FLEET_FROM = 1_000_000
_SPEED_MPS = 4.0


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    body = load_profile(arguments.profile).body
    road_map = load_map(arguments.map)
    begun_s = time.process_time()
    scene = StaticScene(road_map, arguments.seed, WorldChanges(seed=arguments.seed))
    build_s = time.process_time() - begun_s
    length_m = _SPEED_MPS * 0.1 * arguments.scans + 20.0
    way = way_over(road_map, length_m, np.random.default_rng(arguments.seed))
    drive = Drive(way, scene.ground, _SPEED_MPS, body.wheelbase_m)
    sets: tuple[tuple[str, tuple[MountedLidar, ...]], ...] = (
        ("one VLP-16", (roof_lidar(body, VLP16),)),
        ("one XT16", (roof_lidar(body, XT16),)),
        ("four XT16", four_lidars(body, XT16)),
    )
    if arguments.picture is not None:
        _draw(arguments.picture, sets[2][1], scene, drive, body, arguments)
    rows = [_row(name, lidars, scene, drive, body, arguments) for name, lidars in sets]
    memory_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    summary: Row = {
        "one_lidar_cpu_ms_median": rows[1]["cpu_ms_median"],
        "four_lidars_cpu_ms_median": rows[2]["cpu_ms_median"],
        "four_lidars_cpu_ms_p95": rows[2]["cpu_ms_p95"],
        "four_lidars_wall_ms_median": rows[2]["wall_ms_median"],
        "build_cpu_s": build_s,
        "triangles": len(scene.triangles),
        "memory_mb": memory_mb,
    }
    plain = {
        "map": str(arguments.map), "profile": str(arguments.profile), "scans": arguments.scans,
        "seed": arguments.seed, "people": arguments.people, "vehicles": arguments.vehicles, "cores_used": 1,
    }  # fmt: skip
    report.write(arguments.json, "sensors", plain, rows, summary)


def _draw(
    path: Path,
    lidars: tuple[MountedLidar, ...],
    scene: StaticScene,
    drive: Drive,
    body: Body,
    arguments: argparse.Namespace,
) -> None:
    begin_ns = arguments.scans // 2 * _PERIOD_NS
    moving = _moving(MovingScenes(scene.ground, _FLEET_FROM), drive, begin_ns, arguments)
    own = _own_body(body)
    scans = [
        SpinningLidar(mounted, scene, np.random.default_rng([arguments.seed, number]), own).scan(
            drive.poses, begin_ns, moving
        )
        for number, mounted in enumerate(lidars)
    ]
    draw_scan(
        path,
        np.concatenate([scan.points_base for scan in scans]),
        np.concatenate([scan.cloud.intensities for scan in scans]),
        f"four XT16, one turn at {_SPEED_MPS:g} m/s",
    )


def _own_body(body: Body) -> CastScene:
    return CastScene(shuttle(body.length_m, body.width_m, body.height_m, body.rear_overhang_m))


def _row(
    name: str,
    lidars: tuple[MountedLidar, ...],
    scene: StaticScene,
    drive: Drive,
    body: Body,
    arguments: argparse.Namespace,
) -> Row:
    own = _own_body(body)
    sensors = [
        SpinningLidar(mounted, scene, np.random.default_rng([arguments.seed, number]), own)
        for number, mounted in enumerate(lidars)
    ]
    scenes = MovingScenes(scene.ground, _FLEET_FROM)
    wall_s, cpu_s, points = [], [], []
    # The first turn loads the kernels.
    for turn in range(-1, arguments.scans):
        begin_ns = max(0, turn) * _PERIOD_NS
        begun_wall, begun_cpu = time.perf_counter(), time.process_time()
        moving = _moving(scenes, drive, begin_ns, arguments)
        scans = [sensor.scan(drive.poses, begin_ns, moving) for sensor in sensors]
        base = np.concatenate([scan.points_base for scan in scans])
        if turn >= 0:
            wall_s.append(time.perf_counter() - begun_wall)
            cpu_s.append(time.process_time() - begun_cpu)
            points.append(len(base))
    return {
        "lidars": name,
        "turns": arguments.scans,
        "rays": sum(sensor.rays for sensor in sensors),
        "points_median": float(np.median(points)),
        "cpu_ms_median": 1e3 * float(np.median(cpu_s)),
        "cpu_ms_p95": 1e3 * float(np.percentile(cpu_s, 95)),
        "wall_ms_median": 1e3 * float(np.median(wall_s)),
    }


def _moving(
    scenes: MovingScenes, drive: Drive, begin_ns: int, arguments: argparse.Namespace
) -> tuple[MovingBodies, ...]:
    """The bodies of the five ticks of one turn."""
    found = []
    for until_ns in range(begin_ns + STEP_NS, begin_ns + _PERIOD_NS + 1, STEP_NS):
        others = others_around(
            drive.pose(until_ns * 1e-9), until_ns * 1e-9, arguments.people, arguments.vehicles
        )
        found.append(MovingBodies(until_ns, scenes.of(others)))
    return tuple(found)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.sensors", description=__doc__)
    parser.add_argument("--map", type=Path, default=_ROOT / "maps/shanghai-university/map.json")
    parser.add_argument("--profile", type=Path, default=_ROOT / "vehicle_agent/profiles/campus-shuttle.toml")
    parser.add_argument("--scans", type=int, default=300, help="turns of each set of lidars")
    parser.add_argument("--people", type=int, default=20)
    parser.add_argument("--vehicles", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--picture", type=Path, help="draws one turn of the four lidars")
    parser.add_argument("--json", type=Path, help="where to write the report")
    return parser.parse_args()


if __name__ == "__main__":
    main()

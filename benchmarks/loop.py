"""CPU time of one vehicle's loop: at 50 Hz in real time, and the speed of virtual time.

    python -m benchmarks.loop --json F

Real time: the whole onboard loop on the wall clock with one VLP-16 (16 x 1800 at 10 Hz), CPU time of every
room, of the tick with its recording and of a scan's height map (a process of its own on a vehicle), and the
lateness of ticks. Lockstep: virtual seconds per second of one vehicle with plant, by-wire, CAN, gate and
recorder, without lidar and with it (ray casting and height map included), on one core.
"""

import argparse
import gc
import os
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row, RunReport
from campusloop.virtual.solo_drive import SoloDrive
from contract.geometry import Pose2
from contract.roads.load import load_map
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from simulator.sensors.lidar import Lidar, LidarNoise
from simulator.sensors.walls import WallScene
from simulator.traffic.population import TrafficParams
from vehicle_agent.config import Body, LidarMount, Profile
from vehicle_agent.perception.height_map import percept_from_scan
from vehicle_agent.runtime.processes.pacing import Pacer
from vehicle_agent.stacks.rooms import height_map as map_params

SHIPPED = Path(__file__).resolve().parents[1] / "maps" / "shanghai-university" / "map.json"
QUANTILES = (50, 95, 99)
# The first one loads the kernels and does not count.
_SCANS = 201


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    road_map = load_map(arguments.map)
    rows, tick_p99_ms = real_time(road_map, arguments.seconds, arguments.seed)
    rows.append(height_map(road_map, arguments.seed))
    without, with_lidar = (
        lockstep(road_map, arguments.virtual_seconds, arguments.seed, lidar=lidar) for lidar in (False, True)
    )
    summary: Row = {
        "tick_cpu_p99_ms": tick_p99_ms,
        "lockstep_ratio": without,
        "lockstep_lidar_ratio": with_lidar,
    }
    report.write(
        arguments.json,
        "loop",
        {
            "map": road_map.name,
            "seconds": arguments.seconds,
            "virtual_seconds": arguments.virtual_seconds,
            "seed": arguments.seed,
            "cores_used": 1,
        },
        rows,
        summary,
    )


def real_time(road_map: RoadMap, seconds: float, seed: int) -> tuple[list[Row], float]:
    """Rows of (room, CPU quantiles in ms), and the whole tick's 99th percentile in ms."""
    with tempfile.TemporaryDirectory() as folder:
        drive = SoloDrive(road_map, Path(folder), seed, traffic=TrafficParams(), start_ns=time.monotonic_ns())
        drive.set_off()
        for times in (*drive.vehicle.times.by_room.values(), drive.vehicle.times.whole):
            times.clear()
        gc.collect()
        gc.freeze()
        late_ns = []
        pacer = Pacer()
        for _ in range(round(seconds * 50)):
            now_ns = pacer.wait()
            late_ns.append(pacer.late_ns)
            drive.step(now_ns)
        gc.unfreeze()
        drive.vehicle.shut_down()
    rows = [_quantiles(room, samples) for room, samples in drive.vehicle.times.by_room.items()]
    rows.append(_quantiles("whole tick, recording included", drive.vehicle.times.whole))
    rows.append(_quantiles("tick begins late (wall)", late_ns))
    return rows, float(np.percentile(drive.vehicle.times.whole, 99)) / 1e6


def height_map(road_map: RoadMap, seed: int) -> Row:
    """CPU quantiles in ms of finding obstacles in the scans of a VLP-16 at the map's resting places."""
    rng = np.random.default_rng(seed)
    network = RoadNetwork(road_map)
    lidar = Lidar(LidarMount(), Body(), WallScene(road_map.buildings), LidarNoise())
    params, taken_ns = map_params(Profile()), []
    for number in range(_SCANS):
        place = road_map.resting_places[number % len(road_map.resting_places)]
        x_m, y_m, yaw_rad = network.pose(place.lane_id, place.s_m)
        distance_m, bearing_rad = rng.uniform(5.0, 25.0, 20), rng.uniform(-np.pi, np.pi, 20)
        people = np.column_stack(
            (
                x_m + distance_m * np.cos(bearing_rad),
                y_m + distance_m * np.sin(bearing_rad),
                np.full(20, 0.25),
                np.full(20, 1.7),
            )
        )
        points = lidar.scan(Pose2(x_m, y_m, yaw_rad), np.empty((0, 7)), people, rng)[0]
        points = np.ascontiguousarray(points)
        begun_ns = time.process_time_ns()
        percept_from_scan(points, 1, params)
        taken_ns.append(time.process_time_ns() - begun_ns)
    return _quantiles("height map of a scan", taken_ns[1:])


def lockstep(road_map: RoadMap, virtual_s: float, seed: int, *, lidar: bool) -> float:
    """Virtual seconds per CPU second, median of three stretches, after a discarded first one."""
    with tempfile.TemporaryDirectory() as folder:
        drive = SoloDrive(
            road_map, Path(folder), seed, lidar=lidar, traffic=TrafficParams() if lidar else None
        )
        drive.set_off()
        ratios = []
        for _ in range(4):
            begun = time.process_time()
            for _ in range(round(virtual_s * 50)):
                drive.step()
            ratios.append(virtual_s / (time.process_time() - begun))
        drive.vehicle.shut_down()
    return float(np.median(ratios[1:]))


def _quantiles(room: str, samples_ns: list[int]) -> Row:
    values = np.percentile(samples_ns, QUANTILES) / 1e6
    return {"room": room, **{f"p{q}_ms": float(v) for q, v in zip(QUANTILES, values, strict=True)}}


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", type=Path, help="write the report here")
    parser.add_argument("--map", type=Path, default=SHIPPED, help="campus map to drive on")
    parser.add_argument("--seconds", type=float, default=30.0, help="real-time part")
    parser.add_argument("--virtual-seconds", type=float, default=60.0, help="each lockstep stretch")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


if __name__ == "__main__":
    main()

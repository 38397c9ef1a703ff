"""Writes annotated sweeps of a simulated campus: `python -m benchmarks.pointclouds.simulated FOLDER`.

The form is that of `benchmarks.pointclouds`: NAME.pcd beside NAME.csv. They show that files are read and
figures are right; how well people are found in real streets only real sweeps tell.
"""

import argparse
import csv
from pathlib import Path

import numpy as np

from benchmarks.perception.campus_sweeps import CampusSweeps, Sweep
from contract.geometry import Array
from contract.roads.load import load_map
from contract.roads.model import RoadMap
from simulator.sensors.lidars.mounts import roof_lidar
from simulator.sensors.scene.static_scene import StaticScene
from simulator.traffic.actors import PERSON_HEIGHT_M, VEHICLE_HEIGHT_M
from vehicle_agent.config import Body
from vehicle_agent.lidar.models import MODELS
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE

_ROOT = Path(__file__).resolve().parents[2]
_NAMES = {PEDESTRIAN: "human.pedestrian.adult", CYCLIST: "vehicle.bicycle", VEHICLE: "vehicle.car"}
_COLUMNS = ("class", "x", "y", "z", "length", "width", "height", "yaw", "track")
# A box is drawn around swinging arms and legs, too.
_DRAWN_M = {PEDESTRIAN: (0.7, 0.7), CYCLIST: (1.8, 0.7), VEHICLE: (4.4, 1.9)}
_REACH_M = 45.0


def write_sweeps(
    folder: Path,
    road_map: RoadMap,
    count: int,
    model: str = "HDL-32E",
    seed: int = 1,
    apart: int = 10,
    scene: StaticScene | None = None,
) -> list[Path]:
    """`count` sweeps of a lidar on the roof, `apart` turns between them; the PCD files."""
    body = Body()
    mounted = roof_lidar(body, MODELS[model])
    sweeps = CampusSweeps(road_map, body, (mounted,), seed, turns=count * apart, scene=scene)
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for number in range(count):
        sweep = sweeps.sweep(number * apart * 100_000_000)
        path = folder / f"{seed:02d}_{number:04d}.pcd"
        place = mounted.T_base_sensor[:3, 3]
        _write_pcd(path, sweep.points_base - place.astype(np.float32), sweep.intensities)
        _write_boxes(path.with_suffix(".csv"), sweep, place)
        paths.append(path)
    return paths


def _write_pcd(path: Path, points: np.ndarray, intensities: np.ndarray) -> None:
    rows = np.column_stack((points, intensities)).astype("<f4")
    header = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\n"
        f"TYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {len(rows)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n"
        f"POINTS {len(rows)}\nDATA binary\n"
    )
    path.write_bytes(header.encode() + rows.tobytes())


def _write_boxes(path: Path, sweep: Sweep, place: Array) -> None:
    """The others around, in the frame of a lidar at `place` whose axes are those of the base."""
    pose, bodies = sweep.pose_map, sweep.bodies
    cos, sin = np.cos(pose.yaw_rad), np.sin(pose.yaw_rad)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(_COLUMNS)
        for k in range(len(bodies.numbers)):
            dx, dy = bodies.poses_map[k, 0] - pose.x_m, bodies.poses_map[k, 1] - pose.y_m
            x, y = cos * dx + sin * dy - place[0], -sin * dx + cos * dy - place[1]
            if np.hypot(x, y) > _REACH_M:
                continue
            kind = int(bodies.kinds[k])
            height = VEHICLE_HEIGHT_M if kind == VEHICLE else PERSON_HEIGHT_M + 0.1
            row = (
                x,
                y,
                0.5 * height - place[2],
                *_DRAWN_M[kind],
                height,
                bodies.poses_map[k, 2] - pose.yaw_rad,
            )
            writer.writerow([_NAMES[kind], *(f"{float(value):.3f}" for value in row), int(bodies.numbers[k])])


def main() -> None:
    parser = argparse.ArgumentParser(prog="benchmarks.pointclouds.simulated", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--map", type=Path, default=_ROOT / "maps/shanghai-university/map.json")
    parser.add_argument("--sweeps", type=int, default=20)
    parser.add_argument("--model", choices=sorted(MODELS), default="HDL-32E")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    write_sweeps(arguments.folder, load_map(arguments.map), arguments.sweeps, arguments.model, arguments.seed)


if __name__ == "__main__":
    main()

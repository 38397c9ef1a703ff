"""A drive over a campus among people and vehicles, for sensors that move while they scan."""

import math

import numpy as np

from contract.geometry import Array
from contract.roads.model import Lane, RoadMap
from simulator.sensors.scene.ground import Ground
from simulator.traffic.actors import Bodies
from vehicle_agent.signals import PEDESTRIAN, VEHICLE

# A vehicle on real ground rolls and pitches a little.
_ROLL_RAD, _PITCH_RAD = 0.008, 0.006


def way_over(road_map: RoadMap, length_m: float, rng: np.random.Generator) -> Array:
    """(n, 2) points of lanes that follow each other, at least length_m long; lanes are drawn."""
    lanes = {lane.lane_id: lane for lane in road_map.lanes}
    names = sorted(lanes)
    for _ in range(100):
        lane: Lane | None = lanes[names[int(rng.integers(len(names)))]]
        points: list[tuple[float, float]] = []
        way_m, visited = 0.0, set()
        while lane is not None and way_m < length_m:
            visited.add(lane.lane_id)
            points += lane.points[1:] if points else lane.points
            way_m = float(np.hypot(*np.diff(np.array(points), axis=0).T).sum())
            onward = [
                name for name in lane.successors if name not in visited and lanes[name].kind != "turnaround"
            ]
            lane = lanes[onward[int(rng.integers(len(onward)))]] if onward else None
        if way_m >= length_m:
            return np.array(points)
    raise SystemExit(f"the map has no way of {length_m:.0f} m without a turnaround")


class Drive:
    """Along a way at one speed; poses at any time."""

    def __init__(self, way: Array, ground: Ground, speed_mps: float, wheelbase_m: float) -> None:
        steps = np.hypot(*np.diff(way, axis=0).T)
        keep = np.concatenate(([True], steps > 1e-6))
        self._way = way[keep]
        self._s = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(self._way, axis=0).T))))
        ahead = np.gradient(self._way, axis=0)
        self._yaw = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))
        self._ground, self._speed_mps, self._wheelbase_m = ground, speed_mps, wheelbase_m
        self.duration_s = float(self._s[-1]) / speed_mps

    def pose(self, time_s: float) -> Array:
        """(3,) x, y, yaw."""
        return self._places(np.array([time_s]))[0]

    def poses(self, times_ns: np.ndarray) -> Array:
        """(n, 4, 4) T_map_base."""
        times_s = times_ns * 1e-9
        poses = self._ground.poses(self._places(times_s), self._wheelbase_m)
        roll, pitch = _ROLL_RAD * np.sin(7.0 * times_s), _PITCH_RAD * np.sin(5.0 * times_s + 1.0)
        swaying: Array = np.tile(np.eye(4), (len(times_s), 1, 1))
        swaying[:, 1, 1] = swaying[:, 2, 2] = np.cos(roll)
        swaying[:, 2, 1], swaying[:, 1, 2] = np.sin(roll), -np.sin(roll)
        pitching: Array = np.tile(np.eye(4), (len(times_s), 1, 1))
        pitching[:, 0, 0] = pitching[:, 2, 2] = np.cos(pitch)
        pitching[:, 0, 2], pitching[:, 2, 0] = np.sin(pitch), -np.sin(pitch)
        moved: Array = poses @ pitching @ swaying
        return moved

    def _places(self, times_s: Array) -> Array:
        s = np.clip(self._speed_mps * times_s, 0.0, self._s[-1])
        columns = (self._way[:, 0], self._way[:, 1], self._yaw)
        return np.column_stack([np.interp(s, self._s, column) for column in columns])


def others_around(pose: Array, time_s: float, people: int, vehicles: int) -> Bodies:
    """People who walk beside the way, and vehicles that come along it; always about as near."""
    count = people + vehicles
    number = np.arange(count)
    is_person = number < people
    bearing = 2.399963 * number
    apart = np.where(is_person, 4.0 + 1.1 * number, 9.0 + 6.0 * (number - people))
    turn = bearing + np.where(is_person, 0.05, 0.02) * time_s
    poses = np.column_stack(
        (pose[0] + apart * np.cos(turn), pose[1] + apart * np.sin(turn), turn + 0.5 * math.pi)
    )
    speeds = np.where(is_person, 1.2, 3.0)
    velocities = speeds[:, None] * np.column_stack((np.cos(poses[:, 2]), np.sin(poses[:, 2])))
    sizes = np.where(is_person[:, None], np.array([0.5, 0.5]), np.array([4.3, 1.8]))
    kinds = np.where(is_person, PEDESTRIAN, VEHICLE).astype(np.int64)
    return Bodies(number.astype(np.int64), kinds, poses, velocities, sizes)

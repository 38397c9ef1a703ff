"""The road map as a Foxglove scene: what a run is seen on, told once at the beginning of each segment."""

import numpy as np

from contract.geometry import Pose2
from contract.roads.model import Lane, RoadMap
from contract.runlog.foxglove import Entity, Primitive, entity, line, rgba, scene_update, text, timestamp

_LANE = rgba(0.45, 0.5, 0.55, 0.8)
_WALL = rgba(0.6, 0.5, 0.4, 0.9)
_AREA = rgba(0.5, 0.6, 0.8, 0.6)
_STOP_LINE = rgba(0.9, 0.9, 0.9, 0.9)
_STOP = rgba(0.2, 0.5, 0.9, 1.0)
# Lanes are drawn with few points: a new one after so much of a turn or so long a way, within 0.15 m.
_TURN_RAD, _PIECE_M = 0.05, 20.0


class MapScene:
    """One map as a SceneUpdate: lanes, buildings, observation areas with their stop lines, and stops."""

    def __init__(self, road_map: RoadMap) -> None:
        lanes = {lane.lane_id: lane for lane in road_map.lanes}
        walls = [line(np.array(one.outline), _WALL, closed=True) for one in road_map.buildings]
        areas = [line(np.array(one.outline), _AREA, closed=True) for one in road_map.observation_areas]
        places = [place for area in road_map.observation_areas for place in area.stop_lines]
        bars = [_bar(lanes[lane_id], s_m) for lane_id, s_m in places]
        names = []
        for stop in road_map.stops:
            x_m, y_m, _ = _pose(lanes[stop.lane_id], stop.s_m)
            names.append(text(Pose2(x_m, y_m, 0.0), 0.5, stop.name_en or stop.name, _STOP, size_m=1.5))
        self._entities: list[Entity] = [
            entity(0, "lanes", lifetime_s=0, lines=[_lane(lane) for lane in lanes.values()]),
            entity(0, "buildings", lifetime_s=0, lines=walls),
            entity(0, "observation areas", lifetime_s=0, lines=[*areas, *bars]),
            entity(0, "stops", lifetime_s=0, texts=names),
        ]

    def at(self, utc_ns: int) -> bytes:
        """The message as of a moment."""
        now = timestamp(utc_ns)
        return scene_update([{**one, "timestamp": now} for one in self._entities])


def _lane(lane: Lane) -> Primitive:
    return line(_thinned(np.array(lane.points)), _LANE, thickness_m=0.08, z_m=0.0)


def _thinned(points: np.ndarray) -> np.ndarray:
    """(n, 2) -> (k, 2), both ends kept."""
    pieces = np.diff(points, axis=0)
    turned = np.cumsum(np.abs(np.diff(np.unwrap(np.arctan2(pieces[:, 1], pieces[:, 0])), prepend=0.0)))
    gone = np.cumsum(np.hypot(pieces[:, 0], pieces[:, 1]))
    steps = np.floor(turned / _TURN_RAD) + np.floor(gone / _PIECE_M)
    kept = np.concatenate(([True], np.diff(steps) > 0.0, [True]))
    shown: np.ndarray = points[kept]
    return shown


def _pose(lane: Lane, s_m: float) -> tuple[float, float, float]:
    """In plain numpy: the process that writes run logs need not load the kernels."""
    points = np.array(lane.points)
    pieces = np.diff(points, axis=0)
    s = np.concatenate(([0.0], np.cumsum(np.hypot(pieces[:, 0], pieces[:, 1]))))
    along = pieces[min(int(np.searchsorted(s, s_m, side="right")), len(pieces)) - 1]
    x_m, y_m = (float(np.interp(s_m, s, points[:, axis])) for axis in (0, 1))
    return x_m, y_m, float(np.arctan2(along[1], along[0]))


def _bar(lane: Lane, s_m: float) -> Primitive:
    """A stop line across its lane."""
    x_m, y_m, yaw_rad = _pose(lane, s_m)
    across = lane.width_m / 2.0 * np.array([-np.sin(yaw_rad), np.cos(yaw_rad)])
    middle = np.array([x_m, y_m])
    return line(np.array([middle - across, middle + across]), _STOP_LINE, thickness_m=0.2)

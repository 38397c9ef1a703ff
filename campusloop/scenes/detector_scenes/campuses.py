"""The campuses of the detector's scenes, and which of them it never learns from."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from campusloop.shipped import SHIPPED_MAPS
from contract.geometry import Array
from contract.roads.load import load_map
from contract.roads.model import RoadMap
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.ground import GroundParams
from simulator.sensors.scene.static_scene import StaticScene

Split = Literal["train", "tune", "held-out"]

_SHANGHAI, _SNOW_LION = SHIPPED_MAPS
# Scenes for learning are west of the first line, held-out ones east of the second: no scan shows both.
_WEST_M, _EAST_M = 150.0, 270.0


@dataclass(frozen=True, slots=True)
class Campus:
    """A map, the seed of its surroundings, and the part of it where scans are taken (x, map frame)."""

    campus_map: Path
    seed: int
    x_m: tuple[float, float]


CAMPUSES: dict[Split, tuple[Campus, ...]] = {
    "train": tuple(Campus(_SHANGHAI, seed, (-1e6, _WEST_M)) for seed in range(1, 6)),
    "tune": (Campus(_SHANGHAI, 51, (-1e6, _WEST_M)),),
    "held-out": (Campus(_SHANGHAI, 101, (_EAST_M, 1e6)), Campus(_SNOW_LION, 102, (-1e6, 1e6))),
}


class CampusScene:
    """One campus with its surroundings, and the places on its lanes."""

    def __init__(self, campus: Campus) -> None:
        """Raises SceneError, MapError."""
        road_map = load_map(campus.campus_map)
        rng = np.random.default_rng([campus.seed, *b"detector campus"])
        changes = WorldChanges(
            seed=campus.seed, parked_ratio=float(rng.uniform(0.25, 0.6)), trucks_ratio=0.15, works=6,
            trees_felled_ratio=float(rng.uniform(0.0, 0.3)),
        )  # fmt: skip
        ground = GroundParams(grade_ratio=float(rng.uniform(0.008, 0.02)))
        self.static = StaticScene(road_map, campus.seed, changes, ground)
        self.lanes = _places(road_map)
        self._inside = (self.lanes[:, 0] >= campus.x_m[0]) & (self.lanes[:, 0] <= campus.x_m[1])

    def draw_place(self, rng: np.random.Generator) -> Array:
        """(3,) x, y, yaw near a lane's middle, mostly along it."""
        place: Array = self.lanes[self._inside][rng.integers(int(self._inside.sum()))].copy()
        place[2] += rng.normal(0.0, 0.08)
        side_m = rng.normal(0.0, 0.4)
        place[0] -= side_m * np.sin(place[2])
        place[1] += side_m * np.cos(place[2])
        return place


def _places(road_map: RoadMap) -> Array:
    """(n, 3) x, y, yaw about every metre along the lanes."""
    places = []
    for lane in road_map.lanes:
        points = np.array(lane.points)[:, :2]
        steps = np.hypot(*np.diff(points, axis=0).T)
        points = points[np.concatenate(([True], steps > 1e-6))]
        if len(points) < 2:
            continue
        s = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
        at = np.arange(0.5, s[-1], 1.0)
        x, y = np.interp(at, s, points[:, 0]), np.interp(at, s, points[:, 1])
        ahead_x = np.interp(at + 0.5, s, points[:, 0]) - np.interp(at - 0.5, s, points[:, 0])
        ahead_y = np.interp(at + 0.5, s, points[:, 1]) - np.interp(at - 0.5, s, points[:, 1])
        places.append(np.column_stack((x, y, np.arctan2(ahead_y, ahead_x))))
    return np.vstack(places)

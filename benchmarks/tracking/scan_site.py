"""A place on a shipped campus where a curve can be driven, and what surveys of it map."""

import math
from pathlib import Path

import numpy as np
import shapely

from benchmarks.localization.planar_drive import tiles_of_way
from benchmarks.localization.scan_drive import map_of_way
from benchmarks.localization.sensed_drive import MAP_DAY, SCENE_SEED
from benchmarks.mapping.campus_drive import TICK_S, Trace
from benchmarks.tracking.reference_paths import ReferencePath
from contract.geometry import Array, Pose2, arc_lengths, resample
from contract.point_map.tiles import Surfels
from contract.roads.load import load_map
from contract.roads.model import RoadMap
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.static_scene import StaticScene
from simulator.sensors.scene_lidars import SceneOptions
from vehicle_agent.config import Profile
from vehicle_agent.localization.planar_map.field_window import OccupancyTiles
from workshop.laser_mapping.site_mapping import SiteMappingParams

_MAP = Path(__file__).resolve().parents[2] / "maps" / "shanghai-university" / "map.json"
_SURVEY_MPS = 3.0
# Beside the curve, for a body 1.6 m wide.
_CLEAR_M = 2.5
# From everywhere on the curve so much of the horizon has something that stands so near.
_SEEN_M, _SEEN_RATIO = 60.0, 0.25
_TRIES = 50_000
_LOOK_EVERY_M = 2.0
_LOOKS = 32
# Bumpers and parked vehicles; walls and trunks as a lidar on the roof sees them.
_LOW_EYE_M, _HIGH_EYE_M = 0.8, 2.2
_SITE = SiteMappingParams()


class NoPlace(Exception):
    """The curve has no room on the campus."""


class ScanSite:
    """A curve's place. The map's day and that of the drives have other parked vehicles, noise and receivers.

    path  the curve, map frame; options: of the scene on the day of the drives
    """

    def __init__(self, road_map: RoadMap, path: ReferencePath, seed: int) -> None:
        self.road_map, self.path, self.options = road_map, path, _drive_day(seed)
        self._seed = seed

    def surfaces(self) -> dict[tuple[int, int], Surfels]:
        """Tiles of a point map, of a survey with the Snow Lion's lidar."""
        return map_of_way(self.road_map, self._surveyed(), self._seed)

    def occupancy(self, profile: Profile) -> OccupancyTiles:
        """Of a survey with the profile's planar scanner."""
        tiles = tiles_of_way(self.road_map, self._surveyed(), profile, self._seed).tiles
        return OccupancyTiles(
            lambda ix, iy: tiles.get((ix, iy)), _SITE.tile_m, _SITE.occupancy.cell_m, tuple(tiles)
        )

    def _surveyed(self) -> Trace:
        """The whole curve, driven exactly."""
        path = self.path
        s_m = np.arange(0.0, path.length_m, _SURVEY_MPS * TICK_S)
        x_m, y_m = (np.interp(s_m, path.s, column) for column in path.points.T)
        yaw_rad = np.unwrap(np.arctan2(np.gradient(y_m), np.gradient(x_m)))
        speed_mps = np.full(len(s_m), _SURVEY_MPS)
        return Trace(x_m, y_m, yaw_rad, speed_mps, np.gradient(yaw_rad, TICK_S), s_m)


def scan_site(path: ReferencePath, seed: int = 1) -> ScanSite:
    """The first of places drawn from the seed where nothing stands beside the curve on either day and a lidar
    sees walls and trees from everywhere on it. Raises NoPlace."""
    road_map = load_map(_MAP)
    drive_day = _drive_day(seed)
    days = (drive_day.changes, WorldChanges(seed=MAP_DAY + seed))
    scenes = [StaticScene(road_map, drive_day.seed, changes) for changes in days]
    outlines = [np.asarray(one.outline, dtype=np.float64) for one in road_map.buildings]
    buildings = shapely.union_all([shapely.Polygon(outline).buffer(0.0) for outline in outlines])
    shapely.prepare(buildings)
    left, bottom, right, top = buildings.bounds
    rng, thin = np.random.default_rng([seed, 23]), resample(path.points, _LOOK_EVERY_M)
    for _ in range(_TRIES):
        x_m, y_m = float(rng.uniform(left, right)), float(rng.uniform(bottom, top))
        place = Pose2(x_m, y_m, float(rng.uniform(-math.pi, math.pi)))
        looked = _placed(thin, place)
        apart_m = float(shapely.distance(buildings, shapely.LineString(looked)))
        if _CLEAR_M < apart_m < _SEEN_M and all(_is_usable(scene, looked) for scene in scenes):
            points = _placed(path.points, place)
            return ScanSite(
                road_map, ReferencePath(path.name, points, arc_lengths(points), path.closed), seed
            )
    raise NoPlace(f"no place for {path.name} with {_CLEAR_M:g} m to either side, of {_TRIES} tried")


def _drive_day(seed: int) -> SceneOptions:
    return SceneOptions(seed=SCENE_SEED, changes=WorldChanges(seed=seed))


def _placed(points: Array, place: Pose2) -> Array:
    cos, sin = math.cos(place.yaw_rad), math.sin(place.yaw_rad)
    placed: Array = points @ np.array([[cos, sin], [-sin, cos]]) + (place.x_m, place.y_m)
    return placed


def _is_usable(scene: StaticScene, points: Array) -> bool:
    """Whether nothing hinders a vehicle on the curve, and its lidar sees enough."""
    if (_seen_m(scene, points, _LOW_EYE_M, _CLEAR_M) < _CLEAR_M).any():
        return False
    far_m = _seen_m(scene, points, _HIGH_EYE_M, _SEEN_M)
    return bool((far_m >= _CLEAR_M).all() and ((far_m < _SEEN_M).mean(axis=1) >= _SEEN_RATIO).all())


def _seen_m(scene: StaticScene, points: Array, eye_m: float, reach_m: float) -> Array:
    """(n, _LOOKS) how far level rays go from each point (n, 2), at most reach_m."""
    turns = np.linspace(0.0, 2.0 * math.pi, _LOOKS, endpoint=False)
    around = np.column_stack((np.cos(turns), np.sin(turns), np.zeros(_LOOKS)))
    eyes = np.column_stack((points, scene.ground.height_m(points[:, 0], points[:, 1]) + eye_m))
    origins = np.ascontiguousarray(np.repeat(eyes, _LOOKS, axis=0), dtype=np.float32)
    directions = np.ascontiguousarray(np.tile(around, (len(eyes), 1)), dtype=np.float32)
    ranges_m, hits = scene.cast(origins, directions, np.full(len(origins), reach_m, dtype=np.float32))
    seen_m: Array = np.where(hits >= 0, ranges_m, reach_m).reshape(len(points), _LOOKS)
    return seen_m

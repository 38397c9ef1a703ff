"""The ground: gentle hills, roads with a crown, kerbs, pavements, grass."""

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from contract.geometry import Array
from contract.roads.model import RoadMap
from simulator.sensors.scene.changes import SceneError
from simulator.sensors.scene.ground_heights import edges_at, hills_at, wheel_poses

# Nodes of the grid on which the distance to the road's edge is known.
CELL_M = 1.0
# So far from the road the grid is fine enough for kerbs.
_MARGIN_M = 3.0
# Beyond the outermost lane or wall.
_BORDER_M = 60.0
_FAR_M = -_MARGIN_M
_HILLS = 7


@dataclass(frozen=True, slots=True)
class GroundParams:
    """Shape of the ground.

    grade_ratio      root mean square of the hills' slope; 0.0 for a flat campus
    crown_ratio      fall of the road from its middle to its edges
    crown_half_m     farther from the edge the road is level across
    kerb_m           height of the pavement above the road's edge; at crossings it is lowered
    lowered_kerb_m   there
    """

    grade_ratio: float = 0.012
    crown_ratio: float = 0.02
    crown_half_m: float = 3.5
    kerb_m: float = 0.12
    lowered_kerb_m: float = 0.02

    def __post_init__(self) -> None:
        """Raises SceneError for a slope of more than 10 %, or a negative height."""
        if not (0.0 <= self.grade_ratio <= 0.1 and 0.0 <= self.crown_ratio <= 0.1):
            raise SceneError("grade_ratio and crown_ratio must be 0 to 0.1")
        if not (0.0 <= self.lowered_kerb_m <= self.kerb_m <= 0.5 and self.crown_half_m >= 0.0):
            raise SceneError("kerbs must be 0 to 0.5 m high, lowered ones not higher than the others")


class Ground:
    """Heights of one map's ground, map frame; the same for the same map, seed and parameters.

    road      the roads' outline
    corner    (2,) x, y of the grid's first node
    inside_m  (ny, nx) distance of each node to the road's edge, positive on the road, -3 far from it
    """

    def __init__(self, road_map: RoadMap, seed: int, params: GroundParams | None = None) -> None:
        """Raises SceneError for a map without lanes."""
        if not road_map.lanes:
            raise SceneError("a map without lanes has no ground to build")
        self.params = params or GroundParams()
        self.road = road_outline(road_map)
        places = [np.array(lane.points) for lane in road_map.lanes]
        places += [np.array(building.outline) for building in road_map.buildings]
        every = np.vstack(places)
        self.corner: Array = np.floor(every.min(axis=0) - _BORDER_M)
        spans = np.ceil((every.max(axis=0) + _BORDER_M - self.corner) / CELL_M).astype(int)
        # A multiple of the coarse cells of the mesh.
        self._nx, self._ny = (int(4 * math.ceil(span / 4) + 1) for span in spans)
        self._hills = _hills(np.random.default_rng([seed, *b"hills"]), self.params.grade_ratio)
        self._crossings = _crossings(road_map)
        self.inside_m = self._edge_distances(road_map)

    def _edge_distances(self, road_map: RoadMap) -> NDArray[np.float32]:
        inside: NDArray[np.float32] = np.full((self._ny, self._nx), _FAR_M, dtype=np.float32)
        rows, columns = self._nodes_near(road_map)
        x, y = self.corner[0] + CELL_M * columns, self.corner[1] + CELL_M * rows
        distance = np.minimum(distances_to_edge(self.road, np.column_stack((x, y))), 1e3)
        on_road = shapely.contains_xy(self.road, x, y)
        inside[rows, columns] = np.where(on_road, distance, np.maximum(-distance, _FAR_M))
        return inside

    def _nodes_near(self, road_map: RoadMap) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        marked = np.zeros((self._ny, self._nx), dtype=bool)
        for width in sorted({lane.width_m for lane in road_map.lanes}):
            points = np.vstack([lane.points for lane in road_map.lanes if lane.width_m == width])
            reach = math.ceil((0.5 * width + _MARGIN_M + 0.5) / CELL_M)
            place = np.unique(np.rint((points - self.corner) / CELL_M).astype(np.int64), axis=0)
            steps = np.arange(-reach, reach + 1)
            across, up = (axis.ravel() for axis in np.meshgrid(steps, steps))
            marked[(place[:, 1, None] + up).ravel(), (place[:, 0, None] + across).ravel()] = True
        rows, columns = np.nonzero(marked)
        return rows, columns

    def terrain_m(self, x: Array, y: Array) -> Array:
        """(n,) height of the hills alone."""
        return hills_at(_flat(x), _flat(y), self._hills).reshape(np.shape(x))

    def inside_at(self, x: Array, y: Array) -> Array:
        """(n,) distance to the road's edge by the grid, m; positive on the road."""
        return edges_at(_flat(x), _flat(y), self.corner, CELL_M, self.inside_m).reshape(np.shape(x))

    def road_m(self, x: Array, y: Array, inside_m: Array | None = None) -> Array:
        """(n,) height of the road's surface; beyond its edge that of the edge."""
        depth = self.inside_at(x, y) if inside_m is None else inside_m
        crown = self.params.crown_ratio * np.clip(depth, 0.0, self.params.crown_half_m)
        surface: Array = self.terrain_m(x, y) + crown
        return surface

    def pavement_m(self, x: Array, y: Array) -> Array:
        """(n,) height of the pavement and of the grass behind it."""
        params = self.params
        height = np.full(np.shape(x), params.kerb_m)
        if self._crossings is not None and len(height):
            apart, _ = self._crossings.query(np.column_stack((x, y)), distance_upper_bound=8.0)
            share = np.clip((np.minimum(apart, 8.0) - 3.0) / 1.5, 0.0, 1.0)
            height = params.lowered_kerb_m + share * (params.kerb_m - params.lowered_kerb_m)
        raised: Array = self.terrain_m(x, y) + height
        return raised

    def height_m(self, x: Array, y: Array) -> Array:
        """(n,) height of what is there: road or pavement."""
        inside = self.inside_at(x, y)
        there: Array = np.where(inside > 0.0, self.road_m(x, y, inside), self.pavement_m(x, y))
        return there

    def poses(self, poses_map: Array, wheelbase_m: float = 2.6, track_m: float = 1.2) -> Array:
        """(n, 4, 4) T_map_base of vehicles whose wheels stand on the road.

        poses_map  (n, 3) x, y, yaw of the rear-axle centre
        The base's origin is on the ground below the rear axle. Springs are left out.
        """
        rows = np.ascontiguousarray(poses_map, dtype=np.float64).reshape(-1, 3)
        crown = (self.params.crown_ratio, self.params.crown_half_m)
        return wheel_poses(rows, wheelbase_m, track_m, self._hills, self.corner, CELL_M, self.inside_m, crown)


def road_outline(road_map: RoadMap) -> shapely.Geometry:
    """The union of all lanes, with gaps of less than a metre closed."""
    lanes = [
        shapely.LineString(lane.points).buffer(0.5 * lane.width_m, quad_segs=4) for lane in road_map.lanes
    ]
    return shapely.union_all(lanes).buffer(0.6, quad_segs=4).buffer(-0.6, quad_segs=4).simplify(0.02)


def edge_segments(outline: shapely.Geometry) -> Array:
    """(n, 4) x0, y0, x1, y1 of an outline's rings."""
    rings = shapely.get_rings(shapely.get_parts(outline))
    lines = [shapely.get_coordinates(ring) for ring in rings]
    return np.vstack([np.hstack((line[:-1], line[1:])) for line in lines])


def distances_to_edge(outline: shapely.Geometry, points: Array) -> Array:
    """(n,) from points (n, 2) to the nearest edge."""
    segments = edge_segments(outline)
    lengths = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    counts = np.maximum(1, np.ceil(lengths / 0.25)).astype(int)
    owner = np.repeat(np.arange(len(segments)), counts)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = (rank + 0.5) / counts[owner]
    samples = segments[owner, :2] + share[:, None] * (segments[owner, 2:] - segments[owner, :2])
    _, nearest = cKDTree(samples).query(points)
    chosen = segments[owner[nearest]]
    along = chosen[:, 2:] - chosen[:, :2]
    squared = np.maximum((along**2).sum(axis=1), 1e-12)
    foot = np.clip(((points - chosen[:, :2]) * along).sum(axis=1) / squared, 0.0, 1.0)
    distance: Array = np.linalg.norm(points - chosen[:, :2] - foot[:, None] * along, axis=1)
    return distance


def _flat(values: Array) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64).ravel()


def _hills(rng: np.random.Generator, grade_ratio: float) -> Array:
    """(k, 4) waves of 90 m to 400 m: wave numbers along x and y, phase, amplitude."""
    lengths = np.exp(rng.uniform(math.log(90.0), math.log(400.0), _HILLS))
    bearings, phases = rng.uniform(0.0, 2.0 * math.pi, (2, _HILLS))
    number = 2.0 * math.pi / lengths
    # Equal shares of the slope's variance: amplitude^2 k^2 / 2 each.
    amplitudes = grade_ratio * math.sqrt(2.0 / _HILLS) / number
    return np.column_stack((number * np.cos(bearings), number * np.sin(bearings), phases, amplitudes))


def _crossings(road_map: RoadMap) -> cKDTree | None:
    places = [
        np.array(area.outline).mean(axis=0) for area in road_map.observation_areas if area.kind == "crossing"
    ]
    return cKDTree(np.array(places)) if places else None

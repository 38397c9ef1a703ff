"""Loop closure: where the laser comes back to a place, found by searching for one submap in another.

Submaps are taken in the order of the drive. Each is searched in the older ones that it may overlap. The
window grows with the shortest way in the graph between the two, on which dead reckoning drifts. A found
pose counts if most points lie on the other's lines and few lie in the other's free space, both ways round.
"""

from collections.abc import Callable

import msgspec
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from contract.geometry import Array
from vehicle_agent.localization.laser.correlation import Raster, SearchWindow, correlate, rasterized
from vehicle_agent.localization.laser.point_index import PointIndex, index_points
from vehicle_agent.localization.laser.point_to_line import MatchParams, match_to_lines
from vehicle_agent.localization.laser.pose_arrays import between, composed
from vehicle_agent.localization.laser.surfaces import Surface
from workshop.laser_mapping.keyframes import Keyframes
from workshop.laser_mapping.pose_graph import Edge, GraphParams, optimized
from workshop.laser_mapping.submaps import (
    FreeSpace,
    contradicting_ratio,
    free_space,
    joined_surface,
    thinned,
)


class LoopParams(msgspec.Struct, frozen=True):
    """How loops are found and which are believed.

    submap_m                   length of the way that makes a submap
    reach_m                    points farther than this from a submap's middle are left out
    window_m, window_rad       half the searched window of two submaps that lie side by side in the graph
    drift_ratio, drift_radpm   what is added for each metre of the way between them
    window_m_max, window_rad_max
    older_submaps              at least so many submaps lie between two that are compared
    rounds                     how often all submaps are taken: a loop that is closed late shows others
    tried_max, closed_max      in one round, older submaps that are searched for one submap, and loops closed
    score_min                  least mean nearness of the search
    inlier_ratio_min           least share of points on the other's lines, of those in known space
    contradicting_ratio_max    greatest share of points in the other's free space
    known_ratio_min            least share of points in space that the other knows
    """

    submap_m: float = 4.0
    reach_m: float = 15.0
    window_m: float = 0.6
    window_rad: float = 0.09
    drift_ratio: float = 0.03
    drift_radpm: float = 0.005
    window_m_max: float = 10.0
    window_rad_max: float = 0.7
    older_submaps: int = 2
    rounds: int = 2
    tried_max: int = 6
    closed_max: int = 3
    thinned_m: float = 0.15
    cell_m: float = 0.1
    score_min: float = 0.4
    inlier_ratio_min: float = 0.5
    contradicting_ratio_max: float = 0.12
    known_ratio_min: float = 0.45
    match: MatchParams = MatchParams()
    graph: GraphParams = GraphParams(chi2_scale=40.0, iterations_max=10)


class Loops(msgspec.Struct, frozen=True):
    """poses (k, 3) of the keyframes with all loops closed; edges: the loops that are believed."""

    poses: Array
    edges: tuple[Edge, ...]
    tried: int


class _Target(msgspec.Struct, frozen=True):
    """A submap with its neighbours, ready to be searched."""

    raster: Raster
    index: PointIndex
    free: FreeSpace


class _Query(msgspec.Struct, frozen=True):
    surface: Surface
    free: FreeSpace


class LoopSearch:
    """The submaps of one drive and the loops closed so far."""

    def __init__(self, keyframes: Keyframes, params: LoopParams) -> None:
        self._keyframes = keyframes
        self._params = params
        self._bounds = _submap_bounds(keyframes.poses, params.submap_m)
        self._middles = [(first + last) // 2 for first, last in self._bounds]
        self._targets: dict[int, _Target] = {}
        self._poses = keyframes.poses.copy()
        self._loops: list[Edge] = []
        self._closed: list[tuple[int, int]] = []
        self._tried: set[tuple[int, int]] = set()

    @property
    def submaps(self) -> int:
        return len(self._bounds)

    @property
    def steps(self) -> int:
        """How often `run` advances."""
        return self._params.rounds * self.submaps

    def run(self, advance: Callable[[int], None]) -> Loops:
        """Close the loops of all submaps in turn."""
        for _ in range(self._params.rounds):
            for number in range(self.submaps):
                self._close(number)
                advance(1)
        return Loops(self._poses, tuple(self._loops), len(self._tried))

    def _close(self, number: int) -> None:
        params = self._params
        query: _Query | None = None
        closed = 0
        for _ in range(params.tried_max):
            candidate = self._candidate(number)
            if candidate is None or closed == params.closed_max:
                break
            other, window = candidate
            self._tried.add((number, other))
            query = query or self._query(number)
            edge = self._edge(number, other, query, window)
            if edge is None:
                continue
            self._loops.append(edge)
            self._closed.append((number, other))
            closed += 1
        if closed:
            # Later keyframes have only edges of dead reckoning: they follow as they lie.
            graph = optimized(self._poses, [*self._keyframes.edges, *self._loops], params.graph)
            self._poses = graph.poses

    def _candidate(self, number: int) -> tuple[int, SearchWindow] | None:
        """The nearest older submap that may overlap and has not been tried."""
        params = self._params
        ways_m = self._ways_m(number)
        middles = self._poses[self._middles]
        apart_m = np.hypot(middles[:, 0] - middles[number, 0], middles[:, 1] - middles[number, 1])
        best: tuple[float, int] | None = None
        for other in range(number - params.older_submaps):
            reach_m = min(params.window_m + params.drift_ratio * ways_m[other], params.window_m_max)
            if (number, other) in self._tried or apart_m[other] > reach_m + params.submap_m:
                continue
            if best is None or apart_m[other] < best[0]:
                best = (float(apart_m[other]), other)
        if best is None:
            return None
        way_m = float(ways_m[best[1]])
        return best[1], SearchWindow(
            min(params.window_m + params.drift_ratio * way_m, params.window_m_max),
            min(params.window_rad + params.drift_radpm * way_m, params.window_rad_max),
        )

    def _ways_m(self, number: int) -> Array:
        """(submaps,) the shortest way in the graph to each submap; a loop counts little."""
        count = self.submaps
        chain = np.arange(count - 1)
        first = np.concatenate([chain, [a for a, _ in self._closed]]).astype(np.int64)
        last = np.concatenate([chain + 1, [b for _, b in self._closed]]).astype(np.int64)
        lengths = np.concatenate([np.full(count - 1, self._params.submap_m), np.full(len(self._closed), 1.0)])
        graph = csr_matrix((lengths, (first, last)), shape=(count, count))
        ways: Array = dijkstra(graph, directed=False, indices=number)
        return ways

    def _edge(self, number: int, other: int, query: _Query, window: SearchWindow) -> Edge | None:
        """The loop from the older submap's middle to the newer one's, if it is believed."""
        params = self._params
        target = self._target(other)
        from_, to = self._middles[other], self._middles[number]
        start = between(self._poses[from_], self._poses[to])
        sparse = thinned(query.surface, 2.0 * params.thinned_m, params.reach_m)
        found = correlate(sparse.points_laser, target.raster, start, window, np.array([0.05, 0.05]))
        if found.score < params.score_min:
            return None
        match = match_to_lines(query.surface, target.index, found.pose, np.zeros((3, 3)), params.match)
        points = _moved(query.surface.points_laser, match.pose)
        contradicting, known = contradicting_ratio(points, target.free)
        if known < params.known_ratio_min or contradicting > params.contradicting_ratio_max:
            return None
        if match.inlier_ratio < params.inlier_ratio_min * known:
            return None
        back = between(match.pose, np.zeros(3))
        contradicting, known = contradicting_ratio(_moved(target.index.points, back), query.free)
        if contradicting > params.contradicting_ratio_max:
            return None
        return Edge(from_, to, match.pose, match.information, True)

    def _query(self, number: int) -> _Query:
        first, last = self._bounds[number]
        poses, surfaces = self._poses[first:last], self._keyframes.surfaces[first:last]
        anchor = self._poses[self._middles[number]]
        params = self._params
        surface = joined_surface(poses, surfaces, anchor)
        return _Query(
            thinned(surface, params.thinned_m, params.reach_m),
            free_space(poses, surfaces, anchor, params.cell_m, params.reach_m),
        )

    def _target(self, number: int) -> _Target:
        """Kept: dead reckoning between three neighbours does not change much when loops are closed."""
        if number not in self._targets:
            params = self._params
            first = self._bounds[max(0, number - 1)][0]
            last = self._bounds[min(self.submaps - 1, number + 1)][1]
            poses, surfaces = self._poses[first:last], self._keyframes.surfaces[first:last]
            anchor = self._poses[self._middles[number]]
            surface = joined_surface(poses, surfaces, anchor)
            surface = thinned(surface, 0.5 * params.cell_m, 1.5 * params.reach_m)
            self._targets[number] = _Target(
                rasterized(surface.points_laser, params.cell_m, params.cell_m, 1.0),
                index_points(surface.points_laser, surface.normals_laser, params.match.distance_m_first),
                free_space(poses, surfaces, anchor, params.cell_m, params.reach_m),
            )
        return self._targets[number]


def _submap_bounds(poses: Array, length_m: float) -> list[tuple[int, int]]:
    """[first, last) keyframes of each submap. Turning in place counts as 1 m for each radian."""
    ways = between(poses[:-1], poses[1:])
    steps = np.maximum(np.hypot(ways[:, 0], ways[:, 1]), np.abs(ways[:, 2]))
    numbers = np.floor(np.concatenate([[0.0], np.cumsum(steps)]) / length_m).astype(np.int64)
    firsts = np.flatnonzero(np.concatenate([[True], numbers[1:] > numbers[:-1]]))
    lasts = np.append(firsts[1:], len(poses))
    return [(int(first), int(last)) for first, last in zip(firsts, lasts, strict=True)]


def _moved(points_b: Array, T_a_b: Array) -> Array:
    """(n, 2) points of frame b in frame a."""
    poses_b = np.concatenate([points_b, np.zeros((len(points_b), 1))], axis=1)
    moved: Array = composed(T_a_b, poses_b)[:, :2]
    return moved

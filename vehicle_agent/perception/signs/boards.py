"""The boards that one scan shows: clusters of reflecting points that can be a sign's."""

import msgspec
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from contract.geometry import Array
from vehicle_agent.perception.signs.chords import chords_of
from vehicle_agent.perception.signs.planes import UprightPlane, faces, lean_ratio, upright_plane
from vehicle_agent.perception.signs.stages import SignStages, reflecting, without_outliers
from vehicle_agent.signals import SignPercept


class BoardRules(msgspec.Struct, frozen=True):
    """What can be a board on a post.

    apart_m          points nearer than this in the ground plan belong to one thing
    tolerance_m, tolerance_ratio  from the plane: fixed, and by range
    on_plane_ratio   of a thing's points that lie on its plane
    facing_min       cosine between the board's normal and the direction to the vehicle
    lean_max         vertical part of the normal
    width_m, height_m_max  least and greatest extent
    bottom_m_min     of the board above the ground: plates of cars, bollards and barriers are lower
    ground_m         the ground is looked for so near around the board
    boards_max       the nearest boards are kept
    """

    apart_m: float = 0.3
    tolerance_m: float = 0.05
    tolerance_ratio: float = 0.001
    on_plane_ratio: float = 0.8
    facing_min: float = 0.9
    lean_max: float = 0.35
    width_m: tuple[float, float] = (0.15, 1.25)
    height_m_max: float = 1.3
    bottom_m_min: float = 1.0
    ground_m: float = 3.0
    boards_max: int = 12


class SignFinder(msgspec.Struct, frozen=True):
    """All five stages with their parameters."""

    stages: SignStages = SignStages()
    boards: BoardRules = BoardRules()

    def percept(self, points_base: Array, intensities: Array, stamp_ns: int) -> SignPercept:
        """The boards of one scan, of all lidars together.

        points_base  (n, 3) base frame at stamp_ns, z from the ground under the rear axle
        intensities  (n,)
        Raises ValueError for other shapes.
        """
        if points_base.ndim != 2 or points_base.shape[1] != 3 or len(intensities) != len(points_base):
            raise ValueError(
                f"a scan is (n, 3) points with (n,) intensities, not {points_base.shape}, {intensities.shape}"
            )
        points = without_outliers(reflecting(points_base, intensities, self.stages), self.stages)
        things = _things(points, self.boards.apart_m)
        around = _in_field(points_base, self.stages) if things else points_base
        found = [self._board(thing, around) for thing in things]
        boards = sorted(
            (one for one in found if one is not None), key=lambda one: float(np.hypot(*one[0][:2]))
        )
        boards = boards[: self.boards.boards_max]
        if not boards:
            return SignPercept(stamp_ns)
        numbers = np.repeat(np.arange(len(boards)), [len(chords) for _, chords in boards])
        chords = np.concatenate([chords for _, chords in boards])
        return SignPercept(stamp_ns, np.array([row for row, _ in boards]), chords, numbers.astype(np.int64))

    def _board(self, points: Array, around: Array) -> tuple[Array, Array] | None:
        """((6,) as in `SignPercept`; (k, 5) chords), or None for what cannot be a board."""
        rules = self.boards
        origin = np.array([self.stages.x_m, 0.0])
        range_m = float(np.hypot(*(points[:, :2].mean(axis=0) - origin)))
        plane = upright_plane(points, origin, rules.tolerance_m + rules.tolerance_ratio * range_m)
        if plane is None or plane.inliers.mean() < rules.on_plane_ratio:
            return None
        on_plane = points[plane.inliers]
        across = on_plane[:, :2] @ np.array([-plane.normal[1], plane.normal[0]])
        width_m, height_m = float(np.ptp(across)), float(np.ptp(on_plane[:, 2]))
        if not (rules.width_m[0] <= width_m <= rules.width_m[1] and height_m <= rules.height_m_max):
            return None
        middle = on_plane.mean(axis=0)
        if not faces(plane, middle[:2], origin, rules.facing_min) or lean_ratio(on_plane) > rules.lean_max:
            return None
        bottom_m = float(on_plane[:, 2].min()) - _ground_m(around, middle, rules.ground_m)
        if bottom_m < rules.bottom_m_min:
            return None
        yaw = float(np.arctan2(plane.normal[1], plane.normal[0]))
        hidden = self._hidden(around, plane, range_m)
        right = np.array([plane.normal[1], -plane.normal[0]])
        board = np.column_stack((on_plane[:, :2] @ right, on_plane[:, 2]))
        chords = chords_of(board, hidden, self.stages.step_ratio * range_m)
        if len(chords):
            # The widest chord's middle is on the board's axis, wherever the returns are.
            axis_m = float(chords[np.argmax(chords[:, 0]), 4])
            middle[:2] += (axis_m - float(middle[:2] @ right)) * right
            chords[:, 4] -= axis_m
        return np.array([*middle, yaw, bottom_m, float(len(on_plane))]), chords

    def _hidden(self, around: Array, plane: UprightPlane, range_m: float) -> Array:
        """(m, 2) across and height where the beams of nearer returns would meet the board's plane.

        All beams are taken from the first lidar; others are near to it.
        """
        origin = np.array([self.stages.x_m, 0.0, self.stages.z_m])
        rays = around - origin
        toward = rays[:, :2] @ plane.normal
        away = plane.offset_m - float(plane.normal @ origin[:2])
        with np.errstate(divide="ignore", invalid="ignore"):
            times = away / toward
        nearer = (times > 1.0 + 0.5 / range_m) & (times < 20.0)
        met = origin + rays[nearer] * times[nearer, None]
        right = np.array([plane.normal[1], -plane.normal[0]])
        return np.column_stack((met[:, :2] @ right, met[:, 2]))


def _in_field(points_base: Array, stages: SignStages) -> Array:
    """(k, 3) float64 all returns of stage 1's field: the ground and what may hide a board."""
    x, y = points_base[:, 0] - stages.x_m, points_base[:, 1]
    with np.errstate(invalid="ignore"):
        inside = (x > 0.3) & (x <= stages.ahead_m + 3.0) & (np.abs(y) <= stages.side_m + 3.0)
    return points_base[inside].astype(np.float64)


def _things(points: Array, apart_m: float) -> list[Array]:
    """Points (n, 3) that hang together in the ground plan: the rings on one board are far apart in height."""
    if not len(points):
        return []
    pairs = cKDTree(points[:, :2]).query_pairs(apart_m, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    count, labels = connected_components(graph, directed=False)
    return [points[labels == k] for k in range(count)]


def _ground_m(around: Array, middle: Array, near_m: float) -> float:
    """Height of the ground around a place, base frame; 0.0, as under the vehicle, where no beam meets it."""
    near = (np.abs(around[:, 0] - middle[0]) < near_m) & (np.abs(around[:, 1] - middle[1]) < near_m)
    low = around[near, 2]
    low = low[low < middle[2] - 0.5]
    return float(np.percentile(low, 10)) if len(low) >= 5 else 0.0

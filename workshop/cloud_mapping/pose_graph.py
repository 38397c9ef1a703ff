"""Pose graphs in space: Levenberg-Marquardt on sparse normal equations, with factors that may be wrong.

Loops and GNSS places are scaled by dynamic covariance scaling (Agarwal et al. 2013, eq. 15): one that
contradicts all others loses its weight instead of bending the map.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from contract.geometry import Array, BoolArray, IntArray
from workshop.cloud_mapping.graph_kernels import (
    back,
    edge_equations,
    edge_errors,
    ground_cost,
    moved,
    place_equations,
    place_errors,
)


class Edge(msgspec.Struct, frozen=True):
    """A measurement of node `to` as node `from_` sees it.

    pose         (4, 4) T_from_to
    information  (6, 6) of a twist (translation, rotation) of `to` in its own frame
    is_loop      whether it may be wrong
    """

    from_: int
    to: int
    pose: Array
    information: Array
    is_loop: bool


class Place(msgspec.Struct, frozen=True):
    """Where the end of a lever (3,) of a node's frame was measured to be, (3,) m in the map frame.

    std_m  (3,) standard deviations of x, y, z; inf: not measured
    """

    node: int
    lever_sensor: Array
    place_map: Array
    std_m: Array


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """The ground below each node: normals (n, 3) in its frame, heights (n,) of the sensor above it.

    known  (n,) where it was seen
    """

    normals: Array
    heights_m: Array
    known: BoolArray


class GraphParams(msgspec.Struct, frozen=True):
    """loop_chi2, place_chi2: the squared Mahalanobis distance up to which a factor keeps its whole weight.

    slope_rad, rise_ratio  standard deviation of the road's slope at a node, and of its rise along the way
    first_m, first_rad     of the first pose: it holds what nothing else does
    leniency               factors of both scales, one after the other
    """

    loop_chi2: float = 16.0
    place_chi2: float = 12.0
    slope_rad: float = 3.0
    rise_ratio: float = 3.0
    first_m: float = 0.1
    first_rad: float = 0.02
    leniency: tuple[float, ...] = (1e4, 1e2, 1.0)
    iterations_max: int = 40
    converged_ratio: float = 1e-5


@dataclass(frozen=True, slots=True, eq=False)
class Optimized:
    """poses (n, 4, 4); chi2 and weights of the edges (e,) and of the places (p,)."""

    poses: Array
    edge_chi2: Array
    edge_weights: Array
    place_chi2: Array
    place_weights: Array
    iterations: int


def optimized(
    poses: Array, edges: Sequence[Edge], places: Sequence[Place], ground: Ground | None, params: GraphParams
) -> Optimized:
    """The nodes' most likely poses; `poses` (n, 4, 4) are where the search begins.

    The first node's pose is a weak factor: without places it stays where it is, with them it follows.
    """
    system = _System(poses, edges, places, ground, params)
    iterations = 0
    # Far from the optimum a right factor contradicts as much as a wrong one: at first all have their weight
    # (graduated non-convexity, Yang et al. 2020).
    for leniency in params.leniency if system.may_be_wrong else (1.0,):
        poses, more = _descended(system, poses, leniency, params)
        iterations += more
    state = system.errors(poses)
    chi2, weights = system.chi2(state), system.weights(state, 1.0)
    return Optimized(poses, chi2[0], weights[0], chi2[1], weights[1], iterations)


def _descended(system: "_System", poses: Array, leniency: float, params: GraphParams) -> tuple[Array, int]:
    """(poses at the minimum, iterations) with all scales of weights times `leniency`."""
    state = system.errors(poses)
    weights = system.weights(state, leniency)
    damping, iterations = 1e-6, 0
    while iterations < params.iterations_max:
        iterations += 1
        cost, step = system.step(poses, state, weights, damping)
        tried = moved(poses, step)
        tried_state = system.errors(tried)
        tried_cost = system.cost(tried, tried_state, weights)
        if not tried_cost <= cost:
            damping *= 10.0
            if damping > 1e6:
                break
            continue
        damping = max(1e-9, 0.1 * damping)
        poses, state = tried, tried_state
        fresh = system.weights(state, leniency)
        changes = (np.abs(a - b).max(initial=0.0) for a, b in zip(fresh, weights, strict=True))
        is_settled = max(changes) < 1e-2
        weights = fresh
        if is_settled and cost - tried_cost <= params.converged_ratio * cost:
            break
    return poses, iterations


_State = tuple[Array, Array]


class _System:
    """The normal equations of a graph."""

    def __init__(
        self, poses: Array, edges: Sequence[Edge], places: Sequence[Place], ground: Ground | None,
        params: GraphParams,
    ) -> None:  # fmt: skip
        self._params, self._count, self._ground = params, len(poses), ground
        self._first_back = back(poses[0])
        self._from: IntArray = np.array([edge.from_ for edge in edges], dtype=np.int64)
        self._to: IntArray = np.array([edge.to for edge in edges], dtype=np.int64)
        self._measured_back = np.array([back(edge.pose) for edge in edges]).reshape(-1, 4, 4)
        self._information = np.array([edge.information for edge in edges]).reshape(-1, 6, 6)
        self._is_loop: BoolArray = np.array([edge.is_loop for edge in edges], dtype=bool)
        self._nodes: IntArray = np.array([place.node for place in places], dtype=np.int64)
        self._levers = np.array([place.lever_sensor for place in places]).reshape(-1, 3)
        self._places = np.array([place.place_map for place in places]).reshape(-1, 3)
        std_m = np.array([place.std_m for place in places]).reshape(-1, 3)
        self._place_information = np.where(np.isfinite(std_m), 1.0 / np.square(std_m), 0.0)
        # A height that was not measured is no place.
        self._places = np.where(np.isfinite(std_m), self._places, 0.0)
        along_m = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
        self._rise = 1.0 / np.square(params.rise_ratio * np.maximum(along_m, 0.2))
        self._prior = np.diag([params.first_m**-2] * 3 + [params.first_rad**-2] * 3)
        if places:
            self._prior[:2, :2] *= 1e-8
            self._prior[3:, 3:] *= 1e-4
        following = np.arange(self._count - 1)
        self._rows = np.concatenate([self._from, following])
        self._columns = np.concatenate([self._to, following + 1])

    def errors(self, poses: Array) -> _State:
        return (
            edge_errors(poses, self._from, self._to, self._measured_back),
            place_errors(poses, self._nodes, self._levers, self._places),
        )

    def chi2(self, state: _State) -> tuple[Array, Array]:
        edges, places = state
        return (
            np.einsum("ea,eab,eb->e", edges, self._information, edges, optimize=True),
            (self._place_information * places * places).sum(axis=1),
        )

    @property
    def may_be_wrong(self) -> bool:
        """Whether there is a factor that can lose its weight."""
        return bool(self._is_loop.any()) or len(self._nodes) > 0

    def weights(self, state: _State, leniency: float) -> tuple[Array, Array]:
        edges, places = self.chi2(state)
        loop, place = leniency * self._params.loop_chi2, leniency * self._params.place_chi2
        return (
            np.where(self._is_loop, np.minimum(1.0, 2.0 * loop / (loop + edges)) ** 2, 1.0),
            np.minimum(1.0, 2.0 * place / (place + places)) ** 2,
        )

    def cost(self, poses: Array, state: _State, weights: tuple[Array, Array]) -> float:
        chi2 = self.chi2(state)
        prior = self._prior_error(poses)
        total = float(weights[0] @ chi2[0] + weights[1] @ chi2[1] + prior @ self._prior @ prior)
        if self._ground is not None:
            total += self._ground_equations(poses)[0]
        return total

    def step(
        self, poses: Array, state: _State, weights: tuple[Array, Array], damping: float
    ) -> tuple[float, Array]:
        """(the cost, the damped Gauss-Newton step (n, 6))."""
        count = self._count
        diagonal, gradient = np.zeros((count, 6, 6)), np.zeros((count, 6))
        blocks = np.zeros((len(self._from), 6, 6))
        edge_equations(
            poses, self._from, self._to, state[0], self._information, weights[0], diagonal, gradient, blocks
        )
        place_equations(
            poses,
            self._nodes,
            self._levers,
            state[1],
            self._place_information,
            weights[1],
            diagonal,
            gradient,
        )
        prior = self._prior_error(poses)
        diagonal[0] += self._prior
        gradient[0] += self._prior @ prior
        _, ground_diagonal, ground_gradient, ground_blocks = self._ground_equations(poses)
        diagonal += ground_diagonal
        gradient += ground_gradient
        blocks = np.concatenate([blocks, ground_blocks])
        scale = np.einsum("iaa->ia", diagonal)
        scale += damping * scale + 1e-9
        factor = splu(
            self._matrix(diagonal, blocks), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}
        )
        step: Array = factor.solve(-gradient.ravel()).reshape(-1, 6)
        return self.cost(poses, state, weights), step

    def _prior_error(self, poses: Array) -> Array:
        found: Array = edge_errors(
            np.stack([np.eye(4), poses[0]]), np.array([0]), np.array([1]), self._first_back[None]
        )[0]
        return found

    def _ground_equations(self, poses: Array) -> tuple[float, Array, Array, Array]:
        count = self._count
        diagonal, gradient = np.zeros((count, 6, 6)), np.zeros((count, 6))
        blocks = np.zeros((count - 1, 6, 6))
        if self._ground is None:
            return 0.0, diagonal, gradient, blocks
        ground, tilt = self._ground, self._params.slope_rad**-2
        cost = ground_cost(
            poses,
            ground.normals,
            ground.heights_m,
            ground.known,
            tilt,
            self._rise,
            diagonal,
            gradient,
            blocks,
        )
        return cost, diagonal, gradient, blocks

    def _matrix(self, diagonal: Array, blocks: Array) -> csc_matrix:
        nodes = np.arange(self._count)
        rows = np.concatenate([nodes, self._rows, self._columns])
        columns = np.concatenate([nodes, self._columns, self._rows])
        values = np.concatenate([diagonal, blocks, blocks.transpose(0, 2, 1)])
        at = np.arange(6)
        full = np.broadcast_to(6 * rows[:, None, None] + at[None, :, None], values.shape)
        across = np.broadcast_to(6 * columns[:, None, None] + at[None, None, :], values.shape)
        size = 6 * self._count
        return csc_matrix((values.ravel(), (full.ravel(), across.ravel())), shape=(size, size))


def information_of(std_m: float, std_rad: float) -> Array:
    """(6, 6) of equal deviations along and about all axes."""
    found: Array = np.diag([std_m**-2] * 3 + [std_rad**-2] * 3)
    return found

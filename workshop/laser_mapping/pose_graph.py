"""Pose graphs in the plane: Levenberg-Marquardt on sparse normal equations, with robust edges.

Loop edges are scaled by dynamic covariance scaling (Agarwal et al. 2013, eq. 15): an edge that contradicts
all others loses its weight instead of bending the map.
"""

from collections.abc import Sequence

import msgspec
import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from contract.geometry import Array, BoolArray, IntArray
from vehicle_agent.localization.laser.pose_arrays import wrapped


class Edge(msgspec.Struct, frozen=True):
    """A measurement of node `to` as node `from_` sees it.

    pose         (3,) T_from_to
    information  (3, 3) inverse covariance in the axes of `from_` (1/m2, 1/rad2)
    is_loop      whether it may be wrong: it then loses weight where it contradicts the others
    """

    from_: int
    to: int
    pose: Array
    information: Array
    is_loop: bool


class NodePlace(msgspec.Struct, frozen=True):
    """A measurement of where a point of a node is, such as a receiver's antenna.

    lever      (2,) of the point in the node's frame, m
    place_map  (2,) m; std_m of it. It may be wrong, and then loses its weight like a loop
    """

    node: int
    lever: Array
    place_map: Array
    std_m: float


class Optimized(msgspec.Struct, frozen=True):
    """poses (n, 3); chi2 (e,) each edge's squared Mahalanobis distance, unscaled; weights (e,) 0..1."""

    poses: Array
    chi2: Array
    weights: Array
    iterations: int


class GraphParams(msgspec.Struct, frozen=True):
    """chi2_scale: the squared Mahalanobis distance up to which a loop edge keeps its whole weight."""

    chi2_scale: float = 8.0
    iterations_max: int = 30
    converged_ratio: float = 1e-6


def optimized(
    poses: Array, edges: Sequence[Edge], params: GraphParams, places: Sequence[NodePlace] = ()
) -> Optimized:
    """The nodes' most likely poses, from poses (n, 3) on. Without places, node 0 keeps its pose.

    chi2 and weights of the result have the edges first and then the places.
    """
    if len(poses) < 2 or not edges:
        return Optimized(poses.copy(), np.zeros(len(edges)), np.ones(len(edges)), 0)
    system = _PlacedSystem(edges, len(poses), places) if places else _System(edges, len(poses))
    poses = poses.copy()
    errors, chi2 = system.errors(poses)
    weights = system.weights(chi2, params.chi2_scale)
    damping = 1e-6
    iterations = 0
    while iterations < params.iterations_max:
        iterations += 1
        cost = float(weights @ chi2)
        step = system.step(poses, errors, weights, damping)
        tried = poses + step
        tried[:, 2] = wrapped(tried[:, 2])
        tried_errors, tried_chi2 = system.errors(tried)
        tried_cost = float(weights @ tried_chi2)
        if tried_cost > cost:
            damping *= 10.0
            if damping > 1e6:
                break
            continue
        damping = max(1e-9, 0.1 * damping)
        poses, errors, chi2 = tried, tried_errors, tried_chi2
        new_weights = system.weights(chi2, params.chi2_scale)
        is_settled = bool(np.abs(new_weights - weights).max() < 1e-3)
        weights = new_weights
        if is_settled and cost - tried_cost <= params.converged_ratio * cost:
            break
    return Optimized(poses, chi2, weights, iterations)


class _System:
    """The normal equations of a graph, whose pattern is the same in all iterations."""

    def __init__(self, edges: Sequence[Edge], nodes: int) -> None:
        self._from: IntArray = np.array([edge.from_ for edge in edges])
        self._to: IntArray = np.array([edge.to for edge in edges])
        self._measured = np.array([edge.pose for edge in edges])
        self._information = np.array([edge.information for edge in edges])
        self._is_loop: BoolArray = np.array([edge.is_loop for edge in edges])
        self._nodes = nodes

    def errors(self, poses: Array) -> tuple[Array, Array]:
        """(errors (e, 3), their squared Mahalanobis lengths (e,))."""
        first, last = poses[self._from], poses[self._to]
        cos, sin = np.cos(first[:, 2]), np.sin(first[:, 2])
        dx_m, dy_m = last[:, 0] - first[:, 0], last[:, 1] - first[:, 1]
        errors = np.stack(
            [
                cos * dx_m + sin * dy_m - self._measured[:, 0],
                cos * dy_m - sin * dx_m - self._measured[:, 1],
                wrapped(last[:, 2] - first[:, 2] - self._measured[:, 2]),
            ],
            axis=1,
        )
        return errors, np.einsum("ea,eab,eb->e", errors, self._information, errors)

    def weights(self, chi2: Array, scale: float) -> Array:
        scaled = np.minimum(1.0, 2.0 * scale / (scale + chi2)) ** 2
        return np.where(self._is_loop, scaled, 1.0)

    def step(self, poses: Array, errors: Array, weights: Array, damping: float) -> Array:
        """(n, 3) the damped Gauss-Newton step; node 0 is fixed: its rows are left out."""
        matrix, gradient = self._equations(poses, errors, weights)
        step = np.zeros(3 * self._nodes)
        step[3:] = _solved(matrix[3:, 3:], gradient[3:], damping)
        return step.reshape(-1, 3)

    def _equations(self, poses: Array, errors: Array, weights: Array) -> tuple[csc_matrix, Array]:
        """(matrix, gradient) of the normal equations."""
        first, last = poses[self._from], poses[self._to]
        cos, sin = np.cos(first[:, 2]), np.sin(first[:, 2])
        dx_m, dy_m = last[:, 0] - first[:, 0], last[:, 1] - first[:, 1]
        count = len(errors)
        jacobians = np.zeros((count, 3, 6))
        jacobians[:, 0, 0], jacobians[:, 0, 1] = -cos, -sin
        jacobians[:, 1, 0], jacobians[:, 1, 1] = sin, -cos
        jacobians[:, 0, 2] = cos * dy_m - sin * dx_m
        jacobians[:, 1, 2] = -cos * dx_m - sin * dy_m
        jacobians[:, :2, 3:5] = -jacobians[:, :2, :2]
        jacobians[:, 2, 2], jacobians[:, 2, 5] = -1.0, 1.0
        weighted = self._information * weights[:, None, None]
        blocks = np.einsum("eai,eab,ebj->eij", jacobians, weighted, jacobians, optimize=True)
        gradients = np.einsum("eai,eab,eb->ei", jacobians, weighted, errors, optimize=True)
        unknowns = np.concatenate([3 * self._from[:, None], 3 * self._to[:, None]], axis=1)
        at = (unknowns[:, :, None] + np.arange(3)).reshape(count, 6)
        size = 3 * self._nodes
        rows, columns = np.repeat(at, 6, axis=1).ravel(), np.tile(at, (1, 6)).ravel()
        matrix = csc_matrix((blocks.reshape(count, 36).ravel(), (rows, columns)), shape=(size, size))
        gradient = np.bincount(at.ravel(), weights=gradients.ravel(), minlength=size).astype(np.float64)
        return matrix, gradient


class _PlacedSystem(_System):
    """A graph whose nodes are held by places in the map frame, so that no node is fixed."""

    def __init__(self, edges: Sequence[Edge], nodes: int, places: Sequence[NodePlace]) -> None:
        super().__init__(edges, nodes)
        self._edges = len(edges)
        self._at: IntArray = np.array([place.node for place in places])
        self._levers = np.array([place.lever for place in places])
        self._places = np.array([place.place_map for place in places])
        self._weights = np.array([place.std_m**-2 for place in places])
        self._is_loop = np.concatenate([self._is_loop, np.ones(len(places), dtype=np.bool_)])

    def errors(self, poses: Array) -> tuple[Array, Array]:
        errors, chi2 = super().errors(poses)
        away = np.zeros((len(self._at), 3))
        away[:, :2] = poses[self._at, :2] + self._turned(poses) - self._places
        squared = self._weights * np.einsum("pa,pa->p", away, away)
        return np.concatenate([errors, away]), np.concatenate([chi2, squared])

    def step(self, poses: Array, errors: Array, weights: Array, damping: float) -> Array:
        matrix, gradient = self._equations(poses, errors[: self._edges], weights[: self._edges])
        turned = self._turned(poses)
        jacobians = np.zeros((len(self._at), 2, 3))
        jacobians[:, 0, 0] = jacobians[:, 1, 1] = 1.0
        jacobians[:, 0, 2], jacobians[:, 1, 2] = -turned[:, 1], turned[:, 0]
        weighed = jacobians * (self._weights * weights[self._edges :])[:, None, None]
        blocks = np.einsum("pai,paj->pij", weighed, jacobians)
        gradients = np.einsum("pai,pa->pi", weighed, errors[self._edges :, :2])
        at = 3 * self._at[:, None] + np.arange(3)
        size = 3 * self._nodes
        rows, columns = np.repeat(at, 3, axis=1).ravel(), np.tile(at, (1, 3)).ravel()
        matrix = matrix + csc_matrix((blocks.ravel(), (rows, columns)), shape=(size, size))
        gradient = gradient + np.bincount(at.ravel(), weights=gradients.ravel(), minlength=size)
        return _solved(matrix, gradient, damping).reshape(-1, 3)

    def _turned(self, poses: Array) -> Array:
        """(p, 2) the levers in the map's axes."""
        cos, sin = np.cos(poses[self._at, 2]), np.sin(poses[self._at, 2])
        x, y = self._levers.T
        return np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)


def _solved(matrix: csc_matrix, gradient: Array, damping: float) -> Array:
    """The step that the damped normal equations ask for."""
    size = len(gradient)
    diagonal = matrix.diagonal()
    damped = matrix + csc_matrix(
        (damping * diagonal + 1e-9, (np.arange(size), np.arange(size))), shape=matrix.shape
    )
    factor = splu(damped.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    step: Array = factor.solve(-gradient)
    return step


def in_axes_of(T_reference_from: Array, information: Array) -> Array:
    """(3, 3) information given in the reference's axes, in the axes of `from`."""
    cos, sin = np.cos(T_reference_from[2]), np.sin(T_reference_from[2])
    rotation = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    turned: Array = rotation.T @ information @ rotation
    return turned

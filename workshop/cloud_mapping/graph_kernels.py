"""Compiled parts of the pose graph: residuals of its factors and their normal equations.

A pose (4, 4) is changed by a twist (6,) in its own frame: T exp(xi) (Barfoot 2017, section 7.1).
"""

import math

import numpy as np
from numba import njit

from contract.geometry import Array, BoolArray, IntArray
from vehicle_agent.localization.odometry.motion import exponential, logarithm


@njit(cache=True)
def back(pose: Array) -> Array:
    """The inverse of a pose (4, 4)."""
    found = np.eye(4)
    rotation = pose[:3, :3].T.copy()
    found[:3, :3] = rotation
    found[:3, 3] = -(rotation @ pose[:3, 3].copy())
    return found


@njit(cache=True)
def edge_errors(poses: Array, from_: IntArray, to: IntArray, measured_back: Array) -> Array:
    """(e, 6) log(Z^-1 Ti^-1 Tj) of each edge."""
    errors = np.empty((from_.shape[0], 6))
    for e in range(from_.shape[0]):
        errors[e] = logarithm(measured_back[e] @ back(poses[from_[e]]) @ poses[to[e]])
    return errors


@njit(cache=True)
def _hat(v: Array) -> Array:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


@njit(cache=True)
def edge_equations(
    poses: Array, from_: IntArray, to: IntArray, errors: Array, information: Array, weights: Array,
    diagonal: Array, gradient: Array, blocks: Array,
) -> None:  # fmt: skip
    """Adds the edges to diagonal (n, 6, 6) and gradient (n, 6); blocks (e, 6, 6): between i and j."""
    for e in range(from_.shape[0]):
        i, j = from_[e], to[e]
        # The inverse right Jacobian, to first order in the error.
        near = np.eye(6)
        v, w = _hat(errors[e, :3]), _hat(errors[e, 3:])
        near[:3, :3] += 0.5 * w
        near[3:, 3:] += 0.5 * w
        near[:3, 3:] += 0.5 * v
        way = back(poses[j]) @ poses[i]
        adjoint = np.zeros((6, 6))
        rotation = way[:3, :3].copy()
        adjoint[:3, :3] = rotation
        adjoint[3:, 3:] = rotation
        adjoint[:3, 3:] = _hat(way[:3, 3]) @ rotation
        first = -near @ adjoint
        scaled = weights[e] * information[e]
        by_first, by_last = first.T @ scaled, near.T @ scaled
        diagonal[i] += by_first @ first
        diagonal[j] += by_last @ near
        blocks[e] = by_first @ near
        gradient[i] += by_first @ errors[e]
        gradient[j] += by_last @ errors[e]


@njit(cache=True)
def place_errors(poses: Array, nodes: IntArray, levers: Array, places: Array) -> Array:
    """(f, 3) where the lever's end is, less where it was measured to be."""
    errors = np.empty((nodes.shape[0], 3))
    for f in range(nodes.shape[0]):
        pose = poses[nodes[f]]
        errors[f] = pose[:3, :3].copy() @ levers[f] + pose[:3, 3] - places[f]
    return errors


@njit(cache=True)
def place_equations(
    poses: Array, nodes: IntArray, levers: Array, errors: Array, information: Array, weights: Array,
    diagonal: Array, gradient: Array,
) -> None:  # fmt: skip
    """Adds the places; information (f, 3): of x, y and z."""
    jacobian = np.zeros((3, 6))
    for f in range(nodes.shape[0]):
        rotation = poses[nodes[f], :3, :3].copy()
        jacobian[:, :3] = rotation
        jacobian[:, 3:] = -rotation @ _hat(levers[f])
        for axis in range(3):
            scale = weights[f] * information[f, axis]
            row = jacobian[axis]
            diagonal[nodes[f]] += scale * np.outer(row, row)
            gradient[nodes[f]] += scale * errors[f, axis] * row


@njit(cache=True)
def ground_cost(
    poses: Array, normals: Array, heights: Array, known: BoolArray, tilt: float, rise: Array,
    diagonal: Array, gradient: Array, blocks: Array,
) -> float:  # fmt: skip
    """The cost of ground that is not level, and its equations.

    normals (n, 3) of the ground in each sensor's frame; heights (n,) of the sensor above it; known (n,)
    tilt: information of the slope (1/rad2); rise (n - 1,): of the ground's rise from node to node
    blocks (n - 1, 6, 6): between a node and the next
    """
    cost = 0.0
    jacobian = np.zeros((2, 6))
    for i in range(poses.shape[0]):
        if not known[i]:
            continue
        rotation = poses[i, :3, :3].copy()
        leaning = rotation @ normals[i]
        jacobian[:, 3:] = (-rotation @ _hat(normals[i]))[:2]
        for axis in range(2):
            row = jacobian[axis]
            diagonal[i] += tilt * np.outer(row, row)
            gradient[i] += tilt * leaning[axis] * row
            cost += tilt * leaning[axis] * leaning[axis]
    for i in range(poses.shape[0] - 1):
        blocks[i] = 0.0
        if not (known[i] and known[i + 1]):
            continue
        step = poses[i + 1, 2, 3] - heights[i + 1] - poses[i, 2, 3] + heights[i]
        first, last = np.zeros(6), np.zeros(6)
        first[:3], last[:3] = -poses[i, 2, :3], poses[i + 1, 2, :3]
        diagonal[i] += rise[i] * np.outer(first, first)
        diagonal[i + 1] += rise[i] * np.outer(last, last)
        blocks[i] = rise[i] * np.outer(first, last)
        gradient[i] += rise[i] * step * first
        gradient[i + 1] += rise[i] * step * last
        cost += rise[i] * step * step
    return cost


@njit(cache=True)
def moved(poses: Array, step: Array) -> Array:
    """The poses (n, 4, 4) after twists (n, 6) in their own frames."""
    found = np.empty_like(poses)
    for i in range(poses.shape[0]):
        pose = poses[i] @ exponential(step[i])
        # Products leave the right angles a little at a time (first-order Gram-Schmidt).
        x, y = pose[:3, 0].copy(), pose[:3, 1].copy()
        x /= math.sqrt(x @ x)
        y -= (x @ y) * x
        y /= math.sqrt(y @ y)
        pose[:3, 0], pose[:3, 1] = x, y
        pose[0, 2] = x[1] * y[2] - x[2] * y[1]
        pose[1, 2] = x[2] * y[0] - x[0] * y[2]
        pose[2, 2] = x[0] * y[1] - x[1] * y[0]
        found[i] = pose
    return found

"""The chords in which a lidar's rings cut a board."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from contract.geometry import Array, BoolArray

Indices = NDArray[np.int64]

# Neighbours on one ring: along it they are up to 9 cm apart at 25 m, across it they are level.
_ALONG_M, _ACROSS_M = 0.16, 0.05
_POINTS_MIN = 3
# What stands before a board hides it at about the height at which a ring meets it.
_SAME_RING_M = 0.12
_UNEVEN_M = 0.04


def chords_of(board: Array, hidden: Array, step_m: float) -> Array:
    """(k, 5) of each chord: width, height of its left and of its right end, standard deviation of the width,
    and where its middle is across.

    board   (n, 2) returns of one board in one scan: across to the right, height
    hidden  (m, 2) places on the board's plane that something nearer hides, in the same axes
    step_m  between two firings of a ring. A ring's last returns are on average half a step before the edges

    A chord that ends where something hides the board says nothing of the board's width and is left out. Rings
    of a tilted lidar cut a board at a slant, so both ends have heights of their own.
    """
    rows = []
    for members in _joined(board, _linked(board), hidden):
        points = board[members]
        if len(points) < _POINTS_MIN:
            continue
        left, right = points[np.argmin(points[:, 0])], points[np.argmax(points[:, 0])]
        if _is_cut(left, hidden, -1.0, step_m) or _is_cut(right, hidden, 1.0, step_m):
            continue
        # Both ends are uniform within a step.
        deviation_m = float(np.hypot(0.41 * step_m, 0.015))
        middle_m = 0.5 * float(left[0] + right[0])
        rows.append(
            (float(right[0] - left[0]) + step_m, float(left[1]), float(right[1]), deviation_m, middle_m)
        )
    chords = np.array(rows).reshape(-1, 5)
    return chords if len(chords) < 2 else chords[_is_about(chords, float(chords[np.argmax(chords[:, 0]), 4]))]


def _is_about(chords: Array, axis_m: float) -> BoolArray:
    """(k,) whether a chord lies evenly about the board's axis.

    A ring that grazes the upper or lower edge of a board meets only a part of it, mostly at one side: it
    would look like the taper of an octagon.
    """
    even: BoolArray = np.abs(chords[:, 4] - axis_m) <= _UNEVEN_M + chords[:, 3]
    return even


def _linked(board: Array) -> list[Indices]:
    """Indices of the returns that hang together along rings."""
    scaled = board / np.array([_ALONG_M, _ACROSS_M])
    pairs = cKDTree(scaled).query_pairs(1.0, output_type="ndarray")
    shape = (len(board), len(board))
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=shape)
    count, labels = connected_components(graph, directed=False)
    return [np.flatnonzero(labels == k) for k in range(count)]


def _joined(board: Array, pieces: list[Indices], hidden: Array) -> list[Indices]:
    """Pieces of one ring on either side of what hides its middle are one chord."""
    joined: list[Indices] = []
    for piece in sorted(pieces, key=lambda members: float(board[members, 0].min())):
        left = board[piece[np.argmin(board[piece, 0])]]
        for k, earlier in enumerate(joined):
            right = board[earlier[np.argmax(board[earlier, 0])]]
            between = (hidden[:, 0] > right[0]) & (hidden[:, 0] < left[0])
            level = np.abs(hidden[:, 1] - right[1]) < _SAME_RING_M
            if abs(left[1] - right[1]) < _ACROSS_M and right[0] < left[0] and (between & level).any():
                joined[k] = np.concatenate((earlier, piece))
                break
        else:
            joined.append(piece)
    return joined


def _is_cut(end: Array, hidden: Array, way: float, step_m: float) -> bool:
    """Whether something hides the board just beyond a chord's end; way: 1.0 to the right."""
    beyond = way * (hidden[:, 0] - end[0])
    same = np.abs(hidden[:, 1] - end[1]) < _SAME_RING_M
    return bool(np.any(same & (beyond > -0.5 * step_m) & (beyond < 3.0 * step_m + 0.03)))

"""Connected small cells become objects; groups of people become people."""

import math

import numpy as np
from numba import njit

from contract.geometry import IntArray
from vehicle_agent.perception.points.fine_cells import COUNT, UPPER, cells_apart

# A gap of so many cells joins near the vehicle, and at most far from it, where beams are apart.
_NEAR_CELLS, _FAR_CELLS = 2, 4
# The gap grows by a cell in each 10 m.
_PER_M = 0.1
# Two people's middles are at least so far apart; in cells.
_PEOPLE_CELLS = 3
# Between two people there is less than this share of what the thinner one shows.
_SADDLE = 0.7
# And an empty cell between them counts as so much of what is beside it.
_GAP_WEIGHT = 0.6
# Returns below the chest count less where people are told apart: feet are far from each other.
_LOW_WEIGHT = 0.15


@njit(cache=True)
def connected(places: np.ndarray, index: np.ndarray, values: np.ndarray) -> IntArray:
    """(k,) number of the object of each cell, from 0, in the order of the cells."""
    k = places.shape[0]
    parent = np.arange(k)
    for a in range(k):
        reach = cells_apart(values, a, _NEAR_CELLS, _FAR_CELLS, _PER_M)
        i, j = places[a, 0], places[a, 1]
        # Half of the surroundings: the other half has looked at this cell.
        for di in range(reach + 1):
            row = i + di
            if row >= index.shape[0]:
                break
            for dj in range(-reach, reach + 1):
                column = j + dj
                if (di == 0 and dj <= 0) or not 0 <= column < index.shape[1]:
                    continue
                b = index[row, column]
                if b >= 0 and di * di + dj * dj <= reach * reach + 1:
                    _join(parent, a, b)
    labels = np.full(k, -1)
    found = 0
    for a in range(k):
        root = _root(parent, a)
        if labels[root] < 0:
            labels[root] = found
            found += 1
        labels[a] = labels[root]
    return labels


@njit(cache=True)
def _root(parent: np.ndarray, a: int) -> int:
    while parent[a] != a:
        parent[a] = parent[parent[a]]
        a = parent[a]
    return a


@njit(cache=True)
def _join(parent: np.ndarray, a: int, b: int) -> None:
    ra, rb = _root(parent, a), _root(parent, b)
    # The root is the first cell, so that numbers do not depend on the order of joining.
    if ra < rb:
        parent[rb] = ra
    elif rb < ra:
        parent[ra] = rb


@njit(cache=True)
def split_people(
    places: np.ndarray, index: np.ndarray, values: np.ndarray, labels: np.ndarray, is_group: np.ndarray
) -> IntArray:
    """(k,) labels in which each person of a group has a number of his own; other objects keep theirs.

    is_group  (objects,) which objects may be several people

    A cell climbs to the place around it with most returns above the chest (watershed). Two such places are
    two people if there is clearly less between them.
    """
    k = places.shape[0]
    mass = np.zeros(k)
    for a in range(k):
        if is_group[labels[a]]:
            mass[a] = _mass_around(places, index, values, labels, a)
    top_of = np.arange(k)
    for a in range(k):
        if is_group[labels[a]]:
            top_of[a] = _steepest(places, index, mass, labels, a)
    for a in range(k):
        while top_of[top_of[a]] != top_of[a]:
            top_of[a] = top_of[top_of[a]]
    parent = np.arange(k)
    for a in range(k):
        if not is_group[labels[a]]:
            continue
        i, j = places[a, 0], places[a, 1]
        for di in range(-2, 3):
            for dj in range(-2, 3):
                row, column = i + di, j + dj
                if not (0 <= row < index.shape[0] and 0 <= column < index.shape[1]):
                    continue
                b = index[row, column]
                if b < 0 or labels[b] != labels[a] or top_of[a] == top_of[b]:
                    continue
                pa, pb = top_of[a], top_of[b]
                apart = math.hypot(places[pa, 0] - places[pb, 0], places[pa, 1] - places[pb, 1])
                between = min(mass[a], mass[b])
                if max(abs(di), abs(dj)) > 1:
                    # There is a cell without returns between them.
                    between *= _GAP_WEIGHT
                shallow = between > _SADDLE * min(mass[pa], mass[pb])
                if apart < _PEOPLE_CELLS or shallow:
                    _join(parent, pa, pb)
    split = np.full(k, -1)
    number_of = np.full(k, -1)
    found = 0
    seen = np.full(is_group.shape[0], -1)
    for a in range(k):
        if is_group[labels[a]]:
            root = _root(parent, top_of[a])
            if number_of[root] < 0:
                number_of[root] = found
                found += 1
            split[a] = number_of[root]
        else:
            if seen[labels[a]] < 0:
                seen[labels[a]] = found
                found += 1
            split[a] = seen[labels[a]]
    return split


@njit(cache=True)
def _mass_around(
    places: np.ndarray, index: np.ndarray, values: np.ndarray, labels: np.ndarray, a: int
) -> float:
    """Returns of the object around a cell, those nearer count more."""
    total = 0.0
    for di in range(-2, 3):
        for dj in range(-2, 3):
            row, column = places[a, 0] + di, places[a, 1] + dj
            if not (0 <= row < index.shape[0] and 0 <= column < index.shape[1]):
                continue
            b = index[row, column]
            if b >= 0 and labels[b] == labels[a]:
                weight = math.exp(-0.4 * (di * di + dj * dj))
                total += weight * (values[b, UPPER] + _LOW_WEIGHT * (values[b, COUNT] - values[b, UPPER]))
    return total


@njit(cache=True)
def _steepest(places: np.ndarray, index: np.ndarray, mass: np.ndarray, labels: np.ndarray, a: int) -> int:
    """The cell with most mass within two cells; the first one of equals."""
    best = a
    for di in range(-2, 3):
        for dj in range(-2, 3):
            row, column = places[a, 0] + di, places[a, 1] + dj
            if not (0 <= row < index.shape[0] and 0 <= column < index.shape[1]):
                continue
            b = index[row, column]
            if (
                b >= 0
                and labels[b] == labels[a]
                and (mass[b] > mass[best] or (mass[b] == mass[best] and b < best))
            ):
                best = b
    return best

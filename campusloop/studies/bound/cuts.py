"""Subset-row cuts: of three requests, at most one route can serve two or more.

Jepsen, Petersen, Spoorendonk, Pisinger (2008), with |S| = 3 and k = 2.
"""

import numpy as np
from numba import njit

from server.dispatch.arrays import AnyArray

Triple = tuple[int, int, int]


def violated_cuts(
    sets: AnyArray, flow: AnyArray, known: set[Triple], cuts_max: int, per_request: int, least: float
) -> AnyArray:
    """(c, 3) requests of the most violated cuts that are not known.

    sets  (r, n) 0 and 1, routes in the fractional solution; flow (r,) their values
    per_request  no request is in more of the new cuts: they spread
    least        violation for which a row is worth it
    """
    triples, violation = _violations(sets, flow, least)
    used = np.zeros(sets.shape[1], np.int64)
    chosen: list[Triple] = []
    for k in np.argsort(-violation, kind="stable"):
        triple = tuple(int(i) for i in triples[k])
        if len(chosen) == cuts_max:
            break
        if triple in known or (used[list(triple)] >= per_request).any():
            continue
        used[list(triple)] += 1
        chosen.append((triple[0], triple[1], triple[2]))
    return np.array(chosen, np.int64).reshape(-1, 3)


@njit(cache=True)
def _violations(sets: AnyArray, flow: AnyArray, least: float) -> tuple[AnyArray, AnyArray]:
    """(c, 3), (c,): a triple's left-hand side is (pairs together - routes with all three twice) of the
    flow, minus 1.
    """
    n = sets.shape[1]
    together = np.zeros((n, n))
    for route in range(len(sets)):
        for i in range(n):
            if sets[route, i]:
                for j in range(i + 1, n):
                    if sets[route, j]:
                        together[i, j] += flow[route]
    found = np.empty((64, 3), np.int64)
    by = np.empty(64)
    count = 0
    for i in range(n):
        for j in range(i + 1, n):
            for k in range(j + 1, n):
                value = together[i, j] + together[i, k] + together[j, k]
                if value <= 1.0 + least:
                    continue
                for route in range(len(sets)):
                    if sets[route, i] and sets[route, j] and sets[route, k]:
                        value -= 2.0 * flow[route]
                if value <= 1.0 + least:
                    continue
                if count == len(by):
                    found = np.concatenate((found, np.empty((count, 3), np.int64)))
                    by = np.concatenate((by, np.empty(count)))
                found[count, 0], found[count, 1], found[count, 2] = i, j, k
                by[count] = value - 1.0
                count += 1
    return found[:count].copy(), by[:count].copy()

"""The part of the network in which every lane can be reached from every other."""

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from server.feeds.roads.lanes.drafts import LaneDraft


def largest_loop(drafts: Sequence[LaneDraft]) -> list[LaneDraft]:
    """The lanes of the longest strongly connected part, their successors limited to it; empty if none."""
    if not drafts:
        return []
    numbers = {draft.lane_id: i for i, draft in enumerate(drafts)}
    steps = [(numbers[d.lane_id], numbers[s]) for d in drafts for s in d.successors]
    if not steps:
        return []
    rows, columns = np.array(steps).T
    matrix = csr_array((np.ones(len(steps)), (rows, columns)), shape=(len(drafts), len(drafts)))
    _, labels = connected_components(matrix, directed=True, connection="strong")
    lengths = np.zeros(int(labels.max()) + 1)
    members = np.bincount(labels)
    for draft, label in zip(drafts, labels, strict=True):
        lengths[label] += draft.length_m
    lengths[members < 2] = 0.0
    if lengths.max() == 0.0:
        return []
    best = int(np.argmax(lengths))
    kept = [draft for draft, label in zip(drafts, labels, strict=True) if label == best]
    names = {draft.lane_id for draft in kept}
    for draft in kept:
        draft.successors = [name for name in draft.successors if name in names]
    return kept

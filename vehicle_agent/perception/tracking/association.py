"""Which object of a scan is which track."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from contract.geometry import Array, IntArray
from vehicle_agent.perception.tracking.motion import Z_VAR, ZX, ZY, combined, gate_distances
from vehicle_agent.perception.tracking.params import TrackerParams
from vehicle_agent.perception.tracking.tracks import TrackTable
from vehicle_agent.signals import OTHER

# Of the cost of differing kinds, where one of them is not known.
_UNKNOWN_SHARE = 0.25
# Cost of a pair that cannot be; finite, because the assignment wants numbers.
_IMPOSSIBLE = 1e6


def associate(
    tracks: TrackTable,
    kinds: IntArray,
    measured: Array,
    seen_kinds: IntArray,
    sizes_m: Array,
    params: TrackerParams,
) -> tuple[IntArray, IntArray]:
    """((k,) rows of tracks, (k,) rows of objects) that belong together.

    kinds (n,) of the tracks, measured (m, 6) as `motion` has it, seen_kinds (m,) and sizes_m (m, 3) of the
    objects. Confirmed tracks choose first, in two rounds; a track of one or two scans takes what is left, so
    that the part of a thing that looked like another in one scan does not take it over.
    """
    rows: IntArray = np.empty(0, np.int64)
    columns: IntArray = np.empty(0, np.int64)
    for chosen in (np.flatnonzero(tracks.is_confirmed), np.flatnonzero(~tracks.is_confirmed)):
        left = np.setdiff1d(np.arange(len(measured)), columns)
        near = assign(tracks.selected(chosen), kinds[chosen], measured[left], seen_kinds[left], params)
        rows = np.concatenate((rows, chosen[near[0]]))
        columns = np.concatenate((columns, left[near[1]]))
        late = assign_touching(tracks, measured, sizes_m, rows, columns, params)
        rows, columns = np.concatenate((rows, late[0])), np.concatenate((columns, late[1]))
    return rows, columns


def assign(
    tracks: TrackTable, kinds: IntArray, measured: Array, seen_kinds: IntArray, params: TrackerParams
) -> tuple[IntArray, IntArray]:
    """((k,) rows of tracks, (k,) rows of objects) that belong together.

    kinds (n,) of the tracks, measured (m, 6) as `motion` has it, seen_kinds (m,) of the objects

    Of all assignments the one with the least sum of squared Mahalanobis distances, each with the logarithm of
    its spread, so that a track that has not been seen for long does not take a measurement from another.
    """
    none: IntArray = np.empty(0, np.int64)
    if not len(tracks) or not len(measured):
        return none, none
    mean, covariance = combined(tracks.means, tracks.covariances, tracks.weights)
    squared, log_spread = gate_distances(mean, covariance, measured)
    apart = np.hypot(mean[:, None, 0] - measured[None, :, ZX], mean[:, None, 1] - measured[None, :, ZY])
    reach = np.array([motion.reach_m for motion in params.motions])[kinds]
    differs = kinds[:, None] != seen_kinds[None, :]
    unknown = (kinds[:, None] == OTHER) | (seen_kinds[None, :] == OTHER)
    cost = squared + log_spread - log_spread.min()
    cost += np.where(differs, np.where(unknown, _UNKNOWN_SHARE, 1.0) * params.kind_cost, 0.0)
    possible = (squared <= params.gate) & (apart <= reach[:, None])
    rows, columns = linear_sum_assignment(np.where(possible, cost, _IMPOSSIBLE))
    taken = possible[rows, columns]
    return rows[taken].astype(np.int64), columns[taken].astype(np.int64)


def assign_touching(
    tracks: TrackTable,
    measured: Array,
    sizes_m: Array,
    rows: IntArray,
    columns: IntArray,
    params: TrackerParams,
) -> tuple[IntArray, IntArray]:
    """((k,) rows of tracks, (k,) rows of objects) that `assign` left over and that touch each other.

    sizes_m (m, 3) of the objects

    What is seen of a cyclist changes from scan to scan: the rider alone, then the front wheel as well.
    Its middle jumps farther than an error of measurement, and the track would end while a new one begins
    beside it. Where nothing else lies near, they are the same thing. The measurement counts less, by its own
    jump: its variance in `measured` is raised in place.
    """
    lost = np.setdiff1d(np.flatnonzero(tracks.is_confirmed), rows)
    new = np.setdiff1d(np.arange(len(measured)), columns)
    if not len(lost) or not len(new):
        return rows[:0], columns[:0]
    mean, _ = combined(tracks.means[lost], tracks.covariances[lost], tracks.weights[lost])
    apart = np.hypot(
        mean[:, None, 0] - measured[new][None, :, ZX], mean[:, None, 1] - measured[new][None, :, ZY]
    )
    half_m = 0.5 * (tracks.sizes_m[lost, 0][:, None] + sizes_m[new, 0][None, :])
    touches = apart <= np.minimum(half_m, params.touching_m)
    first, second = linear_sum_assignment(np.where(touches, apart, _IMPOSSIBLE))
    taken = touches[first, second]
    first, second = first[taken], second[taken]
    jumps = measured[new[second], Z_VAR] + (0.5 * apart[first, second]) ** 2
    measured[new[second], Z_VAR] = jumps
    return lost[first].astype(np.int64), new[second].astype(np.int64)

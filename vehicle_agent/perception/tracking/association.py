"""Which object of a scan is which track."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from contract.geometry import Array, IntArray
from vehicle_agent.perception.tracking.motion import ZX, ZY, combined, gate_distances
from vehicle_agent.perception.tracking.params import TrackerParams
from vehicle_agent.perception.tracking.tracks import TrackTable
from vehicle_agent.signals import OTHER

# Of the cost of differing kinds, where one of them is not known.
_UNKNOWN_SHARE = 0.25
# Cost of a pair that cannot be; finite, because the assignment wants numbers.
_IMPOSSIBLE = 1e6


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
    # A new track has proven nothing yet.
    cost += np.where(tracks.is_confirmed, 0.0, 2.0)[:, None]
    possible = (squared <= params.gate) & (apart <= reach[:, None])
    rows, columns = linear_sum_assignment(np.where(possible, cost, _IMPOSSIBLE))
    taken = possible[rows, columns]
    return rows[taken].astype(np.int64), columns[taken].astype(np.int64)

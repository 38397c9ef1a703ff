"""What the tracker remembers of each track."""

import msgspec
import numpy as np

from vehicle_agent.perception.tracking.motion import MODELS, STATES
from vehicle_agent.signals import TRACK_KINDS


class TrackTable(msgspec.Struct, frozen=True):
    """One row for each track, in order of ids.

    ids (n,) int64
    means (n, 2, 5), covariances (n, 2, 5, 5), weights (n, 2)   see `motion`; map frame
    evidence (n, 4)      logarithms, by kind
    sizes_m (n, 3)       length, width, height: of what was seen of it, smaller values slowly
    yaws (n,)            of the length, map frame
    ages, hits, misses (n,) int64   scans since the first; scans with a measurement; scans since the last
    hidden (n,) int64    of the misses, those with something nearer in front of it
    is_confirmed (n,) bool
    begins_map (n, 2)    where it was first seen
    visible_m (n,)       height of the part that was seen of it last; inf: not known
    is_below (n,) bool   a person who is not seen because all beams pass over them; see `below_beams`
    """

    ids: np.ndarray
    means: np.ndarray
    covariances: np.ndarray
    weights: np.ndarray
    evidence: np.ndarray
    sizes_m: np.ndarray
    yaws: np.ndarray
    ages: np.ndarray
    hits: np.ndarray
    misses: np.ndarray
    hidden: np.ndarray
    is_confirmed: np.ndarray
    begins_map: np.ndarray
    visible_m: np.ndarray
    is_below: np.ndarray

    def __len__(self) -> int:
        return len(self.ids)

    def copied(self) -> "TrackTable":
        """The same with arrays of its own, which may be changed."""
        return TrackTable(*(column.copy() for column in msgspec.structs.astuple(self)))

    def selected(self, chosen: np.ndarray) -> "TrackTable":
        """The rows that `chosen` names: (n,) bool or indices."""
        return TrackTable(*(column[chosen] for column in msgspec.structs.astuple(self)))

    def with_rows(self, later: "TrackTable") -> "TrackTable":
        """These rows and then those."""
        columns = zip(msgspec.structs.astuple(self), msgspec.structs.astuple(later), strict=True)
        return TrackTable(*(np.concatenate(pair) for pair in columns))


def no_tracks(count: int = 0) -> TrackTable:
    """Rows of zeros."""
    none = np.zeros(count, np.int64)
    return TrackTable(
        none, np.zeros((count, MODELS, STATES)), np.zeros((count, MODELS, STATES, STATES)),
        np.zeros((count, MODELS)), np.zeros((count, len(TRACK_KINDS))), np.zeros((count, 3)), np.zeros(count),
        none.copy(), none.copy(), none.copy(), none.copy(), np.zeros(count, np.bool_), np.zeros((count, 2)),
        np.full(count, np.inf), np.zeros(count, np.bool_),
    )  # fmt: skip


class ObjectTrackerState(msgspec.Struct, frozen=True):
    """stamp_ns: of the last scan, 0 before the first. next_id: of the next new track; none is used twice."""

    stamp_ns: int
    next_id: int
    tracks: TrackTable

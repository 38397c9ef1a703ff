"""Kerbs that were seen several times, in the map frame."""

import msgspec
import numpy as np

from contract.geometry import Array, Pose2, transform_points

# Of a cell's two numbers in one.
_ROW = np.int64(1) << 32


def _none(dtype: type) -> np.ndarray:
    return np.empty(0, dtype)


class KerbsState(msgspec.Struct, frozen=True):
    """cells (n,) numbers of cells of the map, ascending; hits (n,) how many scans showed them.

    seen_ns (n,) when they were last seen
    """

    cells: np.ndarray = msgspec.field(default_factory=lambda: _none(np.int64))
    hits: np.ndarray = msgspec.field(default_factory=lambda: _none(np.int64))
    seen_ns: np.ndarray = msgspec.field(default_factory=lambda: _none(np.int64))


class KerbMemory(msgspec.Struct, frozen=True):
    """A ring shows a kerb where it crosses it, and elsewhere in the next scan: cells are kept for a while.

    cell_m     side of a cell
    hits_min   a kerb has been seen so often: grass and what lies about are not
    memory_ns  it is kept for so long
    """

    cell_m: float = 0.25
    hits_min: int = 3
    memory_ns: int = 5_000_000_000

    def step(self, state: KerbsState, kerbs_base: Array, pose_map: Pose2, now_ns: int) -> KerbsState:
        """With the kerbs (k, 2) of a scan at pose_map."""
        places = transform_points(pose_map, kerbs_base)
        rows = np.floor(places / self.cell_m).astype(np.int64)
        seen = np.unique(rows[:, 0] * _ROW + rows[:, 1])
        kept = state.seen_ns >= now_ns - self.memory_ns
        cells = np.union1d(state.cells[kept], seen)
        hits, seen_ns = np.zeros(len(cells), np.int64), np.zeros(len(cells), np.int64)
        old = np.searchsorted(cells, state.cells[kept])
        hits[old], seen_ns[old] = state.hits[kept], state.seen_ns[kept]
        new = np.searchsorted(cells, seen)
        hits[new] += 1
        seen_ns[new] = now_ns
        return KerbsState(cells, hits, seen_ns)

    def places_map(self, state: KerbsState) -> Array:
        """(k, 2) middles of the kerbs' cells, map frame."""
        cells = state.cells[state.hits >= self.hits_min]
        # The second number may be negative: it is what is left after the nearest multiple.
        x = (cells + _ROW // 2) // _ROW
        places: Array = (np.column_stack((x, cells - x * _ROW)) + 0.5) * self.cell_m
        return places

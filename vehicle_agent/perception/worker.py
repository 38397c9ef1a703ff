"""What the perception worker makes of scans: cells alone, or cells and tracks (`own_tracks`).

The worker is a process beside the tick. Its percepts go to tick and gate alike.
"""

from typing import Protocol

import numpy as np

from vehicle_agent.perception.height_map import HeightMap, percept_from_scan
from vehicle_agent.perception.signs.boards import SignFinder
from vehicle_agent.perception.thinned_scans import ScanThinning, ThinnedScans
from vehicle_agent.signals import Percept, SignPercept, ThinnedScan
from vehicle_agent.signals.objects import EgoMotion


class PerceptionWorker(Protocol):
    """Deterministic: the same motions and scans give the same percepts."""

    def take(self, motion: EgoMotion) -> None:
        """One tick's motion; each is older than the scans that follow it, or about to be."""
        ...

    def percepts(self, rows: np.ndarray, stamp_ns: int) -> tuple[Percept, ...]:
        """Of one scan, as the scan ring has it.

        rows  (n, 5) float32: x, y, z in the base frame of the point's own moment, intensity, and that moment
              in s from stamp_ns; 0 for points that the driver has moved to the stamp
        """
        ...

    def signs(self, rows: np.ndarray, stamp_ns: int) -> tuple[SignPercept, ...]:
        """Traffic signs in the same scan, for a stack that reads them; after `percepts`, which are urgent."""
        ...

    def thinned(self, rows: np.ndarray, stamp_ns: int) -> ThinnedScan | None:
        """Some points of the same scan for people who look, once a second; last of all."""
        ...


class CellsWorker:
    """Obstacle cells by the height map; tracks of road users come from another computer."""

    def __init__(
        self,
        height_map: HeightMap,
        sign_finder: SignFinder | None = None,
        thinning: ScanThinning | None = None,
    ) -> None:
        """sign_finder: None for a stack that reads no signs. thinning: of scans that are shown."""
        self._height_map, self._sign_finder = height_map, sign_finder
        self._shown = ThinnedScans(thinning)

    def take(self, motion: EgoMotion) -> None:
        """Cells need no motion."""

    def percepts(self, rows: np.ndarray, stamp_ns: int) -> tuple[Percept, ...]:
        return (percept_from_scan(rows[:, :3], stamp_ns, self._height_map),)

    def signs(self, rows: np.ndarray, stamp_ns: int) -> tuple[SignPercept, ...]:
        if self._sign_finder is None:
            return ()
        return (self._sign_finder.percept(rows[:, :3], rows[:, 3], stamp_ns),)

    def thinned(self, rows: np.ndarray, stamp_ns: int) -> ThinnedScan | None:
        return self._shown.thinning.thinned(rows[:, :3], stamp_ns) if self._shown.takes(stamp_ns) else None

"""Which parts of the next picture will be looked at: from perception to a camera's driver, by a mapped file.

For cameras that read out parts of a picture, and simulated ones, whose every pixel costs time. Other drivers
need not read it.
"""

import struct
from pathlib import Path

import numpy as np

from contract.geometry import IntArray
from vehicle_agent.mapped_file import mapped

WINDOWS_MAX = 64
# A number that is odd while the rest is written, and the count of windows; -1: no picture is needed.
_HEAD = struct.Struct("<qq")
_COLUMNS = 4
_BYTES = _HEAD.size + WINDOWS_MAX * _COLUMNS * 8


class PictureWindows:
    """One side asks, the other reads what is asked; neither waits."""

    def __init__(self, path: Path, create: bool) -> None:
        """create: the side that asks. Raises OSError if there is none to read, or it is just being made."""
        self._map = mapped(path, _BYTES, create)
        self._rows: IntArray = np.frombuffer(self._map, np.int64, offset=_HEAD.size).reshape(-1, _COLUMNS)
        self._number = 0
        if create:
            self.ask(None)

    def ask(self, windows: IntArray | None) -> None:
        """windows (k, 4): left, top, right, bottom, px. No rows: any picture will do; None: none is needed.

        Of more than WINDOWS_MAX the first ones are asked for.
        """
        count = -1 if windows is None else min(len(windows), WINDOWS_MAX)
        self._number += 1
        _HEAD.pack_into(self._map, 0, 2 * self._number - 1, -1)
        if windows is not None:
            self._rows[:count] = windows[:count]
        _HEAD.pack_into(self._map, 0, 2 * self._number, count)

    def asked(self) -> IntArray | None:
        """What was asked for last, a copy; None also while it is being written."""
        number, count = _HEAD.unpack_from(self._map, 0)
        if number % 2 or count < 0:
            return None
        windows = self._rows[:count].copy()
        return windows if _HEAD.unpack_from(self._map, 0) == (number, count) else None


def picture_windows_path(scan_ring: Path, camera: str) -> Path:
    """The file for a vehicle's camera, beside the ring of its lidar."""
    return scan_ring.with_name(f"{scan_ring.name}-{camera}.windows")

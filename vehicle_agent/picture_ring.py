"""A camera's pictures from its driver to the recorder: a ring of slots in a memory-mapped file.

A picture is too large for a datagram. No side waits: a reader detects a slot that was overwritten, and counts
the pictures that it missed by their numbers.
"""

import struct
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle_agent.device_feed import DeviceFeedError
from vehicle_agent.mapped_file import mapped

# At 10 Hz a reader may be late by 3 s: a computer that is too busy for a while loses nothing.
SLOTS = 32
PICTURE_BYTES_MAX = 1920 * 1200 * 3
# The camera with which a vehicle looks for people (`[camera]`).
PEOPLE_CAMERA = "people"
_HEADER = struct.Struct("<qqii")
_SLOT_BYTES = 64 + PICTURE_BYTES_MAX


class RingPicture(NamedTuple):
    """pixels  (h, w, 3) uint8, red green blue, a copy
    missed  pictures between the one that was read before and this one
    """

    stamp_ns: int
    pixels: NDArray[np.uint8]
    missed: int


class PictureRing:
    """One writer, any number of readers. The file is sparse: it takes the room that its pictures need."""

    def __init__(self, path: Path, create: bool) -> None:
        """create: the driver does, and numbers pictures from 0 again.

        Raises DeviceFeedError if there is none to read.
        """
        size = SLOTS * _SLOT_BYTES
        try:
            self._map = mapped(path, size, create)
        except OSError as error:
            raise DeviceFeedError(
                f"no ring of pictures at {path} ({error}); start the camera's driver first"
            ) from error
        self._next = 0
        if create:
            for slot in range(SLOTS):
                _HEADER.pack_into(self._map, slot * _SLOT_BYTES, -1, 0, 0, 0)
        else:
            self._next = self._newest() + 1

    def write(self, stamp_ns: int, pixels: NDArray[np.uint8]) -> None:
        """pixels: (h, w, 3). Raises ValueError for more than PICTURE_BYTES_MAX."""
        height, width, _ = pixels.shape
        if pixels.size > PICTURE_BYTES_MAX:
            raise ValueError(f"a picture of {width} x {height} does not fit into the ring")
        offset = self._next % SLOTS * _SLOT_BYTES
        _HEADER.pack_into(self._map, offset, -1, stamp_ns, width, height)
        self._pixels(offset, width, height)[:] = pixels
        _HEADER.pack_into(self._map, offset, self._next, stamp_ns, width, height)
        self._next += 1

    def read(self) -> RingPicture | None:
        """The oldest picture that was not read yet; None if there is none."""
        newest = self._newest()
        if newest < self._next - 1:
            # The driver was started again.
            self._next = max(0, newest)
        expected = self._next
        # The slot after the newest is the one that is written to next.
        self._next = max(expected, newest - SLOTS + 2)
        while self._next <= newest:
            offset = self._next % SLOTS * _SLOT_BYTES
            number, stamp_ns, width, height = _HEADER.unpack_from(self._map, offset)
            if number == self._next:
                pixels = self._pixels(offset, width, height).copy()
                if _HEADER.unpack_from(self._map, offset)[0] == number:
                    self._next = number + 1
                    return RingPicture(stamp_ns, pixels, number - expected)
            self._next += 1
        return None

    def close(self) -> None:
        self._map.close()

    def _newest(self) -> int:
        return int(max(_HEADER.unpack_from(self._map, slot * _SLOT_BYTES)[0] for slot in range(SLOTS)))

    def _pixels(self, offset: int, width: int, height: int) -> NDArray[np.uint8]:
        flat: NDArray[np.uint8] = np.frombuffer(
            self._map, dtype=np.uint8, count=width * height * 3, offset=offset + 64
        )
        return flat.reshape(height, width, 3)


def picture_ring_path(scan_ring: Path, camera: str) -> Path:
    """The ring of a vehicle's camera, beside that of its lidar."""
    return scan_ring.with_name(f"{scan_ring.name}-{camera}.pictures")

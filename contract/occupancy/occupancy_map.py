"""An occupancy map: square cells that are free, occupied or unknown."""

import hashlib
import struct

import msgspec
import numpy as np
from numpy.typing import NDArray

FREE, OCCUPIED, UNKNOWN = 0, 100, 255
# Counts up where the meaning of the hashed values changes.
FORMAT = 1

Cells = NDArray[np.uint8]


class OccupancyMap(msgspec.Struct, frozen=True):
    """cells (rows, columns) FREE, OCCUPIED or UNKNOWN; row 0 has the least y, column 0 the least x.

    cell_m                  side of a cell
    origin_x_m, origin_y_m  the corner of cell [0, 0] in the map frame: its least x and y, not its centre
    """

    cells: Cells
    cell_m: float
    origin_x_m: float
    origin_y_m: float

    @property
    def map_hash(self) -> str:
        """SHA-256 of geometry and cells: equal for equal maps, wherever they were written."""
        rows, columns = self.cells.shape
        header = struct.pack("<3d3I", self.cell_m, self.origin_x_m, self.origin_y_m, rows, columns, FORMAT)
        return hashlib.sha256(header + np.ascontiguousarray(self.cells).tobytes()).hexdigest()

    def state_at(self, x_m: float, y_m: float) -> int:
        """The state of the cell at this point of the map frame; UNKNOWN outside."""
        column = int(np.floor((x_m - self.origin_x_m) / self.cell_m))
        row = int(np.floor((y_m - self.origin_y_m) / self.cell_m))
        rows, columns = self.cells.shape
        return int(self.cells[row, column]) if 0 <= row < rows and 0 <= column < columns else UNKNOWN

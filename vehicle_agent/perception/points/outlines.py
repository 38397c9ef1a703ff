"""The edges of obstacles: what lies inside them is left out, because the edge is met first."""

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter

from contract.geometry import BoolArray


def outline(is_obstacle: BoolArray, gap_cells: int) -> BoolArray:
    """(r, c) the obstacle cells (r, c) that are not inside their obstacle.

    gap_cells  gaps of fewer cells than this inside an obstacle are part of it: no vehicle fits into them

    A hedge, a bush or a car that lidars look into has returns all over its inside. The gaps are closed, and
    the cells whose eight neighbours are then all of the obstacle are inside (morphological closing and
    erosion).
    """
    width = gap_cells + (gap_cells + 1) % 2
    cells = is_obstacle.astype(np.uint8)
    closed = minimum_filter(maximum_filter(cells, width, mode="constant"), width, mode="constant", cval=1)
    inside = minimum_filter(closed, 3, mode="constant", cval=0)
    edge: BoolArray = is_obstacle & (inside == 0)
    return edge

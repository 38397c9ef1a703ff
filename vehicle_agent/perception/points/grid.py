"""The grid around the vehicle on which points are sorted."""

from typing import NamedTuple

# A block of the ground is so many cells wide.
BLOCK = 4


class PointGrid(NamedTuple):
    """Extent and rules of the grid; the vehicle's outline is in the base frame. A tuple for kernels.

    above_m              returns higher than this above the ground below them pass over the vehicle
    body_*               the vehicle's outline; returns within body_margin_m of it are its own
    body_trail_m         and behind it, since points are moved back by what the vehicle drove meanwhile
    reach_*              extent of the grid
    cell_m               side of a cell; the ground has a height in each block of 4 x 4 cells
    step_m, slope        ground may differ from the ground beside it by step_m and this slope
    drop_m               returns this far below the expected ground are reflections
    height_m, height_per_m   an obstacle is this much higher than its ground, and more with the distance
    height_m_max         an obstacle this high counts at any distance, and where no ground was seen
    kerb_m               what is no higher than this above the higher ground beside it is a kerb
    gap_cells            narrower gaps inside an obstacle, in cells, are part of it
    points_min           returns in a cell and those around it that an obstacle needs, against dust
    """

    above_m: float
    body_front_m: float
    body_back_m: float
    body_half_width_m: float
    reach_front_m: float = 35.0
    reach_back_m: float = 12.0
    reach_side_m: float = 15.0
    cell_m: float = 0.25
    body_margin_m: float = 0.1
    body_trail_m: float = 0.3
    step_m: float = 0.15
    slope: float = 0.12
    drop_m: float = 1.0
    height_m: float = 0.15
    height_per_m: float = 0.007
    height_m_max: float = 0.4
    kerb_m: float = 0.1
    gap_cells: int = 5
    points_min: int = 2

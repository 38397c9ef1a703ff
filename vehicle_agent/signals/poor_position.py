"""How fast the vehicle may go while it does not know well where it is.

Snow Lion forces 0.5 m/s while the covariance of its localization is large; 0.3 m is our threshold."""

import math

POOR_POSITION_STD_M = 0.3
POOR_POSITION_MPS = 0.5


def position_limit_mps(position_std_m: float) -> float:
    """The speed limit at this standard deviation of the position, inf for a good one.

    A deviation that is not a number counts as poor.
    """
    return math.inf if position_std_m <= POOR_POSITION_STD_M else POOR_POSITION_MPS

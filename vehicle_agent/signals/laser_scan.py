"""One scan of a planar laser, from its driver to the worker; it never enters the tick."""

import msgspec

from contract.geometry import Array


class LaserScan(msgspec.Struct, frozen=True, eq=False):
    """Distances in one plane.

    stamp_ns    of the beam in the middle, in the vehicle's clock
    ranges_m    (n,) not finite or not positive where nothing returned
    angles_rad  (n,) rising, from the laser's x axis, left positive
    """

    stamp_ns: int
    ranges_m: Array
    angles_rad: Array

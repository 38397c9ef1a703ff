"""The parameters of people who heed a vehicle, fitted to recordings."""

import msgspec
import numpy as np

from contract.geometry import Array


class ReactionParams(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How people react to a vehicle that would come too near on their own way.

    margin_m          a predicted clearance below it is a conflict
    notice_s          a conflict that is farther ahead in time is not reacted to
    decel_mps2        slowing down and setting off again
    sidestep_mps      speed of a sidestep
    sidestep_cost     what a metre of sidestep costs; a stop costs 1
    """

    margin_m: float = 0.35
    notice_s: float = 2.0
    decel_mps2: float = 0.76
    sidestep_mps: float = 0.55
    sidestep_cost: float = 2.0

    def row(self) -> Array:
        """(3,) for the kernels, in the order of the columns in `reaction`."""
        return np.array((self.decel_mps2, self.sidestep_mps, self.sidestep_cost))

    def limits(self, count: int) -> Array:
        """(count, 2) margin_m and notice_s, the same for everyone."""
        return np.tile(np.array((self.margin_m, self.notice_s)), (count, 1))

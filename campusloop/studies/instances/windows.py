"""Tightens time windows as far as each request alone implies, so that the insertion test rejects sooner. No
feasible plan is lost."""

import numpy as np

from server.dispatch.arrays import AnyArray


def tightened(
    early: AnyArray,
    late: AnyArray,
    service: AnyArray,
    direct: AnyArray,
    ride_max: AnyArray,
    leave: AnyArray,
    back: AnyArray,
) -> tuple[AnyArray, AnyArray]:
    """(2R,) tightened windows of nodes in pairs (pickup, drop-off).

    direct   (R,) driving from pickup to drop-off; ride_max (R,)
    leave    (2R,) earliest arrival of any vehicle at a node; back (2R,) latest beginning of service there
    """
    early, late = np.maximum(early, leave), np.minimum(late, back)
    early_p, early_d, late_p, late_d = early[0::2], early[1::2], late[0::2], late[1::2]
    service_p = service[0::2]
    early_p = np.maximum(early_p, early_d - ride_max - service_p)
    early_d = np.maximum(early_d, early_p + service_p + direct)
    late_d = np.minimum(late_d, late_p + service_p + ride_max)
    late_p = np.minimum(late_p, late_d - direct - service_p)
    return np.ravel(np.column_stack([early_p, early_d])), np.ravel(np.column_stack([late_p, late_d]))

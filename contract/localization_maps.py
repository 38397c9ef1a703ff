"""What all maps have in common that vehicles compare their scans with."""

import math

from contract.roads.model import Origin

# A tenth of a millimetre.
_SAME_DEG = 1e-9


class LocalizationMapError(ValueError):
    """The folder holds no localization map that can be used; the message is one sentence."""


def is_same_frame(one: Origin | None, other: Origin) -> bool:
    """Whether a place on one map is the same on the other; a map without an origin has its own frame."""
    return one is not None and (
        math.isclose(one.latitude_deg, other.latitude_deg, rel_tol=0.0, abs_tol=_SAME_DEG)
        and math.isclose(one.longitude_deg, other.longitude_deg, rel_tol=0.0, abs_tol=_SAME_DEG)
    )

"""What is wrong with a camera, told by its pictures: black, or the same picture again and again. Pure."""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Trouble = Literal["", "black", "frozen"]

# Of 255. Video black is 16; a street at night has lamps, and a sensor's noise.
DARK_MEAN, DARK_SPREAD = 24.0, 3.0
# A camera that works has noise: no two pictures have the same bytes. Not told at once: a stream may repeat.
ALIKE_NS = 2_000_000_000
# Lines and columns that are looked at.
_EVERY = 8


class PictureState(NamedTuple):
    """digest: of the picture before. changed_ns: when it last differed. dark_ns: since when it is dark."""

    digest: bytes = b""
    changed_ns: int = 0
    dark_ns: int | None = None
    trouble: Trouble = ""


def check(state: PictureState, stamp_ns: int, luma: NDArray[np.uint8]) -> PictureState:
    """luma: (h, w). `trouble` of the result holds for this picture."""
    seen = luma[::_EVERY, ::_EVERY]
    is_dark = float(seen.mean()) < DARK_MEAN and float(seen.std()) < DARK_SPREAD
    digest = seen.tobytes()
    changed_ns = state.changed_ns if digest == state.digest and stamp_ns >= state.changed_ns else stamp_ns
    dark_ns = (stamp_ns if state.dark_ns is None else min(state.dark_ns, stamp_ns)) if is_dark else None
    trouble: Trouble = ""
    if dark_ns is not None and stamp_ns - dark_ns >= ALIKE_NS:
        trouble = "black"
    elif stamp_ns - changed_ns >= ALIKE_NS:
        trouble = "frozen"
    return PictureState(digest, changed_ns, dark_ns, trouble)

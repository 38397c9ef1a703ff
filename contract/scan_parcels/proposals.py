"""What a proposed point map says of itself: the figures an operator decides by.

A proposal is a folder: a point map (`contract/point_map`), `comparison.json` and `comparison.png`.
"""

from typing import Annotated

import msgspec

COMPARISON, PICTURE = "comparison.json", "comparison.png"

Elements = Annotated[int, msgspec.Meta(ge=0)]


class ProposedTile(msgspec.Struct, frozen=True):
    """One tile of which the scans saw something; counts are of surface elements, one each half metre.

    same, new, moved, gone  as the scans and the map in force compare; unseen: of the map in force, and kept
    added          where the map in force knew nothing
    changed_ratio  (new + moved + gone) of these and the same
    is_changed     so much that the tile is made again
    is_added       the map in force has no such tile
    is_remade      the proposal has other bytes for it; all other tiles keep theirs
    """

    ix: int
    iy: int
    same: Elements
    new: Elements
    moved: Elements
    gone: Elements
    unseen: Elements
    added: Elements
    changed_ratio: float
    is_changed: bool
    is_added: bool
    is_remade: bool


class Comparison(msgspec.Struct, frozen=True):
    """A proposed map beside the one in force.

    in_force_version   "" without one; then nothing is compared
    fix_median_m       from the drives' fixes
    moving_removed     elements that beams went through later: people, cars
    shift_m, turn_rad  by which the drives were laid on the map in force
    residual_median_m, residual_p95_m  across the surfaces that both have, afterwards
    changed_ratio      of all surface that can be compared; None without a map in force in this place
    """

    map_version: str
    in_force_version: str
    drives: int
    scans: int
    way_m: float
    fix_median_m: float
    moving_removed: int
    shift_m: tuple[float, float, float]
    turn_rad: float
    residual_median_m: float | None
    residual_p95_m: float | None
    changed_ratio: float | None
    tiles: tuple[ProposedTile, ...]
    tiles_of_map: int
    bytes_of_map: int
    notes: tuple[str, ...]

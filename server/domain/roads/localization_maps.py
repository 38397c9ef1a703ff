"""Maps that vehicles compare their scans with, beside the road maps; one of each kind may be in force."""

from dataclasses import dataclass
from datetime import datetime

from contract.localization_manifest import LocalizationMapKind
from contract.roads.model import Origin


@dataclass(frozen=True, slots=True)
class LocalizationMap:
    """A localization map as it was published, without its manifest and tiles.

    origin            of the map frame in which its tiles lie
    manifest_sha256, manifest_bytes  of the manifest as vehicles download it
    tile_count, size_bytes  of its tiles; equal tiles are counted at each place
    road_map_version  the road map that was in force when it was published
    note              of who published it, or what a program made it of
    active            in force: vehicles of its kind fetch it
    """

    campus_id: str
    map_version: str
    kind: LocalizationMapKind
    origin: Origin
    manifest_sha256: str
    manifest_bytes: int
    tile_count: int
    size_bytes: int
    road_map_version: str
    note: str
    published_by: str
    published_at: datetime
    active: bool = False
    activated_by: str = ""
    activated_at: datetime | None = None

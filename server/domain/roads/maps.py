"""The campus maps that a server knows, one of them active."""

from dataclasses import dataclass
from datetime import datetime


@dataclass(frozen=True, slots=True)
class StoredMap:
    """A road map as it was imported; `content` are its bytes as `contract.roads.load` reads them."""

    campus_id: str
    map_version: str
    name: str
    content: bytes
    added_at: datetime
    active: bool = False


@dataclass(frozen=True, slots=True)
class MapVersion:
    """A stored map without its content."""

    map_version: str
    name: str
    added_at: datetime
    active: bool


@dataclass(frozen=True, slots=True)
class MapDraft:
    """A map that is being drawn; it may have problems.

    revision  counts its changes: a change names the revision that it was made of, so that none is lost
    based_on  the version that was copied, empty for a file
    content   the map as JSON without sections; empty in lists
    """

    campus_id: str
    draft_id: str
    name: str
    revision: int
    based_on: str
    made_by: str
    made_at: datetime
    changed_by: str
    changed_at: datetime
    content: bytes = b""


@dataclass(frozen=True, slots=True)
class ActiveMap:
    """What every transaction reads about the campus's roads.

    has_closures  some road closure stands: scheduled or in force
    factors       travel times by the hour as learnt (`planning/travel_time_factors.py`), None
                  before any is learnt
    """

    map_version: str | None
    has_closures: bool
    factors: tuple[float, ...] | None

"""Drafts of maps: copied or made of a file, changed by revision, published, discarded."""

import math
from dataclasses import replace

from contract.roads.load import decode_map
from contract.roads.model import Origin, RoadMap
from contract.roads.projection import project
from server.domain.errors import (
    DraftChanged,
    DraftUnknown,
    DraftUnsound,
    MapElsewhere,
    MapUnknown,
    TooManyDrafts,
)
from server.domain.roads.maps import MapDraft, StoredMap
from server.usecases.fleet.campus import load_map
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.server_events import record_event

DRAFTS_MAX = 40
# Farther than any campus is wide: such a file is of another place.
ELSEWHERE_M = 20_000.0


def road_map_of(draft: MapDraft) -> RoadMap:
    """The draft's map, without sections."""
    return decode_map(draft.content)


def draft_of(uow: UnitOfWork, draft_id: str) -> MapDraft:
    """Raises DraftUnknown."""
    draft = uow.map_drafts.get(draft_id)
    if draft is None:
        raise DraftUnknown(f"no draft {draft_id}: it was published or discarded")
    return draft


def stored_content(uow: UnitOfWork, map_version: str) -> bytes:
    """Raises MapUnknown."""
    stored = uow.maps.get(map_version)
    if stored is None:
        raise MapUnknown(f"no map {map_version} is stored")
    return stored.content


def stored_map(uow: UnitOfWork, map_version: str) -> RoadMap:
    """Raises MapUnknown."""
    return decode_map(stored_content(uow, map_version))


def map_in_force(uow: UnitOfWork) -> RoadMap | None:
    version = uow.maps.active_version()
    return None if version is None else stored_map(uow, version)


def add_draft(uow: UnitOfWork, name: str, content: bytes, based_on: str, by: str) -> MapDraft:
    """Raises TooManyDrafts."""
    if len(uow.map_drafts.all()) >= DRAFTS_MAX:
        raise TooManyDrafts(f"{DRAFTS_MAX} drafts are kept at most; discard one that is no longer needed")
    draft_id = uow.ids.new_id("draft")
    draft = MapDraft(uow.campus_id, draft_id, name, 1, based_on, by, uow.now, by, uow.now, content)
    uow.map_drafts.add(draft)
    record_event(uow, "map.draft_made", draft_id, by, name)
    return draft


def change_draft(uow: UnitOfWork, draft_id: str, revision: int, content: bytes, by: str) -> MapDraft:
    """The draft with new content. Raises DraftUnknown, DraftChanged."""
    draft = _at_revision(uow, draft_id, revision)
    changed = replace(draft, revision=revision + 1, content=content, changed_by=by, changed_at=uow.now)
    uow.map_drafts.save(changed)
    return changed


def discard_draft(uow: UnitOfWork, draft_id: str, by: str) -> None:
    """Raises DraftUnknown."""
    draft = draft_of(uow, draft_id)
    uow.map_drafts.remove(draft_id)
    record_event(uow, "map.draft_discarded", draft_id, by, draft.name)


def publish_draft(uow: UnitOfWork, draft_id: str, revision: int, content: bytes, by: str) -> StoredMap:
    """Store the completed map and put it in force; the draft is gone.

    Raises DraftUnknown, DraftChanged, DraftUnsound, MapInvalid, MapInUse (shuttles are under way).
    """
    _at_revision(uow, draft_id, revision)
    published = load_map(uow, content, by, activate=True)
    uow.map_drafts.remove(draft_id)
    return published


def require_sound(found: int, first: str) -> None:
    """Raises DraftUnsound for a map with problems."""
    if found:
        raise DraftUnsound(f"{found} problems are left, the first at {first}; mend them, then publish")


def require_near(here: RoadMap | None, other: Origin) -> None:
    """Raises MapElsewhere for a place that is far from the map in force."""
    if here is None:
        return
    away_m = distance_m(here.origin, other)
    if away_m > ELSEWHERE_M:
        raise MapElsewhere(
            f"the file lies {away_m / 1000.0:.0f} km from {here.name}; "
            "choose a file of this campus, or say that it is meant"
        )


def distance_m(one: Origin, other: Origin) -> float:
    """On the plane where that is exact enough, else along a great circle of a sphere."""
    here, there = math.radians(one.latitude_deg), math.radians(other.latitude_deg)
    turned = math.radians(other.longitude_deg - one.longitude_deg)
    cosine = math.sin(here) * math.sin(there) + math.cos(here) * math.cos(there) * math.cos(turned)
    if cosine > 0.9999:
        return math.hypot(*project(one, other.latitude_deg, other.longitude_deg))
    return 6_371_000.0 * math.acos(max(-1.0, cosine))


def _at_revision(uow: UnitOfWork, draft_id: str, revision: int) -> MapDraft:
    draft = draft_of(uow, draft_id)
    if draft.revision != revision:
        raise DraftChanged(
            f"{draft.changed_by} has changed the draft since (revision {draft.revision}, yours is "
            f"{revision}); keep yours as a draft of its own, or load theirs"
        )
    return draft

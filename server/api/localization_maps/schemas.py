"""Localization maps as operators and the computers of surveys see them."""

from collections.abc import Iterable, Sequence
from datetime import datetime

from pydantic import BaseModel, ConfigDict, Field

from contract.localization_manifest import LocalizationMapKind
from contract.localization_maps import is_same_frame
from contract.roads.model import Origin
from server.domain.fleet.vehicles import Vehicle
from server.domain.roads.localization_maps import LocalizationMap

VERSION_EXAMPLE = "3f0c9a71d2e84b553f0c9a71d2e84b553f0c9a71d2e84b553f0c9a71d2e84b55"


class AwaitedVehicle(BaseModel):
    """A vehicle that localizes by such maps and has not changed over to the one in force."""

    vehicle_id: str
    map_version: str = Field(description="What it localizes by meanwhile; empty: GNSS alone.")
    change: str = Field(
        description="Empty: it is on its way, or not connected. `stored`: it has the map and changes over "
        "when it stands. Else why it keeps its own, as in the event `localization_map_failed`."
    )


class LocalizationMapView(BaseModel):
    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "map_version": VERSION_EXAMPLE,
                "kind": "points",
                "tile_count": 280,
                "size_bytes": 7_200_000,
                "road_map_version": "3f0c9a71d2e84b55",
                "note": "survey of 1 September",
                "published_by": "operator",
                "published_at": "2026-09-01T08:00:00Z",
                "active": True,
                "in_frame": True,
                "activated_by": "operator",
                "activated_at": "2026-09-01T08:05:00Z",
                "used_by": ["shuttle-1"],
                "awaited": [{"vehicle_id": "shuttle-2", "map_version": "", "change": "stored"}],
            }
        }
    )

    map_version: str
    kind: LocalizationMapKind = Field(description="points: of lidars; occupancy: of planar scanners.")
    tile_count: int
    size_bytes: int
    road_map_version: str = Field(description="The road map in force when it was published.")
    note: str
    published_by: str
    published_at: datetime
    active: bool = Field(description="In force: vehicles of this kind fetch it.")
    in_frame: bool = Field(
        description="It lies in the frame of the road map in force; otherwise no vehicle is told of it."
    )
    activated_by: str
    activated_at: datetime | None
    used_by: list[str] = Field(description="Vehicles that localize by it.")
    awaited: list[AwaitedVehicle] = Field(description="Of the map in force; else empty.")


class LocalizationMapDetails(LocalizationMapView):
    model_config = ConfigDict(json_schema_extra={})

    missing: list[str] = Field(
        description="SHA-256 of the tiles whose bytes have not come: first these, then into force."
    )


def map_view(
    stored: LocalizationMap, vehicles: Iterable[Vehicle], origin: Origin | None
) -> LocalizationMapView:
    """origin: of the road map in force, None without one"""
    return LocalizationMapView.model_validate(_fields(stored, vehicles, origin))


def details_view(
    stored: LocalizationMap, vehicles: Iterable[Vehicle], origin: Origin | None, missing: Sequence[str]
) -> LocalizationMapDetails:
    fields = _fields(stored, vehicles, origin)
    return LocalizationMapDetails.model_validate({**fields, "missing": list(missing)})


def _fields(stored: LocalizationMap, vehicles: Iterable[Vehicle], origin: Origin | None) -> dict[str, object]:
    chosen = [vehicle for vehicle in vehicles if vehicle.localizes_by == stored.kind]
    return {
        "map_version": stored.map_version,
        "kind": stored.kind,
        "tile_count": stored.tile_count,
        "size_bytes": stored.size_bytes,
        "road_map_version": stored.road_map_version,
        "note": stored.note,
        "published_by": stored.published_by,
        "published_at": stored.published_at,
        "active": stored.active,
        "in_frame": origin is not None and is_same_frame(stored.origin, origin),
        "activated_by": stored.activated_by,
        "activated_at": stored.activated_at,
        "used_by": [one.vehicle_id for one in chosen if one.localization_map == stored.map_version],
        "awaited": [
            AwaitedVehicle(
                vehicle_id=one.vehicle_id, map_version=one.localization_map, change=one.localization_change
            )
            for one in chosen
            if stored.active and one.localization_map != stored.map_version
        ],
    }

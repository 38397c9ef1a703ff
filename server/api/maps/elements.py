"""What is drawn on a map, as pages read and change it: the structs of `contract/roads/model.py`, by kind."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal

import msgspec
from pydantic import BaseModel, ConfigDict, Field

from contract.roads.model import (
    Kerb,
    Lane,
    NoStoppingZone,
    ObservationArea,
    RestingPlace,
    RoadMap,
    Stop,
)
from server.api.formats import FreeText

_POINTS_MAX = 20_000
_ELEMENTS_MAX = 2_000
_NAMES_MAX = 200
Id = Annotated[str, Field(min_length=1, max_length=_NAMES_MAX, pattern=r"^[^\x00-\x1f]+$")]
Metres = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False)]
Place = tuple[Metres, Metres]


class _Element(BaseModel):
    model_config = ConfigDict(extra="forbid")


class LaneBody(_Element):
    lane_id: Id
    kind: Literal["road", "turn", "turnaround"]
    points: list[Place] = Field(max_length=_POINTS_MAX)
    width_m: Metres
    speed_limit_mps: Metres
    can_pass: bool
    successors: list[Id] = Field(max_length=_NAMES_MAX)
    scenario: Literal["common_road", "parking_lot", "unprotected_intersection"] = "common_road"
    name: FreeText = ""
    name_en: FreeText = ""


class StopBody(_Element):
    stop_id: Id
    name: FreeText
    lane_id: Id
    s_m: Metres
    name_en: FreeText = ""
    placed_by: Literal["tag", "rule", "hand"] = "hand"


class RestingPlaceBody(_Element):
    place_id: Id
    lane_id: Id
    s_m: Metres
    charger: bool = False


class ObservationAreaBody(_Element):
    area_id: Id
    kind: Literal["intersection", "crossing"]
    outline: list[Place] = Field(max_length=_POINTS_MAX)
    stop_lines: list[tuple[Id, Metres]] = Field(max_length=_NAMES_MAX)


class NoStoppingZoneBody(_Element):
    zone_id: Id
    lane_id: Id
    s_from_m: Metres
    s_to_m: Metres


class KerbBody(_Element):
    kerb_id: Id
    points: list[Place] = Field(max_length=_POINTS_MAX)


class Elements(_Element):
    lanes: list[LaneBody] = Field([], max_length=_ELEMENTS_MAX)
    stops: list[StopBody] = Field([], max_length=_ELEMENTS_MAX)
    resting_places: list[RestingPlaceBody] = Field([], max_length=_ELEMENTS_MAX)
    observation_areas: list[ObservationAreaBody] = Field([], max_length=_ELEMENTS_MAX)
    no_stopping_zones: list[NoStoppingZoneBody] = Field([], max_length=_ELEMENTS_MAX)
    kerbs: list[KerbBody] = Field([], max_length=_ELEMENTS_MAX)


class RemovedIds(_Element):
    lanes: list[Id] = Field([], max_length=_ELEMENTS_MAX)
    stops: list[Id] = Field([], max_length=_ELEMENTS_MAX)
    resting_places: list[Id] = Field([], max_length=_ELEMENTS_MAX)
    observation_areas: list[Id] = Field([], max_length=_ELEMENTS_MAX)
    no_stopping_zones: list[Id] = Field([], max_length=_ELEMENTS_MAX)
    kerbs: list[Id] = Field([], max_length=_ELEMENTS_MAX)


# Field of a map: the struct and what it is called by.
KINDS: Mapping[str, tuple[type[msgspec.Struct], Callable[[Any], str]]] = {
    "lanes": (Lane, lambda one: str(one.lane_id)),
    "stops": (Stop, lambda one: str(one.stop_id)),
    "resting_places": (RestingPlace, lambda one: str(one.place_id)),
    "observation_areas": (ObservationArea, lambda one: str(one.area_id)),
    "no_stopping_zones": (NoStoppingZone, lambda one: str(one.zone_id)),
    "kerbs": (Kerb, lambda one: str(one.kerb_id)),
}


def changed_map(road_map: RoadMap, put: Elements, removed: RemovedIds) -> RoadMap:
    """The map with elements put in the place of those of the same id, new ones last, and others removed."""
    fields: dict[str, tuple[Any, ...]] = {}
    for name, (kind, id_of) in KINDS.items():
        given = [msgspec.convert(one.model_dump(), kind) for one in getattr(put, name)]
        gone = set(getattr(removed, name))
        if not given and not gone:
            continue
        newest = {id_of(one): one for one in given}
        kept = [newest.pop(id_of(one), one) for one in getattr(road_map, name) if id_of(one) not in gone]
        fields[name] = (*kept, *newest.values())
    return msgspec.structs.replace(road_map, **fields, map_version="")


def drawn(road_map: RoadMap) -> dict[str, Any]:
    """All elements as plain values, as `Elements` has them."""
    return {name: msgspec.to_builtins(getattr(road_map, name)) for name in KINDS}


def differences(old: RoadMap, new: RoadMap) -> dict[str, dict[str, list[str]]]:
    """{kind: {added, removed, changed: ids}}, in the order of the maps."""
    found = {}
    for name, (_, id_of) in KINDS.items():
        before = {id_of(one): one for one in getattr(old, name)}
        after = {id_of(one): one for one in getattr(new, name)}
        found[name] = {
            "added": [key for key in after if key not in before],
            "removed": [key for key in before if key not in after],
            "changed": [key for key in after if key in before and before[key] != after[key]],
        }
    return found

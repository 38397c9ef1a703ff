"""Versions and drafts of maps as operators see them."""

from datetime import datetime

import numpy as np
from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from contract.geometry import arc_lengths, curvatures, pose_at
from contract.roads.model import RoadMap
from contract.roads.validate import Problem, problems
from server.api.formats import FreeText
from server.api.maps.elements import Elements, Id, RemovedIds
from server.domain.roads.maps import MapDraft, MapVersion
from server.usecases.ports.maps import MapWorkshop

_VERSION_EXAMPLE = "3f0c9a71d2e84b55"
# A page lists no more; the rest shows once these are mended.
PROBLEMS_MAX = 200


class MapVersionView(BaseModel):
    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "map_version": _VERSION_EXAMPLE,
                "name": "Baoshan campus",
                "added_at": "2026-09-01T08:00:00Z",
                "active": True,
            }
        }
    )

    map_version: str
    name: str
    added_at: datetime
    active: bool = Field(description="In force: shuttles drive by it.")


_DRAFT_EXAMPLE: JsonDict = {
    "draft_id": "draft-1",
    "name": "New south gate",
    "revision": 4,
    "based_on": _VERSION_EXAMPLE,
    "made_by": "operator",
    "made_at": "2026-09-01T08:00:00Z",
    "changed_by": "operator",
    "changed_at": "2026-09-01T08:10:00Z",
    "repairs": [],
}


class DraftView(BaseModel):
    model_config = ConfigDict(json_schema_extra={"example": _DRAFT_EXAMPLE})

    draft_id: str
    name: str
    revision: int = Field(description="Name it in If-Match when you change the draft.")
    based_on: str = Field(description="The version that was copied; empty for a file.")
    made_by: str
    made_at: datetime
    changed_by: str
    changed_at: datetime
    repairs: list[str] = Field([], description="What an import repaired and left out; only then.")


class DraftBody(BaseModel):
    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"name": "New south gate", "map_version": None}}
    )

    name: FreeText
    map_version: Id | None = Field(None, description="The version to copy; null: the one in force.")
    draft_id: Id | None = Field(None, description="Copy this draft instead.")


class ChangeBody(BaseModel):
    """Elements replace those of the same id; new ones are added."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {
                "put": {"stops": [{"stop_id": "gate", "name": "Gate", "lane_id": "lane-17", "s_m": 12.0}]},
                "removed": {"stops": ["old-gate"]},
            }
        },
    )

    put: Elements = Field(default_factory=lambda: Elements.model_validate({}))
    removed: RemovedIds = Field(default_factory=lambda: RemovedIds.model_validate({}))


class FixBody(BaseModel):
    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"defect": "too_sharp", "where": "lane-17"}}
    )

    defect: Id
    where: Id


class DraftMap(BaseModel):
    """Everything that is drawn, in metres east and north of the origin."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "draft": _DRAFT_EXAMPLE,
                "elements": {
                    "kerbs": [{"kerb_id": "kerb-1", "points": [[0.0, 3.0], [20.0, 3.0]]}],
                },
                "buildings": [[[1.0, 2.0], [31.0, 2.0], [31.0, 22.0]]],
            }
        }
    )

    draft: DraftView
    elements: Elements
    buildings: list[list[tuple[float, float]]]


class MapProblem(BaseModel):
    defect: str
    where: str = Field(description="The id of what it is about.")
    detail: str
    place: tuple[float, float] | None = Field(description="Where it is, in metres; null: of the whole map.")
    can_be_mended: bool


class DraftProblems(BaseModel):
    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "revision": 4,
                "count": 1,
                "problems": [
                    {
                        "defect": "too_sharp",
                        "where": "lane-17",
                        "detail": "radius 3.20 m, 5 m at least",
                        "place": [12.0, 4.5],
                        "can_be_mended": True,
                    }
                ],
                "resting_places": 6,
            }
        }
    )

    revision: int
    count: int
    problems: list[MapProblem]
    resting_places: int = Field(description="How many shuttles the map has room for.")


class ElementDiff(BaseModel):
    added: list[str]
    removed: list[str]
    changed: list[str]


class MapDiff(BaseModel):
    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "against": _VERSION_EXAMPLE,
                "kinds": {"lanes": {"added": [], "removed": [], "changed": ["lane-17"]}},
            }
        }
    )

    against: str
    kinds: dict[str, ElementDiff]


class TrialDrive(BaseModel):
    """The way that a shuttle would take: x0, y0, x1, y1, ... in metres."""

    model_config = ConfigDict(
        json_schema_extra={"example": {"length_m": 820.5, "time_s": 231.0, "xy": [0.0, 0.0, 12.5, 0.4]}}
    )

    length_m: float
    time_s: float
    xy: list[float]


def version_view(version: MapVersion) -> MapVersionView:
    return MapVersionView(
        map_version=version.map_version, name=version.name, added_at=version.added_at, active=version.active
    )


def draft_view(draft: MapDraft, repairs: tuple[str, ...] = ()) -> DraftView:
    return DraftView(
        draft_id=draft.draft_id,
        name=draft.name,
        revision=draft.revision,
        based_on=draft.based_on,
        made_by=draft.made_by,
        made_at=draft.made_at,
        changed_by=draft.changed_by,
        changed_at=draft.changed_at,
        repairs=list(repairs),
    )


def problems_view(revision: int, completed: RoadMap, workshop: MapWorkshop) -> DraftProblems:
    found = [one for one in problems(completed) if (one.code, one.where) != ("empty", "sections")]
    return DraftProblems(
        revision=revision,
        count=len(found),
        problems=[_problem(completed, one, workshop) for one in found[:PROBLEMS_MAX]],
        resting_places=len(completed.resting_places),
    )


def _problem(road_map: RoadMap, problem: Problem, workshop: MapWorkshop) -> MapProblem:
    return MapProblem(
        defect=problem.code,
        where=problem.where,
        detail=problem.detail,
        place=_place(road_map, problem),
        can_be_mended=workshop.mends(problem.code),
    )


def _place(road_map: RoadMap, problem: Problem) -> tuple[float, float] | None:
    """Where to look: a lane's sharpest bend, its end where it does not meet the next one, else its middle."""
    where = problem.where
    lanes = {lane.lane_id: lane for lane in road_map.lanes}
    on_lane = {stop.stop_id: (stop.lane_id, stop.s_m) for stop in road_map.stops}
    on_lane |= {place.place_id: (place.lane_id, place.s_m) for place in road_map.resting_places}
    on_lane |= {zone.zone_id: (zone.lane_id, zone.s_from_m) for zone in road_map.no_stopping_zones}
    on_lane |= {section.section_id: (section.lane_id, section.s_from_m) for section in road_map.sections}
    corners = {area.area_id: area.outline for area in road_map.observation_areas}
    corners |= {kerb.kerb_id: kerb.points for kerb in road_map.kerbs}
    if where in lanes and lanes[where].points:
        points = lanes[where].points
        if problem.code == "too_sharp":
            bends = np.abs(curvatures(np.array(points, dtype=np.float64)))
            return points[int(np.argmax(bends))]
        return points[-1] if problem.code in ("gap", "kink") else points[len(points) // 2]
    if where in on_lane and on_lane[where][0] in lanes:
        lane_id, s_m = on_lane[where]
        line = np.array(lanes[lane_id].points, dtype=np.float64)
        if len(line) > 1:
            x_m, y_m, _ = pose_at(line, arc_lengths(line), s_m)
            return round(x_m, 2), round(y_m, 2)
    outline = corners.get(where)
    return outline[0] if outline else None

"""Road closures as operators see and make them."""

from datetime import datetime
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, StringConstraints
from pydantic.config import JsonDict

from contract.roads.network import RoadNetwork
from server.api.formats import FreeText, Moment
from server.domain.roads.closures import Closure, ClosureState
from server.travel.closed_roads import sections_of
from server.usecases.fleet.closures import CloseRoad

# Ids of lanes and sections come from the map and may contain slashes.
RoadId = Annotated[str, StringConstraints(min_length=1, max_length=200, pattern=r"^[^\x00-\x1f]+$")]
# The longest lanes have some hundred sections; a whole campus fits.
_ROADS_MAX = 2000

BODY_EXAMPLE: JsonDict = {
    "lane_ids": ["lane-17"],
    "section_ids": [],
    "reason": "water main",
    "starts_at": None,
    "ends_at": "2026-09-01T16:00:00Z",
}


class ClosureBody(BaseModel):
    """Lanes, or single sections of them, that no vehicle is sent through."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": BODY_EXAMPLE})

    lane_ids: list[RoadId] = Field([], max_length=_ROADS_MAX)
    section_ids: list[RoadId] = Field([], max_length=_ROADS_MAX)
    reason: FreeText = ""
    starts_at: Moment | None = Field(None, description="Null: now.")
    ends_at: Moment | None = Field(None, description="Null: until it is lifted.")


class ClosureView(BaseModel):
    model_config = ConfigDict(
        json_schema_extra={
            "example": BODY_EXAMPLE
            | {
                "closure_id": "closure-2",
                "starts_at": "2026-09-01T08:00:00Z",
                "made_by": "operator",
                "made_at": "2026-09-01T08:00:00Z",
                "state": "in_force",
                "lifted_by": "",
                "lines": [[12.0, 4.5, 13.0, 4.5]],
            }
        }
    )

    closure_id: str
    lane_ids: list[str]
    section_ids: list[str]
    reason: str
    starts_at: datetime
    ends_at: datetime | None
    made_by: str
    made_at: datetime
    state: ClosureState
    lifted_by: str
    lines: list[list[float]] = Field(
        description="What is closed on the active map: x0, y0, x1, y1, ... in metres, a line a section."
    )


def closure_request(body: ClosureBody) -> CloseRoad:
    return CloseRoad(tuple(body.lane_ids), tuple(body.section_ids), body.reason, body.starts_at, body.ends_at)


def closure_view(closure: Closure, network: RoadNetwork) -> ClosureView:
    return ClosureView(
        closure_id=closure.closure_id,
        lane_ids=list(closure.lane_ids),
        section_ids=list(closure.section_ids),
        reason=closure.reason,
        starts_at=closure.starts_at,
        ends_at=closure.ends_at,
        made_by=closure.made_by,
        made_at=closure.made_at,
        state=closure.state,
        lifted_by=closure.lifted_by,
        lines=[_line(network, section_id) for section_id in dict.fromkeys(sections_of(closure, network))],
    )


def _line(network: RoadNetwork, section_id: str) -> list[float]:
    section = network.sections[section_id]
    line = network.lines[section.lane_id]
    inside = line.points[(line.s > section.s_from_m) & (line.s < section.s_to_m)]
    ends = [network.pose(section.lane_id, s_m)[:2] for s_m in (section.s_from_m, section.s_to_m)]
    points = [ends[0], *((float(x_m), float(y_m)) for x_m, y_m in inside), ends[1]]
    return [round(coordinate, 2) for point in points for coordinate in point]

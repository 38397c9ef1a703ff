"""The campus as pages draw it: metres east (x) and north (y) of the origin."""

from collections.abc import Iterable
from datetime import datetime
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from contract.geometry import Array
from contract.roads.areas import outline_array
from contract.roads.model import Building, Lane
from contract.roads.network import RoadNetwork
from server.domain.fleet.vehicles import Vehicle
from server.domain.roads.stops import CampusStop
from server.domain.rules import FleetRules
from server.domain.service.service import ServiceCalendar
from server.live.route_shape import simplified
from server.usecases.record.calendars import ServiceDay

# Finer than a pixel at any zoom a phone shows a campus at.
DRAWING_TOLERANCE_M = 0.25


STOP_EXAMPLE: JsonDict = {
    "stop_id": "library",
    "name": "图书馆",
    "name_en": "Library",
    "lane_id": "lane-17",
    "s_m": 42.5,
    "x_m": 120.4,
    "y_m": -33.1,
    "placed_by": "tag",
}


class OriginView(BaseModel):
    """The map frame's origin on WGS 84."""

    latitude_deg: float
    longitude_deg: float


class CampusView(BaseModel):
    """What a page needs before it draws or books anything."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "campus_id": "shu-baoshan",
                "name": "Baoshan campus",
                "map_version": "3f0c9a71d2e84b55",
                "origin": {"latitude_deg": 31.317, "longitude_deg": 121.388},
                "timezone": "Asia/Shanghai",
                "schematic": False,
                "attribution": "© OpenStreetMap contributors",
                "now": "2026-09-01T08:14:31Z",
                "open_now": True,
                "opens_next": "2026-09-01T08:14:31Z",
                "closes_at": "2026-09-01T14:00:00Z",
                "holiday": None,
                "has_timetable": True,
                "last_run_at": "2026-09-01T10:10:00Z",
                "seats_max": 6,
                "wheelchairs_max": 1,
                "booking_ahead_s_max": 604800.0,
            }
        }
    )

    campus_id: str
    name: str
    map_version: str
    origin: OriginView
    timezone: str
    schematic: bool
    attribution: str
    now: datetime = Field(description="The server's clock; all times refer to it.")
    open_now: bool
    opens_next: datetime | None = Field(description="When rides are possible next; null: not for weeks.")
    closes_at: datetime | None = Field(description="When the present opening ends; null: closed, or never.")
    holiday: str | None = Field(description="Today's holiday by name, or null on an ordinary day.")
    has_timetable: bool
    last_run_at: datetime | None = Field(description="When today's last timetable trip begins.")
    seats_max: int
    wheelchairs_max: int = Field(description="Wheelchair places of the shuttle that has the most.")
    booking_ahead_s_max: float


class StopView(BaseModel):
    model_config = ConfigDict(json_schema_extra={"example": STOP_EXAMPLE})

    stop_id: str
    name: str
    name_en: str
    lane_id: str
    s_m: float
    x_m: float
    y_m: float
    placed_by: str


class LaneShape(BaseModel):
    """A reference line. xy is x0, y0, x1, y1, ... in metres."""

    lane_id: str
    kind: Literal["road", "turn", "turnaround"]
    can_pass: bool
    width_m: float
    speed_limit_mps: float
    name: str
    name_en: str
    xy: list[float]


class BuildingShape(BaseModel):
    """An outline, closed implicitly. xy is x0, y0, x1, y1, ... in metres."""

    name: str
    height_m: float
    xy: list[float]


class AreaShape(BaseModel):
    """An observation area's outline, closed implicitly. xy is x0, y0, x1, y1, ... in metres."""

    area_id: str
    kind: Literal["intersection", "crossing"]
    xy: list[float]


class MapGeometry(BaseModel):
    """Everything to draw the campus with. It never changes for one map_version: keep it."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "map_version": "3f0c9a71d2e84b55",
                "bounds": [-410.0, -380.5, 402.0, 377.5],
                "lanes": [
                    {
                        "lane_id": "lane-17",
                        "kind": "road",
                        "can_pass": False,
                        "width_m": 6.0,
                        "speed_limit_mps": 4.17,
                        "name": "南路",
                        "name_en": "South Road",
                        "xy": [0.0, 0.0, 12.5, 0.4],
                    }
                ],
                "buildings": [{"name": "Library", "height_m": 18.0, "xy": [1.0, 2.0, 31.0, 2.0, 31.0, 22.0]}],
                "areas": [
                    {"area_id": "area-3", "kind": "crossing", "xy": [0.0, 0.0, 4.0, 0.0, 4.0, 9.0, 0.0, 9.0]}
                ],
                "stops": [],
            }
        }
    )

    map_version: str
    bounds: tuple[float, float, float, float] = Field(description="min x, min y, max x, max y")
    lanes: list[LaneShape]
    buildings: list[BuildingShape]
    areas: list[AreaShape]
    stops: list[StopView]


def campus_view(
    campus_id: str,
    network: RoadNetwork,
    rules: FleetRules,
    now: datetime,
    calendar: ServiceCalendar,
    today: ServiceDay,
    vehicles: Iterable[Vehicle],
    *,
    has_timetable: bool,
) -> CampusView:
    road_map = network.road_map
    last_run = today.last_run
    origin = road_map.origin
    return CampusView(
        campus_id=campus_id,
        name=road_map.name,
        map_version=road_map.map_version,
        origin=OriginView(latitude_deg=origin.latitude_deg, longitude_deg=origin.longitude_deg),
        timezone=road_map.timezone,
        schematic=road_map.schematic,
        attribution=road_map.attribution,
        now=now,
        open_now=calendar.is_open(now),
        opens_next=calendar.next_opening(now),
        closes_at=calendar.closes_after(now),
        holiday=None if today.holiday is None else today.holiday.note,
        has_timetable=has_timetable,
        last_run_at=None if last_run is None else last_run.calls[0].leave_at,
        seats_max=rules.seats_max,
        wheelchairs_max=max((vehicle.wheelchair_places for vehicle in vehicles), default=0),
        booking_ahead_s_max=rules.booking_ahead_s_max,
    )


def stop_view(stop: CampusStop) -> StopView:
    return StopView(
        stop_id=stop.stop_id,
        name=stop.name,
        name_en=stop.name_en,
        lane_id=stop.lane_id,
        s_m=stop.s_m,
        x_m=stop.x_m,
        y_m=stop.y_m,
        placed_by=stop.placed_by,
    )


def map_geometry(network: RoadNetwork, stops: tuple[CampusStop, ...]) -> MapGeometry:
    road_map = network.road_map
    outlines = [np.array(building.outline, dtype=np.float64) for building in road_map.buildings]
    drawn = [line.points for line in network.lines.values()] + outlines
    corners = np.concatenate(drawn) if drawn else np.zeros((1, 2))
    low, high = corners.min(axis=0), corners.max(axis=0)
    return MapGeometry(
        map_version=road_map.map_version,
        bounds=(float(low[0]), float(low[1]), float(high[0]), float(high[1])),
        lanes=[_lane(lane, network.lines[lane.lane_id].points) for lane in road_map.lanes],
        buildings=[
            _building(building, outline)
            for building, outline in zip(road_map.buildings, outlines, strict=True)
        ],
        areas=[
            AreaShape(area_id=area.area_id, kind=area.kind, xy=_flat(outline_array(area)))
            for area in road_map.observation_areas
        ],
        stops=[stop_view(stop) for stop in stops],
    )


def _lane(lane: Lane, points: Array) -> LaneShape:
    return LaneShape(
        lane_id=lane.lane_id,
        kind=lane.kind,
        can_pass=lane.can_pass,
        width_m=lane.width_m,
        speed_limit_mps=lane.speed_limit_mps,
        name=lane.name,
        name_en=lane.name_en,
        xy=_flat(points[simplified(points, DRAWING_TOLERANCE_M)]),
    )


def _building(building: Building, outline: Array) -> BuildingShape:
    return BuildingShape(name=building.name, height_m=building.height_m, xy=_flat(outline))


def _flat(points: Array) -> list[float]:
    return [round(float(value), 2) for value in points.ravel()]

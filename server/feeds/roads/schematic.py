"""The Snow Lion network: seven stations in a row with the published timetable, drawn as a meander.

Station order and times: Snow Lion, Table 1, and what its misprints mean. The paper gives no geometry, so
the lengths follow from the times: (shortest gap - dwell) x 7.41 km/h, the average speed of its Table 2.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, arc_lengths, pose_at, project, resample
from contract.roads.load import with_version
from contract.roads.model import ObservationArea, Origin, Point, RoadMap, Scenario, Stop, TimetableTrip
from contract.roads.section_graph import SectionGraph
from server.feeds.roads.lanes import curves, sections
from server.feeds.roads.lanes.drafts import LaneDraft, finished_lane
from server.feeds.roads.lanes.smoothing import smooth
from server.feeds.roads.places.areas import crossing_areas
from server.feeds.roads.places.resting import rest

AVERAGE_SPEED_MPS = 7.41 / 3.6
DWELL_S = 20
STATIONS = ("NN7", "NN20", "C6", "SE13", "GYM", "1B", "C1")
# Table 1 read by its columns; the last trip's 1B-C1 takes a minute longer than the others'.
TABLE_1 = (
    ("08:00", "08:03", "08:10", "", "", "", ""),
    ("08:20", "08:23", "08:30", "", "", "", ""),
    ("08:40", "08:43", "08:50", "09:02", "09:05", "09:06", "09:13"),
    ("", "", "", "09:25", "09:28", "09:29", "09:36"),
    ("", "", "", "09:48", "09:51", "09:52", "10:00"),
)
# The caption of Table 1. In the evening's hour and a half its last two trips have no room.
SHIFTS = (("morning", "08:00", "10:00"), ("noon", "12:00", "14:00"), ("evening", "17:30", "19:00"))
SERVICE = "daily"

_ORIGIN = Origin(latitude_deg=22.8925, longitude_deg=113.4780)
_LANE_GAP_M = 3.5
_WIDTH_M = 3.5
_SPEED_LIMIT_MPS = 15.0 / 3.6
_END_M = 45.0
_MEANDER_M = 1150.0
_MEANDER_RAD = 1.65
_BAY_M = 72.0
_BAY_RAMP_M = 20.0
_BAY_OUT_M = 3.2
_LOOP_RADIUS_M = 7.0
_LOOP_CURVATURE_1PM = 1.0 / 5.6
# People cross behind each station, where a shuttle that stands there does not hide them.
_CROSSING_BEFORE_M = 12.0
# The loops at the ends lie in the depots' yards; where shuttles turn in mid-road, they cross the other lane.
_SCENARIOS: dict[str, Scenario] = {
    "turn-west-end": "parking_lot",
    "turn-east-end": "parking_lot",
    "turn-C6": "unprotected_intersection",
    "turn-SE13": "unprotected_intersection",
}


def seconds(clock: str) -> int:
    """Seconds after midnight of hh:mm."""
    hours, minutes = clock.split(":")
    return 3600 * int(hours) + 60 * int(minutes)


def gaps_s() -> tuple[int, ...]:
    """The shortest time from each station to the next in Table 1."""
    rows = [[seconds(clock) if clock else None for clock in row] for row in TABLE_1]
    return tuple(
        min(row[k + 1] - row[k] for row in rows if row[k] is not None and row[k + 1] is not None)  # type: ignore[operator]
        for k in range(len(STATIONS) - 1)
    )


def timetable() -> tuple[TimetableTrip, ...]:
    """Table 1's five trips, and the two shifts that its caption calls similar, as far as they end in time."""
    trips = []
    for shift, begins, ends in SHIFTS:
        later_s = seconds(begins) - seconds(SHIFTS[0][1])
        for number, row in enumerate(TABLE_1, start=1):
            calls = tuple(
                (name, seconds(clock) + later_s) for name, clock in zip(STATIONS, row, strict=True) if clock
            )
            if calls[-1][1] <= seconds(ends):
                trips.append(TimetableTrip(f"{shift}-{number}", calls, SERVICE))
    return tuple(trips)


def station_s_m() -> tuple[float, ...]:
    """Where each station lies along the eastbound lane."""
    lengths = [(gap - DWELL_S) * AVERAGE_SPEED_MPS for gap in gaps_s()]
    return tuple(_END_M + sum(lengths[:k]) for k in range(len(STATIONS)))


def _meander(length_m: float) -> Array:
    """(n, 2) points of a sine-generated curve (Langbein and Leopold 1966), about its middle."""
    s = np.linspace(0.0, length_m, math.ceil(length_m) + 1)
    heading = _MEANDER_RAD * np.cos(2.0 * math.pi * s / _MEANDER_M + 0.9)
    step = length_m / (len(s) - 1)
    middle = (heading[:-1] + heading[1:]) / 2.0
    path = np.vstack(
        ([0.0, 0.0], np.cumsum(step * np.column_stack((np.cos(middle), np.sin(middle))), axis=0))
    )
    centred: Array = np.round(path - (path.min(axis=0) + path.max(axis=0)) / 2.0, 6)
    return centred


@dataclass(frozen=True, slots=True)
class _Bay:
    """A lay-by beside one direction's lane, from s_m on it."""

    name: str
    s_m: float


class _Line:
    """One direction of the road, cut into lanes, with lay-bys beside it."""

    def __init__(self, heading: str, points: Array) -> None:
        self.heading = heading
        self.points = points
        self.s = arc_lengths(points)
        self.lanes: list[tuple[float, float, LaneDraft]] = []
        self.bays: list[LaneDraft] = []

    def cut(self, cuts: list[float], bays: list[_Bay]) -> None:
        edges = sorted({0.0, float(self.s[-1]), *cuts, *(e for b in bays for e in (b.s_m, b.s_m + _BAY_M))})
        for k, (s0, s1) in enumerate(itertools.pairwise(edges)):
            draft = _draft(f"{self.heading}{k}", "road", self.between(s0, s1))
            if self.lanes:
                self.lanes[-1][2].successors.append(draft.lane_id)
            self.lanes.append((s0, s1, draft))
        for bay in bays:
            self._add_bay(bay)

    def _add_bay(self, bay: _Bay) -> None:
        straight = self.between(bay.s_m, bay.s_m + _BAY_M)
        aside = curves.step_aside(arc_lengths(straight), _BAY_RAMP_M, -_BAY_OUT_M)
        draft = _draft(f"bay-{bay.name}", "road", resample(curves.offset(straight, aside), 0.9))
        draft.points[0], draft.points[-1] = straight[0], straight[-1]
        self.ending(bay.s_m).successors.append(draft.lane_id)
        draft.successors.append(self.starting(bay.s_m + _BAY_M).lane_id)
        self.bays.append(draft)

    def between(self, s0: float, s1: float) -> Array:
        inside = self.points[(self.s > s0 + 0.05) & (self.s < s1 - 0.05)]
        ends = [[np.interp(q, self.s, self.points[:, c]) for c in (0, 1)] for q in (s0, s1)]
        piece: Array = resample(np.vstack((ends[0], inside, ends[1])), 0.95)
        return np.round(piece, 4)

    def ending(self, s_m: float) -> LaneDraft:
        return next(draft for _, s1, draft in self.lanes if abs(s1 - s_m) < 1e-6)

    def starting(self, s_m: float) -> LaneDraft:
        return next(draft for s0, _, draft in self.lanes if abs(s0 - s_m) < 1e-6)

    def at(self, s_m: float) -> tuple[LaneDraft, float]:
        s0, _, draft = next(lane for lane in self.lanes if lane[0] <= s_m < lane[1])
        return draft, s_m - s0


def _draft(lane_id: str, kind: str, points: Array) -> LaneDraft:
    return LaneDraft(lane_id, kind, points, _WIDTH_M, _SPEED_LIMIT_MPS, can_pass=True)  # type: ignore[arg-type]


def _turnaround(lane_id: str, before: LaneDraft, after: LaneDraft, left_first: bool) -> LaneDraft:
    start, end = curves.end_poses(before.points)[1], curves.end_poses(after.points)[0]
    arcs = curves.loop(start, end, _LOOP_RADIUS_M, left_first)
    assert arcs is not None
    points = smooth(arcs, _LOOP_CURVATURE_1PM)
    assert points is not None
    draft = _draft(lane_id, "turnaround", points)
    draft.scenario = _SCENARIOS[lane_id]
    before.successors.append(lane_id)
    draft.successors.append(after.lane_id)
    return draft


def _network() -> tuple[list[LaneDraft], _Line]:
    """All lanes, and the eastbound line, on which the stations lie."""
    station = dict(zip(STATIONS, station_s_m(), strict=True))
    path = _meander(station["C1"] + _END_M)
    back = curves.offset(path, _LANE_GAP_M)[::-1]
    east, west = _Line("east-", path), _Line("west-", back)

    def opposite(s_m: float) -> float:
        here = [float(np.interp(s_m, east.s, path[:, c])) for c in (0, 1)]
        return float(project(west.points, west.s, here[0], here[1], 0, len(west.points))[0])

    past_c6, before_se13 = station["C6"] + _END_M, station["SE13"] - _END_M
    east.cut(
        [past_c6, before_se13],
        [
            _Bay("NN7", station["NN7"] + 110.0),
            _Bay("NN20", station["NN20"] + 380.0),
            _Bay("C6", past_c6 + 500.0),
            _Bay("SE13", station["SE13"] + 110.0),
            _Bay("1B", station["1B"] + 380.0),
        ],
    )
    west.cut(
        [opposite(past_c6), opposite(before_se13)],
        [
            _Bay("GYM", opposite(station["SE13"] + 260.0)),
            _Bay("SE13-C6", opposite(past_c6 + 800.0)),
            _Bay("NN20-NN7", opposite(station["NN7"] + 260.0)),
        ],
    )
    turns = [
        _turnaround("turn-west-end", west.lanes[-1][2], east.lanes[0][2], left_first=False),
        _turnaround("turn-east-end", east.lanes[-1][2], west.lanes[0][2], left_first=False),
        _turnaround("turn-C6", east.ending(past_c6), west.starting(opposite(past_c6)), left_first=False),
        _turnaround(
            "turn-SE13", west.ending(opposite(before_se13)), east.starting(before_se13), left_first=False
        ),
    ]
    lanes = [draft for _, _, draft in (*east.lanes, *west.lanes)]
    return [*lanes, *east.bays, *west.bays, *turns], east


def _crossings(drafts: list[LaneDraft], east: _Line) -> tuple[ObservationArea, ...]:
    """One over both lanes before each station."""
    places: list[tuple[str, Point]] = []
    for name, s_m in zip(STATIONS, station_s_m(), strict=True):
        x, y, yaw = pose_at(east.points, east.s, s_m - _CROSSING_BEFORE_M)
        half_m = 0.5 * _LANE_GAP_M
        places.append((f"crossing-{name}", (x - half_m * math.sin(yaw), y + half_m * math.cos(yaw))))
    return crossing_areas(drafts, places, _LANE_GAP_M + _WIDTH_M)


def snow_lion_map() -> RoadMap:
    """The schematic map, complete and versioned."""
    drafts, east = _network()
    tiles = sections.tile(drafts)
    lanes = tuple(finished_lane(draft) for draft in drafts)
    graph = SectionGraph(tiles, [(lane.lane_id, lane.successors) for lane in lanes])
    stops = []
    for name, s_m in zip(STATIONS, station_s_m(), strict=True):
        draft, lane_s_m = east.at(s_m)
        stops.append(Stop(name, name, draft.lane_id, round(lane_s_m, 3), name_en=name, placed_by="hand"))
    bays = [i for i, tile in enumerate(tiles) if tile.lane_id.startswith("bay-") and not tile.conflicts]
    return with_version(
        RoadMap(
            campus_id="snow-lion",
            name="Snow Lion (schematic)",
            origin=_ORIGIN,
            lanes=lanes,
            sections=tiles,
            stops=tuple(stops),
            resting_places=rest(graph, stops, bays, (), lambda _one, _other: math.inf),
            timetable=timetable(),
            timezone="Asia/Shanghai",
            schematic=True,
            attribution="Stations and timetable: Table 1 of the Snow Lion paper; the geometry is invented",
            observation_areas=_crossings(drafts, east),
        )
    )

"""A road map with look-ups: lane of a pose, successors, sections and travel times."""

import bisect
import math
from array import array
from bisect import bisect_right
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array, IntArray, arc_lengths, curvatures, pose_at, project
from contract.roads.design_vehicle import LATERAL_COMFORT_MPS2
from contract.roads.model import Lane, RestingPlace, RoadMap, Section, Stop

AT_SEA_M = 15.0
# A destination this little behind the start on one lane is where the vehicle already is.
SAME_PLACE_M = 1e-6
_CELL_M = 15.0
_CHUNK = 12
# A quarter turn away from the lane weighs as much as this distance beside it.
_HEADING_WEIGHT_M = 4.0

Numbers = Sequence[float]


@dataclass(frozen=True, slots=True)
class LaneLine:
    """A lane's reference line: points (n, 2), s (n,), signed curvature (n,) in 1/m, and its length."""

    points: Array
    s: Array
    curvature_1pm: Array
    length_m: float


class RoadNetwork:
    """Look-ups over one immutable map. Lanes are also numbered by their place in `road_map.lanes`.

    lanes_before  the lanes that lead into each one, by number: see `_numbered`
    """

    def __init__(self, road_map: RoadMap, keep_points: bool = True) -> None:
        """keep_points: False lets go of the points of `road_map`'s lanes, which `lines` have as arrays.

        As objects they take a hundred bytes each. Its lanes then have their first and last point only.
        """
        self.map_version = road_map.map_version
        self.lines: dict[str, LaneLine] = {lane.lane_id: _line(lane) for lane in road_map.lanes}
        self.road_map = road_map if keep_points else _with_ends_only(road_map)
        road_map = self.road_map
        self.lanes: dict[str, Lane] = {lane.lane_id: lane for lane in road_map.lanes}
        self.lane_numbers: dict[str, int] = {lane.lane_id: i for i, lane in enumerate(road_map.lanes)}
        self.sections: dict[str, Section] = {section.section_id: section for section in road_map.sections}
        self.stops: dict[str, Stop] = {stop.stop_id: stop for stop in road_map.stops}
        self.resting_places: dict[str, RestingPlace] = {
            place.place_id: place for place in road_map.resting_places
        }
        self._sections_of: dict[str, tuple[Section, ...]] = _sections_by_lane(road_map)
        self._section_starts = {
            lane_id: [section.s_from_m for section in sections]
            for lane_id, sections in self._sections_of.items()
        }
        self._predecessors = _predecessors(road_map)
        self.lanes_before = _numbered(self._predecessors, self.lane_numbers)
        self._clocks: dict[float, dict[str, Array]] = {}
        self._lane_times: dict[float, Array] = {}
        # The clocks as plain numbers too: reading a single one is several times faster than from an array.
        self._readings: dict[tuple[str, float], tuple[Numbers, Numbers]] = {}
        self._grid = _grid(self)

    def successors(self, lane_id: str) -> tuple[str, ...]:
        """Lanes that can be entered from the end of this one."""
        return self.lanes[lane_id].successors

    def predecessors(self, lane_id: str) -> tuple[str, ...]:
        """Lanes from whose end this one can be entered, in map order."""
        return self._predecessors[lane_id]

    def sections_of(self, lane_id: str) -> tuple[Section, ...]:
        """The lane's sections in the direction of travel."""
        return self._sections_of[lane_id]

    def section_at(self, lane_id: str, s_m: float) -> Section:
        """The section that holds s_m on the lane, clamped to the lane's ends."""
        starts = self._section_starts[lane_id]
        return self._sections_of[lane_id][max(0, bisect.bisect_right(starts, s_m) - 1)]

    def pose(self, lane_id: str, s_m: float) -> tuple[float, float, float]:
        """(x, y, yaw) in the map frame at s_m on the lane."""
        line = self.lines[lane_id]
        x_m, y_m, yaw_rad = pose_at(line.points, line.s, s_m)
        return float(x_m), float(y_m), float(yaw_rad)

    def locate(self, x_m: float, y_m: float, yaw_rad: float) -> tuple[str, float, float] | None:
        """(lane_id, s_m, d_m) of the lane that a vehicle in this pose drives on; d_m positive to its left.

        Lanes that run against the heading are not considered. None farther than 15 m from every lane, or
        for a pose that is not finite.
        """
        if not (math.isfinite(x_m) and math.isfinite(y_m) and math.isfinite(yaw_rad)):
            return None
        best: tuple[float, str, float, float] | None = None
        for lane_id, first in self._near(x_m, y_m):
            line = self.lines[lane_id]
            s_m, d_m, segment = project(line.points, line.s, x_m, y_m, first, first + _CHUNK)
            if abs(d_m) > AT_SEA_M:
                continue
            step = line.points[segment + 1] - line.points[segment]
            along = math.cos(yaw_rad - math.atan2(step[1], step[0]))
            if along < 0.0:
                continue
            cost = abs(d_m) + _HEADING_WEIGHT_M * (1.0 - along)
            if best is None or (cost, lane_id, s_m) < best[:3]:
                best = (float(cost), lane_id, float(s_m), float(d_m))
        return None if best is None else best[1:]

    def clock(self, lane_id: str, speed_cap_mps: float = math.inf) -> Array:
        """(n,) seconds from the lane's start to each of its points.

        The speed is the least of the lane's limit, the cap, and sqrt(0.5 R), the comfortable speed in a
        curve of radius R (GEM, section on waypoints).
        """
        clocks = self._clocks.get(speed_cap_mps)
        if clocks is None:
            clocks = self._clocks[speed_cap_mps] = {
                lane.lane_id: _clock(lane, self.lines[lane.lane_id], speed_cap_mps)
                for lane in self.road_map.lanes
            }
        return clocks[lane_id]

    def time_between(self, lane_id: str, s_from_m: float, s_to_m: float, speed_cap_mps: float) -> float:
        """Seconds from one place on the lane to a later one on it."""
        known = self._readings.get((lane_id, speed_cap_mps))
        if known is None:
            clock = self.clock(lane_id, speed_cap_mps)
            known = self._readings[lane_id, speed_cap_mps] = (
                array("d", self.lines[lane_id].s),
                array("d", clock),
            )
        return _reading(*known, s_to_m) - _reading(*known, s_from_m)

    def travel_time_s(self, lane_id: str, speed_cap_mps: float = math.inf) -> float:
        """Seconds along the whole lane."""
        return float(self.clock(lane_id, speed_cap_mps)[-1])

    def lane_times(self, speed_cap_mps: float = math.inf) -> Array:
        """(lanes,) seconds along each whole lane, by lane number. To be read only."""
        times = self._lane_times.get(speed_cap_mps)
        if times is None:
            times = np.array([self.travel_time_s(lane_id, speed_cap_mps) for lane_id in self.lanes])
            self._lane_times[speed_cap_mps] = times
        return times

    def apart_m(self, stop_id: str, x_m: float, y_m: float) -> float:
        """From a stop to a point of the map, straight. KeyError for a stop that the map does not have."""
        stop = self.stops[stop_id]
        stop_x_m, stop_y_m, _ = self.pose(stop.lane_id, stop.s_m)
        return math.hypot(stop_x_m - x_m, stop_y_m - y_m)

    def is_open(self, lane_id: str, s_from_m: float, s_to_m: float, closed: frozenset[str]) -> bool:
        """No section between two places on the lane is among the closed ones."""
        return not any(
            section.section_id in closed
            for section in self._sections_of[lane_id]
            if section.s_to_m > s_from_m and section.s_from_m <= s_to_m
        )

    def shadow(self, section_id: str) -> frozenset[str]:
        """The sections that no other shuttle may enter while one stands in this one, itself included."""
        return frozenset((section_id, *self.sections[section_id].conflicts))

    def kept_clear(self, places: Collection[str]) -> frozenset[str]:
        """What a route between these resting places has to avoid: the shadow of every other one.

        A route that avoids it can be driven to its end however many shuttles rest (docs/contract/roads.md).
        """
        blocked: set[str] = set()
        for place in self.road_map.resting_places:
            if place.place_id not in places:
                blocked |= self.shadow(self.section_at(place.lane_id, place.s_m).section_id)
        return frozenset(blocked)

    def _near(self, x_m: float, y_m: float) -> list[tuple[str, int]]:
        column, row = math.floor(x_m / _CELL_M), math.floor(y_m / _CELL_M)
        found: dict[tuple[str, int], None] = {}
        for i in range(column - 1, column + 2):
            for j in range(row - 1, row + 2):
                found.update(dict.fromkeys(self._grid.get((i, j), ())))
        return list(found)


def _with_ends_only(road_map: RoadMap) -> RoadMap:
    return msgspec.structs.replace(
        road_map,
        lanes=tuple(
            msgspec.structs.replace(lane, points=(lane.points[0], lane.points[-1])) for lane in road_map.lanes
        ),
    )


def _line(lane: Lane) -> LaneLine:
    points: Array = np.array(lane.points, dtype=np.float64).reshape(-1, 2)
    s = arc_lengths(points)
    return LaneLine(points, s, curvatures(points), float(s[-1]))


def _reading(s: Numbers, clock: Numbers, at_m: float) -> float:
    """Linear in between, as numpy.interp; the ends hold beyond them."""
    if at_m >= s[-1]:
        return clock[-1]
    k = bisect_right(s, at_m) - 1
    if k < 0:
        return clock[0]
    return (clock[k + 1] - clock[k]) / (s[k + 1] - s[k]) * (at_m - s[k]) + clock[k]


def _clock(lane: Lane, line: LaneLine, speed_cap_mps: float) -> Array:
    cap = min(lane.speed_limit_mps, speed_cap_mps)
    comfortable = np.sqrt(LATERAL_COMFORT_MPS2 / np.maximum(np.abs(line.curvature_1pm), 1e-9))
    speed = np.minimum(cap, comfortable)
    step_s = np.diff(line.s) / np.minimum(speed[:-1], speed[1:])
    clock: Array = np.concatenate(([0.0], np.cumsum(step_s)))
    return clock


def _sections_by_lane(road_map: RoadMap) -> dict[str, tuple[Section, ...]]:
    found: dict[str, list[Section]] = {lane.lane_id: [] for lane in road_map.lanes}
    for section in road_map.sections:
        found[section.lane_id].append(section)
    return {
        lane_id: tuple(sorted(sections, key=lambda section: section.s_from_m))
        for lane_id, sections in found.items()
    }


def _predecessors(road_map: RoadMap) -> dict[str, tuple[str, ...]]:
    found: dict[str, list[str]] = {lane.lane_id: [] for lane in road_map.lanes}
    for lane in road_map.lanes:
        for successor in lane.successors:
            found[successor].append(lane.lane_id)
    return {lane_id: tuple(before) for lane_id, before in found.items()}


def _numbered(before: dict[str, tuple[str, ...]], numbers: dict[str, int]) -> tuple[IntArray, IntArray]:
    """(first, lanes): those that lead into lane n are lanes[first[n] : first[n + 1]]."""
    counts = [len(lane_ids) for lane_ids in before.values()]
    first: IntArray = np.concatenate(([0], np.cumsum(counts))).astype(np.int64)
    return first, np.array([numbers[name] for names in before.values() for name in names], dtype=np.int64)


def _grid(network: RoadNetwork) -> dict[tuple[int, int], list[tuple[str, int]]]:
    grid: dict[tuple[int, int], list[tuple[str, int]]] = {}
    for lane_id, line in network.lines.items():
        cells: NDArray[np.int64] = np.floor(line.points / _CELL_M).astype(np.int64)
        for first in range(0, len(cells) - 1, _CHUNK):
            for i, j in sorted({(int(c[0]), int(c[1])) for c in cells[first : first + _CHUNK + 1]}):
                grid.setdefault((i, j), []).append((lane_id, first))
    return grid

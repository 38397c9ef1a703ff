"""An order as one line to drive: the joined lanes of its visits, and the place of each visit on the line."""

import bisect
import itertools
import math
from dataclasses import dataclass

import msgspec

from contract.geometry import Pose2, project, wrap_angle
from contract.roads.network import RoadNetwork
from contract.roads.routing import ReferenceLine, Route, find_route, route_line
from contract.wire.messages import Visit

_BEHIND = 8
_AHEAD = 20
PASSED_M = 0.6


class VisitUnreachable(Exception):
    """A visit cannot be reached; the message says which and from where."""


class LanePoint(msgspec.Struct, frozen=True):
    """A place on a lane."""

    lane_id: str
    s_m: float


class OrderLine(msgspec.Struct, frozen=True):
    """An order's line.

    line_id      distinguishes lines; lane_from_m: where on the line each lane of line.lane_ids begins
    visit_s_m    (visit_id, place of the rear axle on the line), in driving order
    """

    line_id: int
    line: ReferenceLine
    lane_from_m: tuple[float, ...]
    visit_s_m: tuple[tuple[str, float], ...]

    def place(self, s_m: float) -> LanePoint:
        """The lane and the place on it at s_m on the line."""
        number = max(0, bisect.bisect_right(self.lane_from_m, s_m) - 1)
        return LanePoint(self.line.lane_ids[number], s_m - self.lane_from_m[number])

    def s_of(self, place: LanePoint, after_m: float) -> float | None:
        """Where the line next passes a place, from after_m on; None when it does not."""
        for number, lane_id in enumerate(self.line.lane_ids):
            s_m = self.lane_from_m[number] + place.s_m
            if lane_id == place.lane_id and s_m >= after_m:
                return s_m
        return None

    def visit_s(self, visit_id: str) -> float | None:
        return next((s_m for name, s_m in self.visit_s_m if name == visit_id), None)

    def along(self, pose_map: Pose2, segment: int) -> tuple[float, float, int]:
        """(s_m, d_m, segment) of a pose, searched near the last segment only: routes cross themselves."""
        line = self.line
        s_m, d_m, found = project(
            line.points, line.s, pose_map.x_m, pose_map.y_m, segment - _BEHIND, segment + _AHEAD
        )
        return float(s_m), float(d_m), int(found)

    def segment_at(self, s_m: float) -> int:
        return max(0, bisect.bisect_right(self.line.s, s_m) - 1)


@dataclass(frozen=True, slots=True)
class _Chain:
    """Lanes so far; at_m is the place on the last of them."""

    lanes: tuple[str, ...]
    at_m: float


def locate(network: RoadNetwork, pose_map: Pose2, expected: tuple[str, ...]) -> LanePoint | None:
    """Where the vehicle is; lanes it is expected on win where several lie under it. None: at sea."""
    for lane_id in expected:
        line = network.lines[lane_id]
        s_m, d_m, segment = project(line.points, line.s, pose_map.x_m, pose_map.y_m, 0, len(line.s))
        step = line.points[segment + 1] - line.points[segment]
        off_rad = abs(wrap_angle(pose_map.yaw_rad - math.atan2(step[1], step[0])))
        if abs(d_m) < 1.5 and off_rad < 0.8:
            return LanePoint(lane_id, float(s_m))
    found = network.locate(pose_map.x_m, pose_map.y_m, pose_map.yaw_rad)
    return None if found is None else LanePoint(found[0], found[1])


def order_line(network: RoadNetwork, visits: tuple[Visit, ...], start: LanePoint, line_id: int) -> OrderLine:
    """The line through all visits from the lane that the vehicle is on, to the end of the last lane.

    A visit whose route is empty, or does not lead on from where the vehicle is by then, gets its route from
    A*. Raises VisitUnreachable when there is none.
    """
    chain = _Chain((start.lane_id,), start.s_m)
    offsets: list[tuple[str, int, float]] = []
    for visit in visits:
        chain = _extend(network, chain, visit)
        offsets.append((visit.visit_id, len(chain.lanes) - 1, visit.s_m))
    lane_from = [0.0]
    for lane_id in chain.lanes[:-1]:
        lane_from.append(lane_from[-1] + network.lines[lane_id].length_m)
    end_m = network.lines[chain.lanes[-1]].length_m
    line = route_line(network, Route(chain.lanes, 0.0, end_m, lane_from[-1] + end_m, 0.0))
    visit_s = tuple((name, lane_from[number] + s_m) for name, number, s_m in offsets)
    return OrderLine(line_id, line, tuple(lane_from), visit_s)


def _extend(network: RoadNetwork, chain: _Chain, visit: Visit) -> _Chain:
    here = chain.lanes[-1]
    onward = _rest_of_route(network, visit, here, chain.at_m)
    if onward is None:
        route = find_route(network, here, max(0.0, chain.at_m - PASSED_M), visit.lane_id, visit.s_m)
        if route is None:
            raise VisitUnreachable(f"no way from lane {here} at {chain.at_m:.0f} m to visit {visit.visit_id}")
        onward = route.lane_ids
    return _Chain(chain.lanes + onward[1:], visit.s_m)


def _rest_of_route(network: RoadNetwork, visit: Visit, here: str, at_m: float) -> tuple[str, ...] | None:
    """The visit's own route from the lane `here` on, if it leads to the visit from there."""
    route = visit.route
    for i, lane_id in enumerate(route):
        rest = route[i:]
        if lane_id != here or (len(rest) == 1 and visit.s_m < at_m - PASSED_M):
            continue
        joined = all(b in network.successors(a) for a, b in itertools.pairwise(rest))
        return rest if joined and rest[-1] == visit.lane_id else None
    return None

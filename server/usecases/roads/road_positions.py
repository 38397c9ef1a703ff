"""A vehicle on its sections: which of them its body covers, and how many more it should get."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from contract.geometry import Pose2, project
from contract.roads.design_vehicle import FRONT_REACH_M, REAR_OVERHANG_M
from contract.roads.model import Section
from contract.roads.network import RoadNetwork
from contract.wire.messages import Status
from server.domain.planning.plans import PlannedVisit

_ON_SECTION_M = 0.75
# Localization noise, and the 0.2 m within which a shuttle stops.
ARRIVED_M = 3.0
_NOSE_ROOM_M = 1.5
# A status may be older than the releases that came meanwhile, by so much of the way.
_OLD_STATUS_M = 60.0


@dataclass(frozen=True, slots=True)
class RoadPosition:
    """Where the rear axle is: on which of the held sections, counted in driving order, and s on its lane."""

    index: int
    lane_id: str
    s_m: float


def under_body(network: RoadNetwork, lane_id: str, s_m: float) -> tuple[str, ...]:
    """The sections under a standing body, rear to front.

    Before the lane's start or beyond its end they are those of the only lane that leads there; at a fork
    or a merge, only the sections on the lane of the rear axle count.
    """
    first, last = s_m - REAR_OVERHANG_M, s_m + FRONT_REACH_M
    found = [
        section.section_id
        for section in network.sections_of(lane_id)
        if section.s_to_m > first and section.s_from_m < last
    ]
    before, after = network.predecessors(lane_id), network.successors(lane_id)
    if first < 0.0 and len(before) == 1:
        found.insert(0, network.sections_of(before[0])[-1].section_id)
    if last > network.lines[lane_id].length_m and len(after) == 1:
        found.append(network.sections_of(after[0])[0].section_id)
    return tuple(dict.fromkeys(found))


def road_position(network: RoadNetwork, held: Sequence[str], status: Status) -> RoadPosition:
    """Where a vehicle is on its held sections.

    A position on a section that was released meanwhile is moved to the first held one, since a status may be
    older than the release. That holds too where the vehicle comes by the same place once more: the reading
    with less of the way between it and the first held section wins. A position beside all of them is moved to
    the nearest held place that is driven in its direction. Raises ValueError without sections.
    """
    if not held:
        raise ValueError("a vehicle without held sections has no road position")
    on = _on_sections(network, held, status)
    if on is not None and on.index == 0:
        return on
    first = network.sections[held[0]]
    within_m = _OLD_STATUS_M if on is None else min(_OLD_STATUS_M, _travelled_m(network, held, on))
    if _is_just_before(network, first, status, within_m):
        return RoadPosition(0, first.lane_id, first.s_from_m)
    return on or _nearest(network, held, status.pose_map)


def _on_sections(network: RoadNetwork, held: Sequence[str], status: Status) -> RoadPosition | None:
    for index, section_id in enumerate(held):
        section = network.sections[section_id]
        inside = section.s_from_m - _ON_SECTION_M <= status.s_m <= section.s_to_m + _ON_SECTION_M
        if section.lane_id == status.lane_id and inside:
            return RoadPosition(
                index, section.lane_id, min(max(status.s_m, section.s_from_m), section.s_to_m)
            )
    return None


def _is_just_before(network: RoadNetwork, first: Section, status: Status, within_m: float) -> bool:
    """The reported place is so little of the way before a section."""
    if first.lane_id == status.lane_id and status.s_m < first.s_from_m:
        return first.s_from_m - status.s_m < within_m
    ends = [(first.lane_id, first.s_from_m)]
    begins_m: dict[str, float] = {}
    while ends:
        lane_id, way_m = ends.pop()
        for before in network.predecessors(lane_id):
            length_m = network.lines[before].length_m
            if before == status.lane_id and way_m + max(0.0, length_m - status.s_m) < within_m:
                return True
            begin_m = way_m + length_m
            if begin_m < min(within_m, begins_m.get(before, within_m)):
                begins_m[before] = begin_m
                ends.append((before, begin_m))
    return False


def _travelled_m(network: RoadNetwork, held: Sequence[str], place: RoadPosition) -> float:
    """From the beginning of the first held section."""
    passed_m = sum(_length_m(network, section_id) for section_id in held[: place.index])
    return passed_m + place.s_m - network.sections[held[place.index]].s_from_m


def _nearest(network: RoadNetwork, held: Sequence[str], pose_map: Pose2) -> RoadPosition:
    found: list[tuple[bool, float, int, RoadPosition]] = []
    for index, section_id in enumerate(held):
        section = network.sections[section_id]
        line = network.lines[section.lane_id]
        s_m, _, _ = project(line.points, line.s, pose_map.x_m, pose_map.y_m, 0, len(line.points))
        s_m = min(max(float(s_m), section.s_from_m), section.s_to_m)
        x_m, y_m, yaw_rad = network.pose(section.lane_id, s_m)
        is_against = math.cos(yaw_rad - pose_map.yaw_rad) < 0.0
        away_m = math.hypot(x_m - pose_map.x_m, y_m - pose_map.y_m)
        found.append((is_against, away_m, index, RoadPosition(index, section.lane_id, s_m)))
    return min(found, key=lambda one: one[:3])[3]


def ahead_of(
    network: RoadNetwork, held: Sequence[str], here: RoadPosition, distance_m: float
) -> RoadPosition:
    """The place so much farther along the held sections, or their end if they end before."""
    section = network.sections[held[here.index]]
    if here.s_m + distance_m <= section.s_to_m or here.index == len(held) - 1:
        return RoadPosition(here.index, here.lane_id, min(here.s_m + distance_m, section.s_to_m))
    following = network.sections[held[here.index + 1]]
    rest_m = distance_m - (section.s_to_m - here.s_m)
    start = RoadPosition(here.index + 1, following.lane_id, following.s_from_m)
    return ahead_of(network, held, start, rest_m)


def sections_to_request(
    network: RoadNetwork,
    held: Sequence[str],
    ahead: Sequence[str],
    here: RoadPosition,
    distance_m: float,
    halt: PlannedVisit | None,
) -> int:
    """How many sections ahead to request: distance_m of road, or what the next halt needs.

    A section that is still held is not requested again: the vehicle has to leave it first.
    """
    room_m = network.sections[held[here.index]].s_to_m - here.s_m
    room_m += sum(_length_m(network, section_id) for section_id in held[here.index + 1 :])
    wanted_m = distance_m
    if halt is not None:
        to_halt_m = _distance_m(network, (*held[here.index :], *ahead), here.s_m, halt)
        if to_halt_m is not None:
            wanted_m = min(wanted_m, to_halt_m + FRONT_REACH_M + _NOSE_ROOM_M)
    count = 0
    for section_id in ahead:
        if room_m >= wanted_m or section_id in held or section_id in ahead[:count]:
            break
        room_m += _length_m(network, section_id)
        count += 1
    return count


def _distance_m(
    network: RoadNetwork, sections: Sequence[str], s_m: float, visit: PlannedVisit
) -> float | None:
    """Along these sections from s_m on the first one to the visit; None when they do not pass it."""
    travelled_m = 0.0
    for number, section_id in enumerate(sections):
        section = network.sections[section_id]
        begin_m = s_m if number == 0 else section.s_from_m
        if section.lane_id == visit.lane_id and begin_m - ARRIVED_M <= visit.s_m <= section.s_to_m:
            return travelled_m + max(0.0, visit.s_m - begin_m)
        travelled_m += section.s_to_m - begin_m
    return None


def _length_m(network: RoadNetwork, section_id: str) -> float:
    section = network.sections[section_id]
    return section.s_to_m - section.s_from_m

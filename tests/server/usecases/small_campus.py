"""A campus that is rounded in two minutes: the one-way ring, two of its sides with a lay-by to rest in."""

from itertools import pairwise

import msgspec

from contract.roads.load import with_version
from contract.roads.model import Lane, Point, RestingPlace, RoadMap, Section, Stop
from tests.contract.roads.ring_map import SIDE_M, length_m, ring_map

_RAMP_M = 25.0
_OUT_M = 4.0
_PIECES = 4


def small_campus() -> RoadMap:
    ring = ring_map()
    bays = tuple(_bay(_lane(ring, side)) for side in ("side-1", "side-3"))
    joins = {"corner-0": "bay-1", "corner-2": "bay-3"}
    lanes = tuple(
        msgspec.structs.replace(lane, successors=(*lane.successors, joins[lane.lane_id]))
        if lane.lane_id in joins
        else lane
        for lane in ring.lanes
    )
    sections = {section.section_id: section for section in ring.sections}
    for bay in bays:
        for section in _bay_sections(bay):
            sections[section.section_id] = section
            for other in section.conflicts:
                before = sections[other]
                sections[other] = msgspec.structs.replace(
                    before, conflicts=(*before.conflicts, section.section_id)
                )
    return with_version(
        msgspec.structs.replace(
            ring,
            campus_id="small",
            lanes=(*lanes, *bays),
            sections=tuple(sections.values()),
            stops=tuple(Stop(f"stop-{k}", f"Side {k}", f"side-{k}", 60.0) for k in range(4)),
            resting_places=tuple(RestingPlace(bay.lane_id, bay.lane_id, length_m(bay) / 2.0) for bay in bays),
            map_version="",
        )
    )


def _lane(road_map: RoadMap, lane_id: str) -> Lane:
    return next(lane for lane in road_map.lanes if lane.lane_id == lane_id)


def _bay(side: Lane) -> Lane:
    """Beside the lane, out and in again: from the same point to the same point."""
    sign = 1.0 if side.points[0][0] > 0.0 else -1.0
    points: tuple[Point, ...] = tuple(
        (x + sign * _OUT_M * _out(min(s_m, SIDE_M - s_m)), y)
        for s_m, (x, y) in zip(_along(side), side.points, strict=True)
    )
    return msgspec.structs.replace(side, lane_id=side.lane_id.replace("side", "bay"), points=_dense(points))


def _along(lane: Lane) -> list[float]:
    return [SIDE_M * k / (len(lane.points) - 1) for k in range(len(lane.points))]


def _out(s_m: float) -> float:
    """From 0 to 1 over the ramp, level at both of its ends."""
    t = min(1.0, s_m / _RAMP_M)
    return t * t * t * (10.0 - 15.0 * t + 6.0 * t * t)


def _dense(points: tuple[Point, ...]) -> tuple[Point, ...]:
    """With a point between any two, so that the slanting ones lie less than a metre apart."""
    between = [((a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0) for a, b in pairwise(points)]
    return (*(p for pair in zip(points, between, strict=False) for p in pair), points[-1])


def _bay_sections(bay: Lane) -> list[Section]:
    """Ramps exclude the part of the side that they leave or join; whoever rests is in nobody's way."""
    side, total = bay.lane_id.replace("bay", "side"), length_m(bay)
    cuts = (0.0, total / _PIECES, total * (_PIECES - 1) / _PIECES, total)
    conflicts = ((f"{side}/0",), (), (f"{side}/{_PIECES - 1}",))
    return [Section(f"{bay.lane_id}/{k}", bay.lane_id, cuts[k], cuts[k + 1], conflicts[k]) for k in range(3)]

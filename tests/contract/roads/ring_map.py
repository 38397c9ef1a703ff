"""A small hand-made map: a one-way ring of four straight sides, with a lay-by to rest in on two of them."""

import math

from contract.roads.load import with_version
from contract.roads.model import Lane, Origin, Point, RestingPlace, RoadMap, Section, Stop

SIDE_M = 100.0
_RADIUS_M = 10.0


def _straight(begin: Point, end: Point) -> tuple[Point, ...]:
    steps = math.ceil(math.dist(begin, end))
    return tuple(
        (begin[0] + (end[0] - begin[0]) * k / steps, begin[1] + (end[1] - begin[1]) * k / steps)
        for k in range(steps + 1)
    )


def _corner(centre: Point, first_rad: float) -> tuple[Point, ...]:
    angles = [first_rad + (math.pi / 2.0) * k / 20 for k in range(21)]
    return tuple((centre[0] + _RADIUS_M * math.cos(a), centre[1] + _RADIUS_M * math.sin(a)) for a in angles)


def _lane(lane_id: str, points: tuple[Point, ...], *successors: str) -> Lane:
    kind = "road" if lane_id.startswith("side") else "turn"
    return Lane(lane_id, kind, points, 4.0, 4.0, False, successors)  # type: ignore[arg-type]


def ring_lanes() -> tuple[Lane, ...]:
    """side-0 runs east from the origin, then counter-clockwise: corner-0, side-1 north, ..., corner-3."""
    r, a = _RADIUS_M, SIDE_M
    return (
        _lane("side-0", _straight((0.0, 0.0), (a, 0.0)), "corner-0"),
        _lane("corner-0", _corner((a, r), -math.pi / 2.0), "side-1"),
        _lane("side-1", _straight((a + r, r), (a + r, r + a)), "corner-1"),
        _lane("corner-1", _corner((a, r + a), 0.0), "side-2"),
        _lane("side-2", _straight((a, 2 * r + a), (0.0, 2 * r + a)), "corner-2"),
        _lane("corner-2", _corner((0.0, r + a), math.pi / 2.0), "side-3"),
        _lane("side-3", _straight((-r, r + a), (-r, r)), "corner-3"),
        _lane("corner-3", _corner((0.0, r), math.pi), "side-0"),
    )


def length_m(lane: Lane) -> float:
    return sum(math.dist(a, b) for a, b in zip(lane.points, lane.points[1:], strict=False))


def ring_map() -> RoadMap:
    """One stop a side and one resting place: a second one would close the ring for everybody."""
    lanes = ring_lanes()
    sections = []
    for lane in lanes:
        total = length_m(lane)
        pieces = 4 if lane.lane_id.startswith("side") else 1
        cuts = [total * k / pieces for k in range(pieces + 1)]
        sections += [
            Section(f"{lane.lane_id}/{k}", lane.lane_id, cuts[k], cuts[k + 1]) for k in range(pieces)
        ]
    return with_version(
        RoadMap(
            campus_id="ring",
            name="Ring",
            origin=Origin(31.0, 121.0),
            lanes=lanes,
            sections=tuple(sections),
            stops=tuple(Stop(f"stop-{k}", f"Side {k}", f"side-{k}", 60.0) for k in range(3)),
            resting_places=(RestingPlace("rest-1", "side-3", 20.0),),
        )
    )

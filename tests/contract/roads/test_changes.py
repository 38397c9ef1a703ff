"""Which lanes another version of a map changes for a shuttle that drives by the present one."""

import msgspec
import pytest

from contract.roads.changes import changed_lanes
from contract.roads.load import with_version
from contract.roads.model import Lane, Origin, RoadMap, Stop
from contract.roads.network import RoadNetwork
from tests.contract.roads.ring_map import ring_map

RING = ring_map()
LANE = RING.lanes[0]


def with_lane(**fields: object) -> RoadMap:
    changed: Lane = msgspec.structs.replace(LANE, **fields)
    return msgspec.structs.replace(RING, lanes=(changed, *RING.lanes[1:]))


def changed(after: RoadMap) -> frozenset[str]:
    return changed_lanes(RoadNetwork(RING), RoadNetwork(with_version(after)))


@pytest.mark.parametrize(
    "after",
    [
        RING,
        msgspec.structs.replace(RING, name="Another name"),
        msgspec.structs.replace(RING, stops=(Stop("new", "New", LANE.lane_id, 3.0), *RING.stops)),
        with_lane(name="Main road"),
        with_lane(successors=(*LANE.successors, RING.lanes[5].lane_id)),
    ],
    ids=["nothing", "a name", "a stop", "a lane's name", "one more way on"],
)
def test_what_no_route_rests_on_changes_no_lane(after: RoadMap) -> None:
    assert changed(after) == frozenset()


@pytest.mark.parametrize(
    "fields",
    [
        {"speed_limit_mps": 1.5},
        {"width_m": 2.5},
        {"can_pass": not LANE.can_pass},
        {"successors": ()},
        {"points": tuple((x + 0.2, y) for x, y in LANE.points)},
        {"points": LANE.points[:-1]},
    ],
    ids=["limit", "width", "passing", "no way on", "moved", "shorter"],
)
def test_a_lane_that_drives_otherwise_is_named_and_no_other(fields: dict[str, object]) -> None:
    assert changed(with_lane(**fields)) == {LANE.lane_id}


def test_a_lane_with_other_tiles_and_one_that_is_gone_are_named() -> None:
    first = next(section for section in RING.sections if section.lane_id == LANE.lane_id)
    renamed = msgspec.structs.replace(first, section_id="another")
    tiles = tuple(renamed if section is first else section for section in RING.sections)
    assert changed(msgspec.structs.replace(RING, sections=tiles)) == {LANE.lane_id}
    without = tuple(one for one in RING.lanes if one.lane_id not in LANE.successors)
    kept = {lane.lane_id for lane in without}
    gone = msgspec.structs.replace(
        RING,
        lanes=tuple(
            msgspec.structs.replace(lane, successors=tuple(s for s in lane.successors if s in kept))
            for lane in without
        ),
        sections=tuple(section for section in RING.sections if section.lane_id in kept),
        stops=(),
        resting_places=(),
    )
    assert set(LANE.successors) <= changed(gone)


def test_another_origin_moves_every_lane() -> None:
    moved = msgspec.structs.replace(RING, origin=Origin(0.0, 0.0))
    assert changed(moved) == {lane.lane_id for lane in RING.lanes}

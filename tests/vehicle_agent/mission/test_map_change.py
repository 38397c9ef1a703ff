"""When a mission may go on by another map, and what it remembers then."""

import msgspec

from contract.geometry import Pose2
from contract.roads.load import with_version
from contract.roads.network import RoadNetwork
from tests.vehicle_agent.mission.ring import NETWORK, RingShuttle, a_visit, an_order, rest
from vehicle_agent.mission.map_change import OffTheLanes, mission_on
from vehicle_agent.mission.state import MissionState


def slower(lane_id: str) -> RoadNetwork:
    """The ring with another speed limit on one lane."""
    road_map = NETWORK.road_map
    lanes = tuple(
        msgspec.structs.replace(lane, speed_limit_mps=1.0) if lane.lane_id == lane_id else lane
        for lane in road_map.lanes
    )
    return RoadNetwork(with_version(msgspec.structs.replace(road_map, lanes=lanes, map_version="")))


RENAMED = RoadNetwork(with_version(msgspec.structs.replace(NETWORK.road_map, name="Renamed", map_version="")))


def on(shuttle: RingShuttle, after: RoadNetwork) -> MissionState | OffTheLanes | None:
    return mission_on(shuttle.state, NETWORK, after, shuttle.pose)


def a_shuttle_at_its_first_stop() -> RingShuttle:
    shuttle = RingShuttle()
    first = a_visit("a", "south", 60.0)
    shuttle.go(an_order((first, rest(("south", 60.0)))))
    shuttle.run_until(lambda: shuttle.doors_open)
    return shuttle


def test_a_vehicle_that_drives_does_not_change_over() -> None:
    shuttle = RingShuttle()
    shuttle.go(an_order((a_visit("a", "south", 60.0), rest(("south", 60.0)))))
    shuttle.run_until(lambda: shuttle.speed_mps > 1.0)
    assert on(shuttle, RENAMED) is None


def test_at_a_stop_it_changes_over_with_riders_and_doors_as_they_are() -> None:
    shuttle = a_shuttle_at_its_first_stop()
    assert on(shuttle, RENAMED) is shuttle.state


def test_an_order_over_a_changed_lane_is_finished_first() -> None:
    shuttle = a_shuttle_at_its_first_stop()
    assert on(shuttle, slower("north")) is None
    behind = on(shuttle, slower("west"))
    assert behind is shuttle.state, "the order does not lead there"
    shuttle.run_until(lambda: not shuttle.state.memory.open_visits())
    shuttle.run(1.0)
    moved = on(shuttle, slower("north"))
    assert isinstance(moved, MissionState)
    assert (moved.route, moved.place.lane_id) == (None, "north")
    assert moved.held is False
    assert all(not grant.section_id.startswith("north") for grant in moved.memory.grants)


def test_a_map_without_the_road_under_the_vehicle_is_refused() -> None:
    shuttle = a_shuttle_at_its_first_stop()
    shuttle.run_until(lambda: not shuttle.state.memory.open_visits())
    shuttle.run(1.0)
    away = mission_on(shuttle.state, NETWORK, RENAMED, Pose2(900.0, 900.0, 0.0))
    assert isinstance(away, OffTheLanes)
    assert "(900.0, 900.0) m" in away.detail

"""Another map is put in force under a fleet that drives: who keeps its road, and who is placed again."""

import msgspec
import pytest

from contract.roads.load import encode_map, with_version
from contract.roads.model import Lane, RoadMap
from contract.roads.network import RoadNetwork
from contract.wire.messages import MapChangeFailed
from server.domain.errors import MapInUse
from server.domain.record.incidents import IncidentKind
from server.usecases.fleet import campus as campuses
from server.usecases.fleet import map_changes
from server.usecases.orders import outbox
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fake_shuttle import FakeShuttle


def with_lanes(road_map: RoadMap, lane_ids: set[str], **fields: object) -> RoadMap:
    def changed(lane: Lane) -> Lane:
        return msgspec.structs.replace(lane, **fields) if lane.lane_id in lane_ids else lane

    lanes = tuple(changed(lane) for lane in road_map.lanes)
    return with_version(msgspec.structs.replace(road_map, lanes=lanes, map_version=""))


def publish(fleet: FakeFleet, road_map: RoadMap) -> str:
    content = encode_map(road_map)
    return fleet.campus.do(lambda uow: campuses.load_map(uow, content, "ann", activate=True)).map_version


def renamed(fleet: FakeFleet) -> RoadMap:
    road_map = fleet.network.road_map
    return with_version(msgspec.structs.replace(road_map, name="Renamed", map_version=""))


def change_over(shuttle: FakeShuttle, road_map: RoadMap) -> None:
    shuttle.network = RoadNetwork(road_map)
    shuttle.connect()


def driving_lanes(fleet: FakeFleet, vehicle_id: str) -> set[str]:
    held = fleet.campus.read(lambda uow: {o.vehicle_id: (*o.held_ids, *o.ahead) for o in uow.sections.all()})
    return {fleet.network.sections[section_id].lane_id for section_id in held[vehicle_id]}


def test_a_map_without_changes_of_the_road_is_put_in_force_under_driving_shuttles(fleet: FakeFleet) -> None:
    campus, after = fleet.campus, renamed(fleet)
    ride = fleet.book("NN20", "C6")
    for _ in range(10):
        fleet.step()
    before = campus.read(lambda uow: uow.sections.all())
    version = publish(fleet, after)
    assert campus.read(lambda uow: uow.sections.all()) == before
    assert all(vehicle.placed for vehicle in campus.read(lambda uow: uow.vehicles.all()))
    for shuttle in fleet.shuttles:
        told = campus.read(lambda uow, s=shuttle: map_changes.announcement(uow, s.vehicle_id, ""))
        assert told is not None
        assert (told.map_version, told.size_bytes) == (version, len(encode_map(after)))
        change_over(shuttle, after)
        assert campus.read(lambda uow, s=shuttle: map_changes.announcement(uow, s.vehicle_id, "")) is None
    fleet.run_until_idle(4000.0)
    assert {one.ride_id for one in fleet.rides() if one.state == "completed"} == {ride.ride_id}
    assert campus.read(lambda uow: uow.views.incidents(include_closed=True)) == ()


def test_a_vehicle_gets_no_new_order_before_it_has_changed_over(fleet: FakeFleet) -> None:
    campus, after = fleet.campus, renamed(fleet)
    publish(fleet, after)
    ride = fleet.book("NN20", "C6")
    assert ride.vehicle_id is not None
    shuttle = next(one for one in fleet.shuttles if one.vehicle_id == ride.vehicle_id)
    assert campus.read(lambda uow: outbox.outbox_of(uow, shuttle.vehicle_id)).order is None
    change_over(shuttle, after)
    for _ in range(3):
        fleet.step()
    assert shuttle.order is not None
    assert shuttle.order.map_version == after.map_version
    assert shuttle.rejected == []


def test_what_a_driving_shuttle_needs_is_not_changed_under_it(fleet: FakeFleet) -> None:
    campus = fleet.campus
    ride = fleet.book("NN20", "C6")
    for _ in range(5):
        fleet.step()
    assert ride.vehicle_id is not None
    lane_id = min(driving_lanes(fleet, ride.vehicle_id))
    slower = with_lanes(fleet.network.road_map, {lane_id}, speed_limit_mps=1.0)
    before = campus.read(lambda uow: uow.maps.active_version())
    with pytest.raises(MapInUse, match=f"{ride.vehicle_id} is under way and needs lane"):
        publish(fleet, slower)
    assert campus.read(lambda uow: uow.maps.active_version()) == before
    fleet.run_until_idle(4000.0)
    publish(fleet, slower)


def test_a_stop_that_riders_go_to_is_not_moved_away(fleet: FakeFleet) -> None:
    fleet.book("NN20", "C6")
    road_map = fleet.network.road_map
    stops = tuple(
        msgspec.structs.replace(stop, s_m=stop.s_m + 3.0) if stop.stop_id == "C6" else stop
        for stop in road_map.stops
    )
    moved = with_version(msgspec.structs.replace(road_map, stops=stops, map_version=""))
    with pytest.raises(MapInUse, match="stop C6"):
        publish(fleet, moved)


def test_a_resting_shuttle_on_a_changed_lane_is_placed_again_by_the_new_map(fleet: FakeFleet) -> None:
    campus, shuttle = fleet.campus, fleet.shuttles[0]
    after = with_lanes(fleet.network.road_map, {shuttle.place.lane_id}, speed_limit_mps=1.0)
    publish(fleet, after)
    placed = {v.vehicle_id: v.placed for v in campus.read(lambda uow: uow.vehicles.all())}
    assert placed[shuttle.vehicle_id] is False
    assert sum(placed.values()) == len(placed) - 1
    shuttle.report()
    assert not campus.read(lambda uow: uow.vehicles.get(shuttle.vehicle_id)).placed, "it has the old map"
    change_over(shuttle, after)
    assert campus.read(lambda uow: uow.vehicles.get(shuttle.vehicle_id)).placed


def test_a_vehicle_that_cannot_take_the_map_gets_no_rides_until_it_has_it(fleet: FakeFleet) -> None:
    campus, shuttle, after = fleet.campus, fleet.shuttles[0], renamed(fleet)
    version = publish(fleet, after)
    shuttle.say(MapChangeFailed(version, "not_stored", "No space left on device"))
    vehicle = campus.read(lambda uow: uow.vehicles.get(shuttle.vehicle_id))
    assert (vehicle.map_failure, vehicle.accepts_rides) == ("not_stored", False)
    (incident,) = campus.read(lambda uow: uow.views.incidents())
    assert (incident.kind, incident.vehicle_id) == (IncidentKind.MAP_NOT_CHANGED, shuttle.vehicle_id)
    assert "No space left" in incident.cause
    change_over(shuttle, after)
    vehicle = campus.read(lambda uow: uow.vehicles.get(shuttle.vehicle_id))
    assert vehicle.map_failure == ""
    assert campus.read(lambda uow: uow.views.incidents()) == ()


def test_a_roll_back_ends_the_failure_and_is_announced_to_who_may_be_on_its_way(fleet: FakeFleet) -> None:
    campus, shuttle = fleet.campus, fleet.shuttles[0]
    before = fleet.network.road_map.map_version
    version = publish(fleet, renamed(fleet))
    shuttle.say(MapChangeFailed(version, "off_the_lanes", "on no lane"))
    campus.do(lambda uow: campuses.activate_map(uow, before, "ann"))
    vehicle = campus.read(lambda uow: uow.vehicles.get(shuttle.vehicle_id))
    assert (vehicle.map_failure, campus.read(lambda uow: uow.views.incidents())) == ("", ())
    told = campus.read(lambda uow: map_changes.announcement(uow, shuttle.vehicle_id, version))
    assert told is not None
    assert told.map_version == before
    shuttle.say(MapChangeFailed(version, "not_downloaded", "late"))
    assert campus.read(lambda uow: uow.views.incidents()) == (), "of a map that is not in force any more"


def test_an_agent_that_cannot_fetch_maps_gets_no_rides_until_somebody_gave_it_the_map(
    fleet: FakeFleet,
) -> None:
    campus, shuttle, after = fleet.campus, fleet.shuttles[0], renamed(fleet)
    publish(fleet, after)
    for _ in range(2):
        campus.do(lambda uow: map_changes.note_old_agent(uow, shuttle.vehicle_id))
    assert not campus.read(lambda uow: uow.vehicles.get(shuttle.vehicle_id)).accepts_rides
    (incident,) = campus.read(lambda uow: uow.views.incidents())
    assert "update it" in incident.cause
    change_over(shuttle, after)
    assert campus.read(lambda uow: uow.vehicles.get(shuttle.vehicle_id)).map_failure == ""

"""Riders aboard a shuttle that cannot go on."""

from dataclasses import replace

import msgspec
import pytest

from contract.geometry import Pose2
from contract.wire.messages import ModeChanged, RiderAlighted
from server.domain.errors import NobodyAboard, VehicleUnknown
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import Ride, RideState
from server.travel.walking import on_foot_s
from server.usecases.fleet import vehicles
from server.usecases.rides import lost_vehicles
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fake_shuttle import FakeShuttle


def underway(fleet: FakeFleet, party: int = 2) -> tuple[Ride, FakeShuttle, FakeShuttle]:
    """A ride aboard and between stops, its shuttle, and the other one."""
    booked = fleet.book("NN20", "C6", party)
    fleet.run_until(lambda: fleet.ride(booked.ride_id).state is RideState.ABOARD)
    for _ in range(30):
        fleet.step()
    ride = fleet.ride(booked.ride_id)
    assert ride.state is RideState.ABOARD
    one, two = sorted(fleet.shuttles, key=lambda shuttle: shuttle.vehicle_id != ride.vehicle_id)
    return ride, one, two


def causes(fleet: FakeFleet, ride: Ride) -> dict[IncidentKind, str]:
    incidents = fleet.campus.read(lambda uow: uow.incidents.all_open())
    return {incident.kind: incident.cause for incident in incidents if incident.subject == ride.ride_id}


def test_a_fault_that_lasts_sends_the_riders_to_another_shuttle(fleet: FakeFleet) -> None:
    ride, lost, other = underway(fleet)
    lost.mode = "fault"
    lost.say(ModeChanged("fault", detail="motor"))
    fleet.step()
    assert fleet.ride(ride.ride_id).state is RideState.ABOARD
    fleet.campus.clock.advance(fleet.campus.rules.reassign_after_s)
    for _ in range(3):
        fleet.step()
    moved = fleet.ride(ride.ride_id)
    assert (moved.state, moved.vehicle_id) == (RideState.ASSIGNED, other.vehicle_id)
    assert (moved.stranded_by, moved.first_promise) == (lost.vehicle_id, ride.promise)
    assert moved.promise is not None
    assert moved.promise_broken
    assert moved.to_stop == ride.to_stop
    stop = fleet.network.stops[moved.from_stop].name
    assert f"another shuttle comes to {stop}" in causes(fleet, ride)[IncidentKind.PROMISE_BROKEN]
    # It stands in the way of the other one until it has been towed off.
    lost.aboard.clear()
    lost.connected = False
    fleet.campus.do(lambda uow: vehicles.retire(uow, lost.vehicle_id, "ann"))
    fleet.shuttles.remove(lost)
    fleet.run_until_idle(1800.0)
    assert fleet.ride(ride.ride_id).state is RideState.COMPLETED


def test_the_stop_where_they_wait_is_the_nearest_from_which_a_road_leads_there(fleet: FakeFleet) -> None:
    ride, lost, _ = underway(fleet)
    moved = fleet.campus.do(lambda uow: lost_vehicles.evacuate(uow, lost.vehicle_id, "ann"))[0]
    x_m, y_m, _ = fleet.network.pose(lost.place.lane_id, lost.place.s_m)

    def apart_m(stop_id: str) -> float:
        stop = fleet.network.stops[stop_id]
        there = fleet.network.pose(stop.lane_id, stop.s_m)
        return float((there[0] - x_m) ** 2 + (there[1] - y_m) ** 2) ** 0.5

    assert apart_m(moved.from_stop) == min(apart_m(stop_id) for stop_id in fleet.network.stops)
    assert moved.earliest > fleet.campus.clock.now()
    assert moved.ride_id == ride.ride_id


def test_a_silent_shuttle_keeps_its_riders(fleet: FakeFleet) -> None:
    ride, silent, _ = underway(fleet)
    silent.disconnect()
    fleet.campus.clock.advance(2 * fleet.campus.rules.reassign_after_s)
    fleet.campus.do(lost_vehicles.rescue_riders)
    assert fleet.ride(ride.ride_id).state is RideState.ABOARD


def test_riders_of_a_shuttle_taken_off_the_road_go_on_with_another(fleet: FakeFleet) -> None:
    ride, lost, other = underway(fleet)
    fleet.campus.do(lambda uow: vehicles.retire(uow, lost.vehicle_id, "ann"))
    moved = fleet.ride(ride.ride_id)
    assert (moved.state, moved.vehicle_id) == (RideState.ASSIGNED, other.vehicle_id)


def test_who_is_brought_to_the_destination_after_all_is_there(fleet: FakeFleet) -> None:
    ride, lost, other = underway(fleet)
    fleet.campus.do(lambda uow: lost_vehicles.evacuate(uow, lost.vehicle_id, "ann"))
    lost.say(RiderAlighted(ride.ride_id, "sensor"))
    assert fleet.ride(ride.ride_id).state is RideState.ASSIGNED
    stop = fleet.network.stops[ride.to_stop]
    lost.place = type(lost.place)(stop.lane_id, stop.s_m)
    lost.report()
    lost.say(RiderAlighted(ride.ride_id, "sensor"))
    assert fleet.ride(ride.ride_id).state is RideState.COMPLETED
    plan = fleet.campus.read(lambda uow: uow.plans.get(other.vehicle_id))
    assert plan is None or ride.ride_id not in plan.ride_ids


def test_a_shuttle_that_breaks_down_at_the_destination_ends_the_ride(fleet: FakeFleet) -> None:
    ride, lost, _ = underway(fleet)
    stop = fleet.network.stops[ride.to_stop]
    lost.place = type(lost.place)(stop.lane_id, stop.s_m)
    lost.report()
    fleet.campus.do(lambda uow: vehicles.retire(uow, lost.vehicle_id, "ann"))
    done = fleet.ride(ride.ride_id)
    assert (done.state, done.reason) == (RideState.FAILED, "vehicle_lost")
    assert "your stop is 1 minute away on foot" in done.reason_detail
    assert IncidentKind.RIDE_FAILED in causes(fleet, ride)


def test_an_empty_shuttle_cannot_be_evacuated(fleet: FakeFleet) -> None:
    for vehicle_id, error in (("shuttle-1", NobodyAboard), ("shuttle-9", VehicleUnknown)):
        with pytest.raises(error):
            fleet.campus.do(lambda uow, v=vehicle_id: lost_vehicles.evacuate(uow, v, "ann"))


def test_each_party_of_a_lost_shuttle_is_sent_its_own_way(fleet: FakeFleet) -> None:
    """One is at its destination already, the other one waits there for another shuttle."""
    ride, lost, other = underway(fleet)
    there = fleet.book("NN7", "NN20")
    riding = replace(there, state=RideState.ABOARD, vehicle_id=lost.vehicle_id, to_stop="NN20")
    fleet.campus.do(lambda uow: uow.rides.save(riding))
    stop = fleet.network.stops["NN20"]
    lost.place = type(lost.place)(stop.lane_id, stop.s_m)
    lost.report()
    told = fleet.campus.do(lambda uow: lost_vehicles.evacuate(uow, lost.vehicle_id, "ann"))
    moved, over = sorted(told, key=lambda one: one.ride_id == there.ride_id)
    assert (moved.ride_id, moved.from_stop) == (ride.ride_id, "NN20")
    assert (moved.state, moved.vehicle_id) == (RideState.ASSIGNED, other.vehicle_id)
    assert (over.ride_id, over.state) == (there.ride_id, RideState.FAILED)
    plan = fleet.campus.read(lambda uow: uow.plans.get(lost.vehicle_id))
    assert plan is not None
    assert not {ride.ride_id, there.ride_id} & set(plan.ride_ids)


def test_riders_are_told_how_long_the_way_on_foot_is(fleet: FakeFleet) -> None:
    ride, lost, _ = underway(fleet)
    (moved,) = fleet.campus.do(lambda uow: lost_vehicles.evacuate(uow, lost.vehicle_id, "ann"))
    minutes = round((moved.earliest - fleet.campus.clock.now()).total_seconds() / 60.0)
    assert minutes > 1
    assert f"{minutes} minutes on foot" in causes(fleet, ride)[IncidentKind.PROMISE_BROKEN]


def test_a_shuttle_that_breaks_down_short_of_the_destination_says_how_far_that_is(fleet: FakeFleet) -> None:
    ride, lost, _ = underway(fleet)
    stop = fleet.network.stops[ride.to_stop]
    walk_s = 150.0
    lost.place = type(lost.place)(stop.lane_id, stop.s_m - 1.0)
    lost.report()
    x_m, y_m, _ = fleet.network.pose(stop.lane_id, stop.s_m)
    away_m = walk_s * fleet.campus.rules.walk_mps / on_foot_s(1.0, 1.0)
    status = lost.status_report().status
    away = msgspec.structs.replace(status, pose_map=Pose2(x_m - away_m, y_m, 0.0))
    nearest = min(fleet.network.stops, key=lambda name: fleet.network.apart_m(name, x_m - away_m, y_m))
    assert nearest == ride.to_stop
    fleet.campus.do(lambda uow: uow.vehicles.save_position(lost.vehicle_id, away))
    fleet.campus.do(lambda uow: vehicles.retire(uow, lost.vehicle_id, "ann"))
    assert "your stop is 2 minutes away on foot" in fleet.ride(ride.ride_id).reason_detail


def test_riders_of_a_lost_shuttle_that_nobody_can_find_are_an_incident(fleet: FakeFleet) -> None:
    fleet.campus.enrol("shuttle-9")
    booked = fleet.book("NN20", "C6")
    riding = replace(booked, state=RideState.ABOARD, vehicle_id="shuttle-9")
    fleet.campus.do(lambda uow: uow.rides.save(riding))
    (done,) = fleet.campus.do(lambda uow: lost_vehicles.evacuate(uow, "shuttle-9", "ann"))
    assert (done.state, done.reason) == (RideState.FAILED, "vehicle_lost")
    assert "its position is not known" in done.reason_detail
    assert fleet.ride(booked.ride_id) == done


def test_a_lost_shuttle_without_a_resting_place_keeps_no_riders_of_another_one(fleet: FakeFleet) -> None:
    ride, lost, other = underway(fleet)
    riding = replace(fleet.book("NN20", "C1"), state=RideState.ABOARD, vehicle_id=other.vehicle_id)
    fleet.campus.do(lambda uow: uow.rides.save(riding))
    for shuttle in (lost, other):
        shuttle.mode = "fault"
        shuttle.say(ModeChanged("fault", detail="motor"))
    fleet.leave_homeless(lost.vehicle_id)
    fleet.campus.clock.advance(fleet.campus.rules.reassign_after_s)
    moved = fleet.campus.do(lost_vehicles.rescue_riders)
    assert {one.ride_id for one in moved} == {ride.ride_id, riding.ride_id}
    told = fleet.campus.read(lambda uow: uow.views.server_events())
    assert any(event.name == "plan.waits" and lost.vehicle_id in event.detail for event in told)

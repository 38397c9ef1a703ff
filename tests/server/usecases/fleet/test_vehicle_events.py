"""What has happened is the vehicle's word: once each, in order, whatever the server had planned."""

import pytest

from contract.geometry import Pose2
from contract.wire.messages import (
    Blocked,
    CommandDone,
    DestinationRequested,
    FaultRaised,
    FaultReport,
    HelpRequested,
    ModeChanged,
    OrderRejected,
    RiderAlighted,
    RiderBoarded,
    RiderDidNotAlight,
    SeatButtonPressed,
    SectionReleased,
    TapAnswered,
    VisitChanged,
)
from contract.wire.sequence import SequenceGap
from server.domain.errors import OrderUnknown, SessionFenced, VehicleUnknown
from server.domain.orders.orders import OrderState
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import Ride, RideState
from server.usecases.fleet import cabin_requests, vehicle_sessions, vehicles
from server.usecases.orders import orders, outbox
from server.usecases.orders.orders import REJECTIONS_MAX
from server.usecases.planning import plans
from server.usecases.record import commands, incidents
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.rides import rides
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fake_shuttle import FakeShuttle
from tests.server.usecases.shipped_maps import shipped_map
from vehicle_agent.mission.order_line import LanePoint


def shuttle_of(fleet: FakeFleet, ride: Ride) -> FakeShuttle:
    return next(shuttle for shuttle in fleet.shuttles if shuttle.vehicle_id == ride.vehicle_id)


def kinds(campus: CampusUnderTest) -> set[IncidentKind]:
    return {incident.kind for incident in campus.read(lambda uow: uow.views.incidents())}


def until(fleet: FakeFleet, ride: Ride, state: RideState, limit: int = 1500) -> None:
    for _ in range(limit):
        if fleet.ride(ride.ride_id).state is state:
            return
        fleet.step()
    raise AssertionError(fleet.stuck())


def test_a_repeated_event_has_its_effect_once_and_a_gap_is_not_taken(fleet: FakeFleet) -> None:
    shuttle = fleet.shuttles[0]
    shuttle.say(ModeChanged("manual", detail="driver"))
    again = shuttle.send(shuttle.sequence - 1)
    assert (again.is_new, again.next_sequence) == (False, shuttle.sequence)
    assert len(fleet.campus.read(lambda uow: uow.views.incidents())) == 1
    shuttle.told += [ModeChanged("autonomous"), ModeChanged("held")]
    with pytest.raises(SequenceGap) as gap:
        shuttle.send(shuttle.sequence + 1)
    assert gap.value.expected == shuttle.sequence


def test_an_unknown_vehicle_is_not_listened_to(campus: CampusUnderTest) -> None:
    ghost = FakeShuttle(campus, "ghost", campus.read(lambda uow: uow.network()), LanePoint("bay-NN7", 40.0))
    with pytest.raises(VehicleUnknown):
        ghost.connect()


def test_a_newer_session_fences_the_older(fleet: FakeFleet) -> None:
    shuttle = fleet.shuttles[0]
    old = shuttle.epoch
    shuttle.connect()
    with pytest.raises(SessionFenced):
        fleet.campus.read(lambda uow: vehicle_sessions.require_epoch(uow, shuttle.vehicle_id, old))
    fleet.campus.do(lambda uow: vehicle_sessions.close_session(uow, shuttle.vehicle_id, old))
    assert fleet.campus.read(lambda uow: enrolled_vehicle(uow, shuttle.vehicle_id)).connected


def test_boarding_wins_over_a_cancellation_that_crossed_with_it(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    until(driven_fleet, ride, RideState.BOARDING)
    driven_fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "passenger"))
    shuttle = shuttle_of(driven_fleet, ride)
    task = next(rider for rider in shuttle.order.visits[0].board) if shuttle.order else None
    assert task is not None
    shuttle.aboard[ride.ride_id] = task
    shuttle.say(RiderBoarded(ride.ride_id, "code"))
    assert driven_fleet.ride(ride.ride_id).state is RideState.ABOARD
    driven_fleet.run_until_idle(4000.0)
    assert driven_fleet.ride(ride.ride_id).state is RideState.COMPLETED


def test_a_rider_who_gets_off_early_completes_and_leaves_the_plan(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "GYM")
    until(driven_fleet, ride, RideState.ABOARD)
    shuttle = shuttle_of(driven_fleet, ride)
    for _ in range(20):
        driven_fleet.step()
    shuttle.say(SeatButtonPressed(2, True, "temporary-1", shuttle.place.lane_id, shuttle.place.s_m))
    del shuttle.aboard[ride.ride_id]
    shuttle.say(RiderAlighted(ride.ride_id, "sensor"))
    done = driven_fleet.ride(ride.ride_id)
    assert (done.state, done.left_early) == (RideState.COMPLETED, True)
    assert kinds(driven_fleet.campus) == set()
    plan = driven_fleet.campus.read(lambda uow: uow.plans.get(shuttle.vehicle_id))
    assert plan is not None
    assert plan.ride_ids == ()
    driven_fleet.run_until_idle(4000.0)


def test_a_seat_button_that_cannot_be_obeyed_is_shown_to_operators(fleet: FakeFleet) -> None:
    fleet.shuttles[0].say(SeatButtonPressed(1, False, "", "", 0.0, "no place before the next stop"))
    assert kinds(fleet.campus) == {IncidentKind.SEAT_BUTTON}


def test_a_rider_who_stays_gets_another_visit_and_the_second_time_the_ride_fails(
    driven_fleet: FakeFleet,
) -> None:
    ride = driven_fleet.book("NN20", "C6")
    until(driven_fleet, ride, RideState.ABOARD)
    shuttle = shuttle_of(driven_fleet, ride)
    shuttle.say(RiderDidNotAlight(ride.ride_id))
    assert driven_fleet.ride(ride.ride_id).state is RideState.ABOARD
    assert kinds(driven_fleet.campus) == {IncidentKind.RIDER_DID_NOT_ALIGHT}
    shuttle.say(RiderDidNotAlight(ride.ride_id))
    failed = driven_fleet.ride(ride.ride_id)
    assert (failed.state, failed.reason) == (RideState.FAILED, "did_not_alight")


def test_a_skipped_visit_gives_its_riders_to_another_shuttle(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    shuttle = shuttle_of(driven_fleet, ride)
    driven_fleet.step()
    assert shuttle.order is not None
    skipped = shuttle.order.visits[0]
    shuttle.states[skipped.visit_id] = "skipped"
    shuttle.say(VisitChanged(skipped.visit_id, skipped.stop_id, "skipped"))
    assert driven_fleet.ride(ride.ride_id).state is RideState.REQUESTED
    driven_fleet.run_until_idle(6000.0)
    assert driven_fleet.ride(ride.ride_id).state is RideState.COMPLETED


def test_a_visit_that_was_skipped_out_of_reach_gives_its_riders_to_another_shuttle_too(
    driven_fleet: FakeFleet,
) -> None:
    ride = driven_fleet.book("NN20", "C6")
    shuttle = shuttle_of(driven_fleet, ride)
    driven_fleet.step()
    visit = shuttle.next_visit()
    assert visit is not None
    shuttle.disconnect()
    shuttle.states[visit.visit_id] = "skipped"
    shuttle.say(VisitChanged(visit.visit_id, visit.stop_id, "skipped"))
    shuttle.connect()
    driven_fleet.run_until_idle(6000.0)
    assert driven_fleet.ride(ride.ride_id).state is RideState.COMPLETED


@pytest.mark.parametrize(
    ("event", "cleared", "kind"),
    [
        (ModeChanged("manual", detail="driver"), ModeChanged("autonomous"), IncidentKind.TAKEOVER),
        (
            ModeChanged("minimal_risk", detail="blind"),
            ModeChanged("autonomous"),
            IncidentKind.MINIMAL_RISK_STOP,
        ),
        (
            Blocked(0, False, 1.5, Pose2(0, 0, 0)),
            Blocked(0, True, 9.0, Pose2(0, 0, 0)),
            IncidentKind.VEHICLE_BLOCKED,
        ),
        (
            FaultRaised(FaultReport("lidar_blind", "stop", 0)),
            FaultRaised(FaultReport("lidar_blind", "stop", 0), cleared=True),
            IncidentKind.VEHICLE_FAULT,
        ),
        (
            FaultRaised(FaultReport("lidar_moved", "warning", 0, "front_left")),
            FaultRaised(FaultReport("lidar_moved", "warning", 0, "front_left"), cleared=True),
            IncidentKind.VEHICLE_FAULT,
        ),
    ],
)
def test_a_condition_opens_one_incident_and_its_end_closes_it(
    fleet: FakeFleet, event: object, cleared: object, kind: IncidentKind
) -> None:
    shuttle = fleet.shuttles[0]
    shuttle.say(event)  # type: ignore[arg-type]
    shuttle.say(event)  # type: ignore[arg-type]
    assert [i.kind for i in fleet.campus.read(lambda uow: uow.views.incidents())] == [kind]
    shuttle.say(cleared)  # type: ignore[arg-type]
    assert kinds(fleet.campus) == set()


def test_an_incident_names_the_lidar_and_another_lidar_is_another_incident(fleet: FakeFleet) -> None:
    shuttle = fleet.shuttles[0]
    shuttle.say(FaultRaised(FaultReport("lidar_moved", "warning", 0, "left")))
    shuttle.say(FaultRaised(FaultReport("lidar_moved", "warning", 0, "left, right")))
    shuttle.say(FaultRaised(FaultReport("lidar_moved", "warning", 0, "left"), cleared=True))
    # A name that is too long for a subject, from a vehicle that does not keep to the agreement.
    shuttle.say(FaultRaised(FaultReport("lidar_silent", "warning", 0, "x" * 200)))
    causes = [incident.cause for incident in fleet.campus.read(lambda uow: uow.views.incidents())]
    assert sorted(causes) == ["lidar_moved (left, right)", f"lidar_silent ({'x' * 80})"]


def test_a_held_vehicle_gets_no_rides_and_keeps_its_riders(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    until(driven_fleet, ride, RideState.ABOARD)
    shuttle = shuttle_of(driven_fleet, ride)
    shuttle.hold()
    for _ in range(60):
        driven_fleet.step()
    assert driven_fleet.ride(ride.ride_id).vehicle_id == shuttle.vehicle_id
    other = driven_fleet.book("NN20", "C6")
    assert other.vehicle_id != shuttle.vehicle_id
    driven_fleet.campus.do(lambda uow: rides.cancel(uow, other.ride_id, "passenger"))
    shuttle.resume()
    driven_fleet.run_until_idle(6000.0)
    assert driven_fleet.ride(ride.ride_id).state is RideState.COMPLETED


def test_rides_waiting_for_a_vehicle_that_is_lost_are_given_to_another(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    shuttle = shuttle_of(driven_fleet, ride)
    shuttle.disconnect()
    shuttle.mode = "held"
    assert ride.promise is not None
    while driven_fleet.ride(ride.ride_id).vehicle_id == shuttle.vehicle_id:
        assert driven_fleet.campus.clock.now() <= ride.promise.pickup_to
        driven_fleet.step()
    moved = driven_fleet.ride(ride.ride_id)
    assert moved.vehicle_id is not None
    assert moved.promise is not None
    assert moved.promise_broken == (moved.promise != ride.promise)
    if moved.promise_broken:
        assert moved.first_promise == ride.promise
        assert moved.promise.pickup_to > ride.promise.pickup_to
    shuttle.recover()
    driven_fleet.run_until_idle(6000.0)
    assert driven_fleet.ride(ride.ride_id).state is RideState.COMPLETED


def test_a_vehicle_that_lost_its_order_gets_it_again(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    shuttle = shuttle_of(driven_fleet, ride)
    driven_fleet.step()
    before = driven_fleet.campus.read(lambda uow: uow.orders.current(shuttle.vehicle_id))
    shuttle.order, shuttle.line = None, None
    shuttle.connect()
    again = driven_fleet.campus.read(lambda uow: uow.orders.current(shuttle.vehicle_id))
    assert before is not None
    assert again is not None
    assert (again.order_id, again.revision) == (before.order_id, before.revision + 1)
    assert again.state is OrderState.ISSUED
    driven_fleet.run_until_idle(6000.0)
    assert driven_fleet.ride(ride.ride_id).state is RideState.COMPLETED


def rejection(shuttle: FakeShuttle, revision: int, order_id: str, code: str) -> OrderRejected:
    return OrderRejected(shuttle.epoch, order_id, revision, code, "test")  # type: ignore[arg-type]


def test_an_order_that_is_rejected_again_and_again_becomes_an_incident(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    shuttle = shuttle_of(fleet, ride)
    campus = fleet.campus
    for count in range(REJECTIONS_MAX):
        order = campus.read(lambda uow: uow.orders.current(shuttle.vehicle_id))
        assert order is not None
        assert order.state is OrderState.ISSUED
        no = rejection(shuttle, order.revision, order.order_id, "map_version")
        campus.do(lambda uow, no=no: orders.rejected(uow, shuttle.vehicle_id, no))
        assert (IncidentKind.ORDER_REJECTED in kinds(campus)) == (count == REJECTIONS_MAX - 1)
    waiting = campus.read(lambda uow: outbox.outbox_of(uow, shuttle.vehicle_id))
    assert waiting.order is None


def test_an_order_that_came_too_late_is_sent_again_as_it_is(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    shuttle = shuttle_of(fleet, ride)
    campus = fleet.campus
    first = campus.read(lambda uow: outbox.outbox_of(uow, shuttle.vehicle_id)).order
    assert first is not None
    campus.clock.advance(300.0)
    no = rejection(shuttle, first.revision, first.order_id, "expired")
    campus.do(lambda uow: orders.rejected(uow, shuttle.vehicle_id, no))
    again = campus.read(lambda uow: outbox.outbox_of(uow, shuttle.vehicle_id)).order
    assert again is not None
    assert (again.order_id, again.revision) == (first.order_id, first.revision)
    assert again.expires_ns > first.expires_ns
    with pytest.raises(OrderUnknown):
        campus.do(lambda uow: orders.accepted(uow, shuttle.vehicle_id, "no-order", 1))


def test_a_release_counts_only_for_the_grant_in_force(fleet: FakeFleet) -> None:
    shuttle = fleet.shuttles[0]
    before = fleet.campus.read(lambda uow: uow.sections.all())
    held = before[0].held[0]
    shuttle.say(SectionReleased(held.section_id, held.fence + 99))
    shuttle.say(SectionReleased(held.section_id, held.fence))
    assert fleet.campus.read(lambda uow: uow.sections.all()) == before


def test_commands_and_taps_stay_in_the_outbox_until_they_are_answered(fleet: FakeFleet) -> None:
    campus = fleet.campus
    ride = fleet.book("NN20", "C6")
    shuttle = shuttle_of(fleet, ride)
    command = campus.do(
        lambda uow: commands.send_command(uow, shuttle.vehicle_id, "announce", "ann", "hello")
    )
    tap = campus.do(lambda uow: rides.tap(uow, ride.ride_id, "board"))
    waiting = campus.read(lambda uow: outbox.outbox_of(uow, shuttle.vehicle_id))
    assert [(c.command_id, c.text, c.epoch) for c in waiting.commands] == [
        (command.command_id, "hello", shuttle.epoch)
    ]
    assert [t.tap_id for t in waiting.taps] == [tap.tap_id]
    shuttle.say(CommandDone(command.command_id, True))
    shuttle.say(TapAnswered(tap.tap_id, ride.ride_id, False, "doors are shut"))
    waiting = campus.read(lambda uow: outbox.outbox_of(uow, shuttle.vehicle_id))
    assert (waiting.commands, waiting.taps) == ((), ())
    answered = campus.read(lambda uow: uow.rides.tap(tap.tap_id))
    assert answered is not None
    assert (answered.state, answered.reason) == ("refused", "doors are shut")


def test_a_tap_is_answered_once_and_by_the_shuttle_at_whose_door_it_was(fleet: FakeFleet) -> None:
    ride = fleet.book("NN20", "C6")
    shuttle = shuttle_of(fleet, ride)
    other = next(one for one in fleet.shuttles if one is not shuttle)
    tap = fleet.campus.do(lambda uow: rides.tap(uow, ride.ride_id, "board"))
    kept = lambda: fleet.campus.read(lambda uow: uow.rides.tap(tap.tap_id))  # noqa: E731
    other.say(TapAnswered(tap.tap_id, ride.ride_id, True))
    assert kept() == tap
    shuttle.say(TapAnswered(tap.tap_id, ride.ride_id, False, "doors are shut"))
    assert kept().state == "refused"
    shuttle.say(TapAnswered(tap.tap_id, ride.ride_id, True))
    assert (kept().state, kept().reason) == ("refused", "doors are shut")


def test_a_vehicle_at_sea_is_an_incident_and_is_not_placed(campus: CampusUnderTest) -> None:
    fleet = FakeFleet(campus, shipped_map("snow-lion"), 1)
    shuttle = fleet.shuttles[0]
    shuttle.connect_at(Pose2(9999.0, 9999.0, 0.0))
    assert kinds(campus) == {IncidentKind.IMPOSSIBLE_POSITION}
    assert not campus.read(lambda uow: enrolled_vehicle(uow, shuttle.vehicle_id)).placed
    shuttle.report()
    assert kinds(campus) == set()
    assert campus.read(lambda uow: enrolled_vehicle(uow, shuttle.vehicle_id)).placed


def test_two_vehicles_on_the_same_ground_are_an_incident_until_one_is_gone(campus: CampusUnderTest) -> None:
    fleet = FakeFleet(campus, shipped_map("snow-lion"), 2)
    one, two = fleet.shuttles
    two.place = one.place
    one.connect()
    two.connect()
    assert kinds(campus) == {IncidentKind.GROUND_CONFLICT}
    campus.do(lambda uow: vehicles.retire(uow, one.vehicle_id, "ann"))
    two.report()
    assert kinds(campus) == set()
    assert campus.read(lambda uow: enrolled_vehicle(uow, two.vehicle_id)).placed


def test_a_shuttle_that_was_retired_and_came_back_is_not_heard_on_its_old_session(fleet: FakeFleet) -> None:
    campus, shuttle = fleet.campus, fleet.shuttles[0]
    old_epoch = shuttle.epoch
    campus.do(lambda uow: vehicles.retire(uow, shuttle.vehicle_id, "ann"))
    with pytest.raises(SessionFenced):
        campus.do(lambda uow: vehicle_sessions.require_epoch(uow, shuttle.vehicle_id, old_epoch))
    campus.enrol(shuttle.vehicle_id)
    shuttle.connect()
    assert shuttle.epoch > old_epoch
    with pytest.raises(SessionFenced):
        campus.do(lambda uow: vehicle_sessions.require_epoch(uow, shuttle.vehicle_id, old_epoch))


def test_silence_is_an_incident_until_the_vehicle_is_heard_again(fleet: FakeFleet) -> None:
    campus = fleet.campus
    campus.clock.advance(campus.rules.silent_after_s + 1.0)
    fleet.shuttles[1].report()
    assert campus.do(vehicle_sessions.note_silence) == ("shuttle-1",)
    assert kinds(campus) == {IncidentKind.VEHICLE_SILENT}
    fleet.shuttles[0].report()
    assert campus.do(vehicle_sessions.note_silence) == ()
    assert kinds(campus) == set()


def test_a_promise_that_cannot_be_kept_is_told_anew_before_its_time(fleet: FakeFleet) -> None:
    """The only shuttle stands for a while; it is heard, so that nobody else would be asked."""
    ride = fleet.book("NN20", "C6")
    assert ride.promise is not None
    shuttle = shuttle_of(fleet, ride)
    for other in fleet.shuttles:
        other.hold()
    while not fleet.ride(ride.ride_id).promise_broken:
        assert fleet.campus.clock.now() < ride.promise.pickup_to
        fleet.step()
        fleet.campus.do(plans.refresh_expected)
    told = fleet.ride(ride.ride_id)
    assert told.first_promise == ride.promise
    assert told.promise is not None
    assert told.promise.pickup_to > ride.promise.pickup_to
    assert told.promise.arrive_by > ride.promise.arrive_by
    incident = fleet.campus.read(
        lambda uow: uow.incidents.open_about(IncidentKind.PROMISE_BROKEN, ride.ride_id)
    )
    assert incident is not None
    assert shuttle.vehicle_id in incident.cause
    assert "later than promised" in incident.cause


def test_a_vehicle_is_silent_though_it_was_heard_by_a_clock_set_back_since(fleet: FakeFleet) -> None:
    campus = fleet.campus
    campus.clock.advance(-3600.0)
    fleet.shuttles[1].report()
    assert campus.do(vehicle_sessions.note_silence) == ("shuttle-1",)


def test_a_vehicle_that_starts_after_the_clock_was_set_back_is_no_second_agent(fleet: FakeFleet) -> None:
    campus, shuttle = fleet.campus, fleet.shuttles[0]
    campus.clock.advance(-3600.0)
    conflict = campus.do(lambda uow: vehicle_sessions.key_conflict(uow, shuttle.vehicle_id, "boot-2"))
    assert conflict == ""


def test_a_call_for_help_on_board_is_the_most_urgent_and_its_caller_is_told_who_has_seen_it(
    fleet: FakeFleet,
) -> None:
    shuttle, campus = fleet.shuttles[0], fleet.campus
    shuttle.say(HelpRequested(2))
    shuttle.say(HelpRequested(2))
    (call,) = campus.read(lambda uow: uow.views.incidents())
    assert (call.kind, call.priority, call.vehicle_id) == (IncidentKind.HELP_CALL, 0, shuttle.vehicle_id)
    assert "seat 2" in call.cause
    for _ in range(2):
        campus.do(lambda uow: incidents.acknowledge(uow, call.incident_id, "ann"))
    sent = campus.read(lambda uow: uow.vehicles.pending_commands(shuttle.vehicle_id))
    assert [(command.kind, command.text) for command in sent] == [("announce", incidents.CALL_TAKEN)]


def test_a_party_aboard_goes_to_the_stop_that_it_chose_on_the_screen(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    until(driven_fleet, ride, RideState.ABOARD)
    shuttle = shuttle_of(driven_fleet, ride)
    _ask_for(driven_fleet, shuttle, ride.ride_id, "NN7")
    assert driven_fleet.ride(ride.ride_id).to_stop == "NN7"
    assert _said(driven_fleet, shuttle) == [cabin_requests.CHANGED]
    until(driven_fleet, ride, RideState.COMPLETED)


def test_a_new_destination_that_is_refused_changes_nothing_and_is_answered(driven_fleet: FakeFleet) -> None:
    ride = driven_fleet.book("NN20", "C6")
    shuttle = shuttle_of(driven_fleet, ride)
    # Not aboard yet; and a stop that the map does not have.
    _ask_for(driven_fleet, shuttle, ride.ride_id, "NN7")
    until(driven_fleet, ride, RideState.ABOARD)
    _ask_for(driven_fleet, shuttle, ride.ride_id, "atlantis")
    assert driven_fleet.ride(ride.ride_id).to_stop == "C6"
    assert _said(driven_fleet, shuttle) == [cabin_requests.NOT_CHANGED] * 2


def _ask_for(fleet: FakeFleet, shuttle: FakeShuttle, ride_id: str, stop_id: str) -> None:
    request = DestinationRequested(ride_id, stop_id)
    shuttle.say(request)
    campus = fleet.campus
    campus.wait_for(
        cabin_requests.answer_destination_request(campus.transactions, shuttle.vehicle_id, request)
    )


def _said(fleet: FakeFleet, shuttle: FakeShuttle) -> list[str]:
    """What was announced on board and is not answered yet."""
    sent = fleet.campus.read(lambda uow: uow.vehicles.pending_commands(shuttle.vehicle_id))
    return [command.text for command in sent if command.kind == "announce"]

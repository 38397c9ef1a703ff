"""Hold, recall and reassign: what they do, and that a preview says just that and changes nothing."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime, timedelta

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.wire.messages import CommandDone, ModeChanged
from server.dispatch.solve import Budget, solve
from server.domain.errors import (
    DomainError,
    ReassignmentRefused,
    RideAlreadyAboard,
    RideNotAssigned,
    RideUnknown,
    VehicleUnknown,
)
from server.domain.rides.effects import Effects, Intervention
from server.domain.rides.rides import Ride, RideState
from server.domain.service.timetable import DepartureState
from server.store.tables import metadata
from server.usecases.fleet import departures, interventions
from server.usecases.fleet.interventions import intervene
from server.usecases.planning import plans
from server.usecases.planning.decisions import SearchSettings
from server.usecases.planning.snapshot import take_snapshot
from server.usecases.record import commands
from server.usecases.record.dry_run import roll_back
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fresh_database import fresh_database
from tests.server.usecases.shipped_maps import shipped_map
from tests.server.usecases.small_campus import small_campus


@pytest.fixture
def fleet() -> Iterator[FakeFleet]:
    campus = CampusUnderTest(shipped_map("snow-lion"), engine=fresh_database())
    yield FakeFleet(campus, shipped_map("snow-lion"), 3).start()
    campus.close()


def everything(campus: CampusUnderTest) -> dict[str, list[tuple[object, ...]]]:
    """Every row of every table."""
    with campus.engine.connect() as connection:
        return {
            table.name: sorted(map(tuple, connection.execute(table.select())), key=repr)
            for table in metadata.sorted_tables
        }


def preview(campus: CampusUnderTest, vehicle_id: str, wish: Intervention) -> Effects:
    done = campus.wait_for(
        roll_back(campus.transactions, lambda uow: intervene(uow, vehicle_id, wish, "ann"))
    )
    return done.effects


def done(campus: CampusUnderTest, vehicle_id: str, wish: Intervention) -> Effects:
    return campus.do(lambda uow: intervene(uow, vehicle_id, wish, "ann")).effects


def assigned_rides(fleet: FakeFleet, count: int, ahead_s: float = 0.0) -> list[Ride]:
    earliest = fleet.campus.clock.now() + timedelta(seconds=ahead_s)
    pairs = [("NN20", "C6"), ("C6", "NN20"), ("SE13", "NN20"), ("NN7", "SE13")]
    return [fleet.book(a, b, earliest=earliest) for a, b in pairs[:count]]


WISHES = st.one_of(
    st.builds(Intervention, st.just("hold"), st.sampled_from([None, 30.0, 300.0, 1500.0])),
    st.just(Intervention("recall")),
    st.just(Intervention("reassign")),
    st.builds(
        Intervention,
        st.just("reassign"),
        ride_id=st.sampled_from(["first", "second"]),
        to_vehicle_id=st.sampled_from(["", "shuttle-1", "shuttle-2"]),
    ),
)


@settings(max_examples=25, deadline=None)
@given(
    trips=st.lists(st.tuples(st.integers(0, 3), st.integers(1, 3), st.integers(1, 4)), max_size=5),
    steps=st.integers(0, 40),
    which=st.sampled_from(["shuttle-1", "shuttle-2"]),
    wish=WISHES,
)
def test_an_intervention_does_what_its_preview_said(
    trips: list[tuple[int, int, int]], steps: int, which: str, wish: Intervention
) -> None:
    road_map = small_campus()
    campus = CampusUnderTest(road_map, engine=fresh_database())
    fleet = FakeFleet(campus, road_map, 2).start()
    for origin, onward, party in trips:
        fleet.book(f"stop-{origin}", f"stop-{(origin + onward) % 4}", party)
        for _ in range(steps // 4):
            fleet.step()
    for _ in range(steps):
        fleet.step()
    if wish.ride_id:
        rides = sorted(fleet.rides(), key=lambda ride: ride.requested_at)
        number = ["first", "second"].index(wish.ride_id)
        if number >= len(rides):
            campus.close()
            return
        wish = Intervention("reassign", ride_id=rides[number].ride_id, to_vehicle_id=wish.to_vehicle_id)
    before = everything(campus)
    try:
        said = preview(campus, which, wish)
    except DomainError as refused:
        with pytest.raises(type(refused)):
            done(campus, which, wish)
        campus.close()
        return
    assert everything(campus) == before
    campus.do(plans.refresh_expected)
    old = {ride.ride_id: ride for ride in fleet.rides()}
    assert done(campus, which, wish) == said
    told = {effect.ride_id: effect for effect in said.rides}
    for ride in fleet.rides():
        was = old[ride.ride_id]
        if ride.ride_id in told:
            assert told[ride.ride_id].vehicle_before == was.vehicle_id
            assert told[ride.ride_id].vehicle_after == ride.vehicle_id
            if not told[ride.ride_id].waits:
                assert told[ride.ride_id].arrival_after == ride.arrival_eta
        else:
            assert (ride.vehicle_id, ride.state) == (was.vehicle_id, was.state)
            assert ride.arrival_eta == was.arrival_eta or (
                ride.arrival_eta is not None
                and was.arrival_eta is not None
                and abs(ride.arrival_eta - was.arrival_eta) < timedelta(seconds=1)
            )
    campus.do(plans.assign_waiting)
    assert {r.ride_id: r.vehicle_id for r in fleet.rides()} == {
        r.ride_id: told[r.ride_id].vehicle_after if r.ride_id in told else r.vehicle_id for r in old.values()
    }
    campus.close()


def test_a_hold_until_resumed_gives_waiting_rides_to_others_at_once(fleet: FakeFleet) -> None:
    ride = assigned_rides(fleet, 1, 1200.0)[0]
    first = ride.vehicle_id or ""
    effects = done(fleet.campus, first, Intervention("hold"))
    moved = fleet.ride(ride.ride_id)
    assert moved.state is RideState.ASSIGNED
    assert moved.vehicle_id != first
    assert [(e.vehicle_before, e.vehicle_after, e.breaks) for e in effects.rides] == [
        (first, moved.vehicle_id, False)
    ]
    assert fleet.campus.read(lambda uow: enrolled_vehicle(uow, first)).held


def test_riders_of_a_held_shuttle_wait_until_it_is_resumed(fleet: FakeFleet) -> None:
    ride = assigned_rides(fleet, 1)[0]
    fleet.run_until(lambda: fleet.ride(ride.ride_id).state is RideState.ABOARD)
    (effect,) = preview(fleet.campus, ride.vehicle_id or "", Intervention("hold")).rides
    assert effect.waits
    assert (effect.vehicle_after, effect.arrival_after, effect.arrival_later_s) == (
        ride.vehicle_id,
        None,
        None,
    )


def test_a_short_hold_delays_by_its_length_and_ends_by_itself(fleet: FakeFleet) -> None:
    ride = assigned_rides(fleet, 1)[0]
    vehicle_id = ride.vehicle_id or ""
    shuttle = next(s for s in fleet.shuttles if s.vehicle_id == vehicle_id)
    (effect,) = done(fleet.campus, vehicle_id, Intervention("hold", for_s=120.0)).rides
    assert effect.vehicle_after == vehicle_id
    assert effect.pickup_later_s == pytest.approx(120.0)
    assert effect.arrival_later_s == pytest.approx(120.0)
    assert not effect.breaks
    shuttle.hold()
    assert fleet.campus.do(interventions.end_holds) == ()
    fleet.campus.clock.advance(121.0)
    assert fleet.campus.do(interventions.end_holds) == (vehicle_id,)
    words = fleet.campus.read(lambda uow: uow.vehicles.pending_commands(vehicle_id))
    assert [(word.kind, word.by) for word in words] == [("hold", "ann"), ("resume", "server")]
    shuttle.resume()
    fleet.run_until_idle(4000.0)
    assert fleet.ride(ride.ride_id).state is RideState.COMPLETED


def test_a_long_hold_gives_away_what_it_makes_late_and_the_preview_names_a_broken_promise(
    fleet: FakeFleet,
) -> None:
    ride = assigned_rides(fleet, 1, 1200.0)[0]
    first = ride.vehicle_id or ""
    (moves,) = preview(fleet.campus, first, Intervention("hold", for_s=3600.0)).rides
    assert moves.vehicle_after not in (first, None)
    for shuttle in fleet.shuttles:
        if shuttle.vehicle_id != first:
            shuttle.hold()
    (stays,) = preview(fleet.campus, first, Intervention("hold", for_s=3600.0)).rides
    assert (stays.vehicle_after, stays.breaks) == (first, True)


@pytest.mark.parametrize("mode", ["manual", "fault", "minimal_risk"])
def test_a_shuttle_that_stands_for_another_reason_is_not_resumed_by_the_clock(
    fleet: FakeFleet, mode: str
) -> None:
    shuttle = fleet.shuttles[0]
    done(fleet.campus, shuttle.vehicle_id, Intervention("hold", for_s=60.0))
    shuttle.hold()
    shuttle.say(ModeChanged(mode, detail="test"))  # type: ignore[arg-type]
    shuttle.hold()
    fleet.campus.clock.advance(100.0)
    assert fleet.campus.do(interventions.end_holds) == ()


def test_a_restarted_shuttle_is_not_resumed_by_the_clock(fleet: FakeFleet) -> None:
    shuttle = fleet.shuttles[0]
    done(fleet.campus, shuttle.vehicle_id, Intervention("hold", for_s=60.0))
    shuttle.boot_id, shuttle.told, shuttle.sequence, shuttle.mode = "boot-2", [], 0, "held"
    shuttle.connect()
    fleet.campus.clock.advance(100.0)
    assert fleet.campus.do(interventions.end_holds) == ()


def test_a_hold_for_a_while_of_a_shuttle_that_stands_already_ends_with_its_operator(
    fleet: FakeFleet,
) -> None:
    shuttle = fleet.shuttles[0]
    shuttle.hold()
    done(fleet.campus, shuttle.vehicle_id, Intervention("hold", for_s=60.0))
    fleet.campus.clock.advance(100.0)
    assert fleet.campus.do(interventions.end_holds) == ()


def test_a_hold_that_the_shuttle_refuses_leaves_it_in_use(fleet: FakeFleet) -> None:
    shuttle = fleet.shuttles[0]
    command = fleet.campus.do(lambda uow: interventions.hold(uow, shuttle.vehicle_id, "ann"))
    assert not fleet.campus.read(lambda uow: enrolled_vehicle(uow, shuttle.vehicle_id)).accepts_rides
    shuttle.say(CommandDone(command.command_id, False, "driven by hand"))
    assert fleet.campus.read(lambda uow: enrolled_vehicle(uow, shuttle.vehicle_id)).accepts_rides


def test_a_command_is_answered_once_and_by_its_own_shuttle(fleet: FakeFleet) -> None:
    shuttle, other, *_ = fleet.shuttles
    command = fleet.campus.do(lambda uow: interventions.hold(uow, shuttle.vehicle_id, "ann"))
    answered = lambda: fleet.campus.read(lambda uow: uow.vehicles.command(command.command_id))  # noqa: E731
    other.say(CommandDone(command.command_id, False, "not mine"))
    assert answered() == command
    shuttle.say(CommandDone(command.command_id, True))
    assert (answered().state, answered().detail) == ("done", "")
    shuttle.say(CommandDone(command.command_id, False, "changed my mind"))
    assert (answered().state, answered().detail) == ("done", "")


def test_a_hold_that_was_taken_back_before_the_shuttle_heard_of_it_leaves_it_in_use(
    fleet: FakeFleet,
) -> None:
    shuttle, campus = fleet.shuttles[0], fleet.campus
    hold = campus.do(lambda uow: interventions.hold(uow, shuttle.vehicle_id, "ann", 600.0))
    resume = campus.do(lambda uow: commands.send_command(uow, shuttle.vehicle_id, "resume", "ann"))
    for command in (hold, resume):
        shuttle.say(CommandDone(command.command_id, True))
    vehicle = campus.read(lambda uow: enrolled_vehicle(uow, shuttle.vehicle_id))
    assert vehicle.accepts_rides
    assert vehicle.hold_ends is None


def test_departures_of_a_held_or_recalled_shuttle_go_to_another_one() -> None:
    road_map = shipped_map("snow-lion")
    for wish in (Intervention("hold"), Intervention("recall"), Intervention("hold", for_s=7200.0)):
        seven = datetime.fromisoformat("2026-11-23T07:05:00+08:00")
        campus = CampusUnderTest(road_map, engine=fresh_database(), now=seven)
        fleet = FakeFleet(campus, road_map, 3).start()
        (departure, *_) = campus.do(departures.plan_departures)
        first = departure.vehicle_id or ""
        said = preview(campus, first, wish)
        effects = done(campus, first, wish)
        assert effects == said
        after = campus.read(lambda uow, d=departure: uow.departures.get(d.departure_id))
        assert after is not None
        assert after.state is DepartureState.ASSIGNED
        assert after.vehicle_id not in (first, None)
        moved = {e.departure_id: (e.vehicle_before, e.vehicle_after) for e in effects.departures}
        assert moved[departure.departure_id] == (first, after.vehicle_id)
        assert fleet.campus is campus
        campus.close()


def test_a_ride_given_to_a_named_shuttle_stays_there(fleet: FakeFleet) -> None:
    ride = assigned_rides(fleet, 1)[0]
    first = ride.vehicle_id or ""
    other = next(s.vehicle_id for s in fleet.shuttles if s.vehicle_id != first)
    wish = Intervention("reassign", ride_id=ride.ride_id, to_vehicle_id=other)
    (effect,) = done(fleet.campus, first, wish).rides
    assert (effect.vehicle_before, effect.vehicle_after) == (first, other)
    assigned_rides(fleet, 3)
    improvement = fleet.campus.read(lambda uow: plans.improvement_of(take_snapshot(uow)))
    assert improvement is not None
    better = solve(improvement.problem, Budget(8), 1)
    search = SearchSettings(Budget(8), 1)
    fleet.campus.do(lambda uow: plans.adopt_improvement(uow, improvement, better, search))
    assert fleet.ride(ride.ride_id).vehicle_id == other
    assert fleet.ride(ride.ride_id).pinned
    fleet.run_until_idle(6000.0)
    assert fleet.ride(ride.ride_id).state is RideState.COMPLETED


def test_reassigning_all_rides_empties_the_shuttle_and_leaves_it_in_service(fleet: FakeFleet) -> None:
    rides = assigned_rides(fleet, 3)
    first = rides[0].vehicle_id or ""
    mine = [ride.ride_id for ride in rides if ride.vehicle_id == first]
    effects = done(fleet.campus, first, Intervention("reassign"))
    assert {e.ride_id for e in effects.rides if e.vehicle_before == first} == set(mine)
    for ride_id in mine:
        assert fleet.ride(ride_id).vehicle_id not in (first, None)
    assert fleet.campus.read(lambda uow: enrolled_vehicle(uow, first)).accepts_rides
    fleet.run_until_idle(6000.0)
    assert {fleet.ride(ride.ride_id).state for ride in rides} == {RideState.COMPLETED}


def test_rides_that_nobody_else_can_take_stay_with_their_shuttle(fleet: FakeFleet) -> None:
    ride = assigned_rides(fleet, 1)[0]
    first = ride.vehicle_id or ""
    for shuttle in fleet.shuttles:
        if shuttle.vehicle_id != first:
            shuttle.hold()
    assert done(fleet.campus, first, Intervention("reassign")).rides == ()
    assert fleet.ride(ride.ride_id).vehicle_id == first
    with pytest.raises(ReassignmentRefused) as refused:
        done(fleet.campus, first, Intervention("reassign", ride_id=ride.ride_id))
    assert refused.value.rule == "no_vehicle_free"


def test_only_a_ride_that_waits_for_the_shuttle_can_be_given_away(fleet: FakeFleet) -> None:
    ride = assigned_rides(fleet, 1)[0]
    first = ride.vehicle_id or ""
    other = next(s.vehicle_id for s in fleet.shuttles if s.vehicle_id != first)
    for vehicle_id, wish, error in (
        (first, Intervention("reassign", ride_id="nobody"), RideUnknown),
        (first, Intervention("reassign", ride_id=ride.ride_id, to_vehicle_id="ghost"), VehicleUnknown),
        (first, Intervention("reassign", ride_id=ride.ride_id, to_vehicle_id=first), ReassignmentRefused),
        (other, Intervention("reassign", ride_id=ride.ride_id), RideNotAssigned),
        ("ghost", Intervention("recall"), VehicleUnknown),
    ):
        with pytest.raises(error):
            done(fleet.campus, vehicle_id, wish)
    fleet.run_until(lambda: fleet.ride(ride.ride_id).state is RideState.ABOARD)
    with pytest.raises(RideAlreadyAboard):
        done(fleet.campus, first, Intervention("reassign", ride_id=ride.ride_id))


def test_holds_end_when_their_time_has_come_each_for_itself(fleet: FakeFleet) -> None:
    one, other, third = fleet.shuttles
    for shuttle in (other, third):
        done(fleet.campus, shuttle.vehicle_id, Intervention("hold", for_s=60.0))
        shuttle.hold()
    third.disconnect()
    fleet.campus.clock.advance(59.0)
    assert fleet.campus.do(interventions.end_holds) == ()
    fleet.campus.clock.advance(1.0)
    assert fleet.campus.do(interventions.end_holds) == (other.vehicle_id,)
    assert fleet.campus.read(lambda uow: enrolled_vehicle(uow, one.vehicle_id)).accepts_rides


def test_a_hold_that_makes_a_departure_a_minute_late_says_so_and_leaves_it_with_its_shuttle(
    fleet: FakeFleet,
) -> None:
    campus = fleet.campus
    campus.clock.advance(-1500.0)
    (departure, *_) = campus.do(departures.plan_departures)
    first = departure.vehicle_id or ""

    def late_s() -> float:
        plan = campus.read(lambda uow: plans.plan_of(uow, first))
        call = next(visit for visit in plan.visits if visit.departure_id)
        assert call.eta is not None
        assert call.not_before is not None
        return (call.eta + timedelta(seconds=call.dwell_s) - call.not_before).total_seconds()

    wish = Intervention("hold", for_s=60.0 - late_s())
    (later,) = (e for e in done(campus, first, wish).departures if e.departure_id == departure.departure_id)
    assert (later.vehicle_before, later.vehicle_after, later.waits) == (first, first, False)
    assert later.late_before_s == 0.0
    assert later.late_after_s == pytest.approx(60.0)


def test_a_ride_goes_to_a_named_shuttle_with_its_promise_kept_if_that_can_be(fleet: FakeFleet) -> None:
    ride = assigned_rides(fleet, 1, 1800.0)[0]
    first = ride.vehicle_id or ""
    other = next(s.vehicle_id for s in fleet.shuttles if s.vehicle_id != first)
    done(fleet.campus, first, Intervention("reassign", ride_id=ride.ride_id, to_vehicle_id=other))
    moved = fleet.ride(ride.ride_id)
    assert (moved.vehicle_id, moved.promise, moved.promise_broken) == (other, ride.promise, False)


def test_of_all_rides_those_that_others_can_take_go_and_the_record_says_how_many_to_whom(
    fleet: FakeFleet,
) -> None:
    large, small = fleet.book("NN20", "C6", 4), fleet.book("NN20", "C6")
    first = large.vehicle_id or ""
    assert small.vehicle_id == first
    for vehicle in fleet.campus.read(lambda uow: uow.vehicles.all()):
        if vehicle.vehicle_id != first:
            fleet.campus.do(lambda uow, v=vehicle: uow.vehicles.save(replace(v, seats=2)))  # type: ignore[misc]
    done(fleet.campus, first, Intervention("reassign"))
    assert fleet.ride(large.ride_id).vehicle_id == first
    taken_by = fleet.ride(small.ride_id).vehicle_id
    assert taken_by not in (first, None)
    done(fleet.campus, taken_by or "", Intervention("reassign", None, small.ride_id, first))
    told = fleet.campus.read(lambda uow: uow.views.server_events())
    said = {event.detail for event in told if event.name == "vehicle.reassigned"}
    assert said == {"2 to any other", f"{small.ride_id} to {first}"}


def test_a_refused_reassignment_names_whom_it_was_meant_for(fleet: FakeFleet) -> None:
    ride = assigned_rides(fleet, 1)[0]
    first = ride.vehicle_id or ""
    other = next(s.vehicle_id for s in fleet.shuttles if s.vehicle_id != first)
    for shuttle in fleet.shuttles:
        if shuttle.vehicle_id != first:
            shuttle.hold()
    for to, whom in (("", "another shuttle"), (other, other)):
        wish = Intervention("reassign", ride_id=ride.ride_id, to_vehicle_id=to)
        with pytest.raises(ReassignmentRefused, match=f"given to {whom}:"):
            done(fleet.campus, first, wish)

"""Batteries: nobody is promised what they do not reach, and idle shuttles go to charge."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import timedelta

import msgspec
import pytest

from contract.roads.load import with_version
from contract.roads.model import RoadMap
from server.domain.planning.plans import next_version
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import RideState
from server.domain.rules import FleetRules
from server.usecases.fleet import charging, departures
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fake_shuttle import FakeShuttle
from tests.server.usecases.fresh_database import fresh_database
from tests.server.usecases.shipped_maps import shipped_map
from tests.server.usecases.small_campus import small_campus

# So short of range that some minutes of driving matter.
RULES = FleetRules(battery_per_drive_s=5e-4, battery_per_charge_s=2e-3, battery_reserve_ratio=0.1)


def a_fleet(road_map: RoadMap, count: int, rules: FleetRules = RULES) -> FakeFleet:
    fleet = FakeFleet(CampusUnderTest(road_map, rules=rules, engine=fresh_database()), road_map, count)
    for shuttle in fleet.shuttles:
        shuttle.speed_mps = 8.0
    return fleet.start()


@pytest.fixture
def fleet() -> Iterator[FakeFleet]:
    made = a_fleet(small_campus(), 1)
    yield made
    made.campus.close()


@pytest.fixture
def pair() -> Iterator[FakeFleet]:
    made = a_fleet(small_campus(), 2)
    yield made
    made.campus.close()


def with_charge(fleet: FakeFleet, shuttle: FakeShuttle, ratio: float) -> None:
    shuttle.battery_ratio = ratio
    shuttle.report()


def kinds(fleet: FakeFleet) -> set[IncidentKind]:
    return {incident.kind for incident in fleet.campus.read(lambda uow: uow.views.incidents())}


def is_charging(fleet: FakeFleet, shuttle: FakeShuttle) -> bool:
    return fleet.campus.read(lambda uow: enrolled_vehicle(uow, shuttle.vehicle_id)).charging


def charge_to(fleet: FakeFleet, shuttle: FakeShuttle, ratio: float) -> None:
    """The shuttle charges all the time until its battery has so much."""
    for _ in range(7200):
        if shuttle.battery_ratio >= ratio:
            return
        assert is_charging(fleet, shuttle)
        fleet.step()
    raise AssertionError(f"{shuttle.battery_ratio} after 7,200 steps")


def steps(fleet: FakeFleet, count: int) -> None:
    for _ in range(count):
        fleet.step()


def test_a_ride_that_the_battery_does_not_reach_is_refused_for_that(fleet: FakeFleet) -> None:
    home_s = fleet.campus.read(lambda uow: uow.roads().to_charger_s())
    (shuttle,) = fleet.shuttles
    with_charge(fleet, shuttle, 0.1 + 5e-4 * (home_s + 10.0))
    refused = fleet.book("stop-0", "stop-2")
    assert (refused.state, refused.reason) == (RideState.REFUSED, "battery")
    with_charge(fleet, shuttle, 0.9)
    assert fleet.book("stop-0", "stop-2").state is RideState.ASSIGNED


def test_a_shuttle_that_does_not_measure_its_battery_drives(fleet: FakeFleet) -> None:
    with_charge(fleet, fleet.shuttles[0], 0.0)
    assert fleet.book("stop-0", "stop-2").state is RideState.ASSIGNED
    assert fleet.campus.do(charging.manage_charging) == ()


@pytest.mark.parametrize("ratio", [0.45, 0.6])
def test_no_plan_takes_a_battery_below_its_reserve(fleet: FakeFleet, ratio: float) -> None:
    (shuttle,) = fleet.shuttles
    # What is planned is what is driven: the plan expects people in the way, and so does the battery here.
    slack = fleet.campus.rules.travel_time_factor * 8.0 / fleet.campus.rules.speed_cap_mps
    shuttle.drain_per_s = RULES.battery_per_drive_s * slack
    with_charge(fleet, shuttle, ratio)
    lowest, taken = 1.0, 0
    for number in range(60):
        taken += fleet.book(f"stop-{number % 4}", f"stop-{(number + 2) % 4}").state is RideState.ASSIGNED
        for _ in range(10):
            fleet.step()
            lowest = min(lowest, shuttle.battery_ratio)
    for _ in range(3600):
        if not (fleet.waiting() or shuttle.next_visit()):
            break
        fleet.step()
        lowest = min(lowest, shuttle.battery_ratio)
    assert not fleet.waiting()
    assert lowest >= RULES.battery_reserve_ratio
    assert IncidentKind.BATTERY_LOW not in kinds(fleet)
    assert taken > 0
    assert any(ride.reason == "battery" for ride in fleet.rides())


def test_an_idle_shuttle_with_little_charge_takes_rides_again_from_the_level_for_that(
    fleet: FakeFleet,
) -> None:
    (shuttle,) = fleet.shuttles
    shuttle.charge_per_s = RULES.battery_per_charge_s
    with_charge(fleet, shuttle, RULES.battery_charge_below_ratio - 0.05)
    steps(fleet, 4)
    assert is_charging(fleet, shuttle)
    assert fleet.book("stop-0", "stop-2").reason == "battery"
    charge_to(fleet, shuttle, RULES.battery_accept_ratio)
    steps(fleet, 1)
    assert fleet.book("stop-0", "stop-2").state is RideState.ASSIGNED
    fleet.run_until_idle(2000.0)
    assert not is_charging(fleet, shuttle)


@pytest.mark.parametrize("first_ratio", [0.0, 0.05, 0.2, 0.9])
def test_each_shuttle_is_judged_by_its_own_battery(pair: FakeFleet, first_ratio: float) -> None:
    first, second = sorted(pair.shuttles, key=lambda shuttle: shuttle.vehicle_id)
    with_charge(pair, first, first_ratio)
    with_charge(pair, second, 0.2)
    pair.campus.do(charging.manage_charging)
    assert is_charging(pair, second)
    assert is_charging(pair, first) is (0.0 < first_ratio < RULES.battery_charge_below_ratio)


def test_a_shuttle_with_a_departure_of_the_timetable_ahead_does_not_go_to_charge_before_it(
    driven_fleet: FakeFleet,
) -> None:
    fleet = driven_fleet
    fleet.campus.clock.advance(-1200.0)
    taken = {departure.vehicle_id for departure in fleet.campus.do(departures.plan_departures)}
    for shuttle in fleet.shuttles:
        with_charge(fleet, shuttle, 0.2)
    changed = fleet.campus.do(charging.manage_charging)
    assert taken
    assert set(changed) == {shuttle.vehicle_id for shuttle in fleet.shuttles} - taken


def test_a_shuttle_with_a_rider_aboard_does_not_charge_though_its_plan_has_no_stop(fleet: FakeFleet) -> None:
    (shuttle,) = fleet.shuttles
    ride = fleet.book("stop-0", "stop-2")
    fleet.run_until(lambda: fleet.ride(ride.ride_id).state is RideState.ABOARD)
    plan = fleet.campus.read(lambda uow: uow.plans.get(shuttle.vehicle_id))
    assert plan is not None
    fleet.campus.do(lambda uow: uow.plans.save(next_version(plan, ()), plan.version))
    with_charge(fleet, shuttle, 0.2)
    fleet.campus.do(charging.manage_charging)
    assert not is_charging(fleet, shuttle)


def test_a_shuttle_charges_to_the_full_unless_somebody_wants_it(fleet: FakeFleet) -> None:
    (shuttle,) = fleet.shuttles
    shuttle.charge_per_s = RULES.battery_per_charge_s
    with_charge(fleet, shuttle, 0.2)
    steps(fleet, 4)
    charge_to(fleet, shuttle, RULES.battery_full_ratio)
    steps(fleet, 4)
    assert not is_charging(fleet, shuttle)


def test_a_shuttle_at_work_finishes_before_it_goes_to_charge(fleet: FakeFleet) -> None:
    (shuttle,) = fleet.shuttles
    fleet.book("stop-0", "stop-2")
    with_charge(fleet, shuttle, 0.2)
    steps(fleet, 4)
    assert not is_charging(fleet, shuttle)
    fleet.run_until_idle(2000.0)
    steps(fleet, 4)
    assert is_charging(fleet, shuttle)


def one_charger() -> RoadMap:
    road_map = small_campus()
    near, far = road_map.resting_places
    places = (near, msgspec.structs.replace(far, charger=True))
    return with_version(msgspec.structs.replace(road_map, resting_places=places, map_version=""))


def test_a_shuttle_that_rests_elsewhere_drives_to_the_charger() -> None:
    road_map = one_charger()
    fleet = a_fleet(road_map, 1)
    (shuttle,) = fleet.shuttles
    charger = road_map.charging_places[0]
    assert shuttle.place.lane_id != charger.lane_id
    with_charge(fleet, shuttle, 0.2)
    steps(fleet, 4)
    plan = fleet.campus.read(lambda uow: uow.plans.get(shuttle.vehicle_id))
    assert plan is not None
    assert [(v.kind, v.why) for v in plan.visits] == [("rest", "charge")]
    steps(fleet, 2)
    fleet.run_until_idle(2000.0)
    assert shuttle.place.lane_id == charger.lane_id
    assert shuttle.place.s_m == pytest.approx(charger.s_m, abs=0.5)
    steps(fleet, 20)
    assert shuttle.next_visit() is None
    fleet.campus.close()


def resting_places(fleet: FakeFleet) -> dict[str, str]:
    """By vehicle."""
    found = fleet.campus.read(lambda uow: uow.plans.all())
    return {plan.vehicle_id: plan.resting_place_id for plan in found}


@pytest.mark.parametrize("low", [0, 1])
def test_of_two_shuttles_only_the_one_that_has_to_charge_is_sent_to_the_charger(low: int) -> None:
    original = shipped_map("snow-lion")
    *places, last = original.resting_places
    places.append(msgspec.structs.replace(last, charger=True))
    road_map = with_version(msgspec.structs.replace(original, resting_places=tuple(places), map_version=""))
    fleet = a_fleet(road_map, 2)
    for number, shuttle in enumerate(fleet.shuttles):
        with_charge(fleet, shuttle, 0.2 if number == low else 0.9)
    before = resting_places(fleet)
    assert last.place_id not in before.values()
    fleet.campus.do(charging.manage_charging)
    assert resting_places(fleet) == before | {fleet.shuttles[low].vehicle_id: last.place_id}
    fleet.campus.close()


def test_two_shuttles_never_head_for_one_charger() -> None:
    road_map = one_charger()
    fleet = a_fleet(road_map, 2)
    for shuttle in fleet.shuttles:
        with_charge(fleet, shuttle, 0.2)
    steps(fleet, 60)
    places = [plan.resting_place_id for plan in fleet.campus.read(lambda uow: uow.plans.all())]
    assert len(set(places)) == 2
    fleet.campus.close()


def test_below_the_reserve_riders_aboard_are_finished_and_the_others_given_away(pair: FakeFleet) -> None:
    aboard = pair.book("stop-0", "stop-2")
    first = aboard.vehicle_id or ""
    shuttle = next(s for s in pair.shuttles if s.vehicle_id == first)
    pair.run_until(lambda: pair.ride(aboard.ride_id).state is RideState.ABOARD)
    other = next(s for s in pair.shuttles if s.vehicle_id != first)
    other.hold()
    waiting = pair.book("stop-2", "stop-0")
    assert waiting.vehicle_id == first
    other.recover()
    with_charge(pair, shuttle, RULES.battery_reserve_ratio - 0.02)
    steps(pair, 4)
    assert pair.ride(waiting.ride_id).vehicle_id == other.vehicle_id
    assert pair.ride(aboard.ride_id).vehicle_id == first
    assert IncidentKind.BATTERY_LOW in kinds(pair)
    pair.run_until_idle(3000.0)
    assert pair.ride(aboard.ride_id).state is RideState.COMPLETED
    assert pair.ride(waiting.ride_id).state is RideState.COMPLETED
    assert first not in {r.vehicle_id for r in pair.rides() if r.ride_id == waiting.ride_id}
    assert is_charging(pair, shuttle)
    with_charge(pair, shuttle, 0.5)
    steps(pair, 4)
    assert IncidentKind.BATTERY_LOW not in kinds(pair)


def details(fleet: FakeFleet, name: str) -> list[str]:
    found = fleet.campus.read(lambda uow: uow.views.server_events())
    return [event.detail for event in found if event.name == name]


def test_what_the_battery_changes_is_told_once_with_its_charge(fleet: FakeFleet) -> None:
    (shuttle,) = fleet.shuttles
    for ratio, name in (
        (0.2, "vehicle.charging"),
        (RULES.battery_full_ratio, "vehicle.charged"),
        (0.15, "vehicle.charging"),
    ):
        with_charge(fleet, shuttle, ratio)
        assert fleet.campus.do(charging.manage_charging) == (shuttle.vehicle_id,)
        assert fleet.campus.do(charging.manage_charging) == ()
        assert f"{100.0 * ratio:.0f} %" in details(fleet, name)
        assert is_charging(fleet, shuttle) is (name == "vehicle.charging")


def test_below_the_reserve_a_shuttle_gives_its_work_away_once_and_again_when_it_has_some(
    fleet: FakeFleet,
) -> None:
    (shuttle,) = fleet.shuttles
    ride = fleet.book("stop-0", "stop-2")
    with_charge(fleet, shuttle, RULES.battery_reserve_ratio - 0.02)
    assert fleet.campus.do(charging.manage_charging) == (shuttle.vehicle_id,)
    assert fleet.campus.do(charging.manage_charging) == ()
    (low,) = fleet.campus.read(lambda uow: uow.views.incidents())
    assert low.kind is IncidentKind.BATTERY_LOW
    assert low.cause.startswith(f"battery at {100.0 * shuttle.battery_ratio:.0f} %")
    fleet.campus.do(lambda uow: uow.rides.save(replace(ride, state=RideState.ASSIGNED)))
    assert fleet.campus.do(charging.manage_charging) == (shuttle.vehicle_id,)


def test_somebody_who_is_wanted_stops_charging_exactly_from_the_level_for_that(fleet: FakeFleet) -> None:
    (shuttle,) = fleet.shuttles
    with_charge(fleet, shuttle, 0.2)
    fleet.campus.do(charging.manage_charging)
    ride = fleet.book("stop-0", "stop-2", earliest=fleet.campus.clock.now() + timedelta(hours=20))
    taken = replace(ride, state=RideState.ASSIGNED, vehicle_id=shuttle.vehicle_id)
    fleet.campus.do(lambda uow: uow.rides.save(taken))
    for ratio, charges in ((RULES.battery_accept_ratio - 0.01, True), (RULES.battery_accept_ratio, False)):
        with_charge(fleet, shuttle, ratio)
        fleet.campus.do(charging.manage_charging)
        assert is_charging(fleet, shuttle) is charges


def test_a_shuttle_that_finds_no_place_to_charge_is_planned_again_later(pair: FakeFleet) -> None:
    low, other = pair.shuttles
    other.hold()
    ride = pair.book("stop-0", "stop-2")
    assert ride.vehicle_id == low.vehicle_id
    pair.leave_homeless(low.vehicle_id)
    with_charge(pair, low, RULES.battery_reserve_ratio - 0.02)
    pair.campus.do(charging.manage_charging)
    assert is_charging(pair, low)
    assert any(low.vehicle_id in detail for detail in details(pair, "plan.waits"))

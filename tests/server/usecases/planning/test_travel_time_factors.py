"""Travel times learnt from drives, and plans and promises that are made with them."""

from collections.abc import Iterator
from datetime import timedelta

import pytest

from server.dispatch.problem_codec import decode_problem
from server.domain.planning.travel_time_factors import FACTOR_MAX, TravelTimeFactors
from server.domain.rides.rides import Ride, RideState
from server.usecases.record import travel_time_factors
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map


def slow_at(*hours: int, factor: float = 2.0) -> TravelTimeFactors:
    factors = tuple(factor if hour in hours else 1.0 for hour in range(24))
    return TravelTimeFactors(factors, (100,) * 24)


def plan_with(fleet: FakeFleet, known: TravelTimeFactors) -> None:
    fleet.campus.do(
        lambda uow: uow.travel_time_factors.save(TravelTimeFactors(known.factors, known.legs, uow.now))
    )


def ride_s(ride: Ride) -> float:
    assert ride.pickup_eta is not None
    assert ride.arrival_eta is not None
    return (ride.arrival_eta - ride.pickup_eta).total_seconds()


@pytest.fixture
def quick_fleet() -> Iterator[FakeFleet]:
    made = CampusUnderTest(shipped_map("snow-lion"))
    fleet = FakeFleet(made, shipped_map("snow-lion"), 1).start()
    fleet.shuttles[0].speed_mps = 9.0
    yield fleet
    made.close()


def test_drives_from_stop_to_stop_are_measured_and_learnt_from(quick_fleet: FakeFleet) -> None:
    fleet = quick_fleet
    ride = fleet.book("NN7", "C6")
    fleet.run_until(lambda: fleet.ride(ride.ride_id).has_ended)
    driven = fleet.campus.read(lambda uow: uow.travel_time_factors.legs())
    assert [(leg.from_stop, leg.to_stop) for leg in driven] == [("NN7", "C6")]
    # The campus is in Shanghai, eight hours before the clock of the test.
    assert driven[0].hour == 8
    assert driven[0].driven_s < driven[0].planned_s
    learnt = fleet.campus.do(travel_time_factors.learn)
    assert learnt.legs[8] == 1
    assert learnt.factors[8] == pytest.approx((driven[0].driven_s / driven[0].planned_s + 20.0) / 21.0)
    assert fleet.campus.read(travel_time_factors.present) == learnt
    fleet.campus.clock.advance(40 * 86400.0)
    assert fleet.campus.do(travel_time_factors.learn).legs == (0,) * 24


def test_a_drive_that_somebody_interrupted_is_not_measured(quick_fleet: FakeFleet) -> None:
    fleet = quick_fleet
    ride = fleet.book("NN7", "C6")
    fleet.run_until(lambda: fleet.ride(ride.ride_id).state is RideState.ABOARD)
    for _ in range(3):
        fleet.step()
    fleet.shuttles[0].hold()
    fleet.shuttles[0].resume()
    fleet.run_until(lambda: fleet.ride(ride.ride_id).has_ended)
    assert fleet.campus.read(lambda uow: uow.travel_time_factors.legs()) == ()


def test_promises_are_made_with_the_times_of_their_hour(fleet: FakeFleet) -> None:
    campus = fleet.campus
    plan_with(fleet, slow_at(*range(10, 24)))
    noon = campus.clock.now() + timedelta(hours=4)
    now, later = fleet.book("NN20", "C6"), fleet.book("NN7", "C6", earliest=noon)
    plain = CampusUnderTest(shipped_map("snow-lion"))
    reference = FakeFleet(plain, shipped_map("snow-lion"), 2).start()
    same, quicker = reference.book("NN20", "C6"), reference.book("NN7", "C6", earliest=noon)
    plain.close()
    assert ride_s(now) == pytest.approx(ride_s(same))
    dwell_s = campus.rules.dwell_s
    assert ride_s(later) - dwell_s == pytest.approx(2.0 * (ride_s(quicker) - dwell_s))
    assert later.promise is not None
    assert quicker.promise is not None
    assert later.promise.arrive_by > quicker.promise.arrive_by


def test_no_ride_is_called_too_long_for_a_slow_hour(fleet: FakeFleet) -> None:
    plan_with(fleet, slow_at(*range(24), factor=FACTOR_MAX))
    far = fleet.book("NN20", "C1")
    assert far.state is RideState.ASSIGNED
    direct_s = fleet.campus.read(lambda uow: uow.roads().direct_s("NN20", "C1"))
    assert ride_s(far) > fleet.campus.rules.ride_s_max(direct_s)


def test_a_decision_is_kept_with_the_paces_it_was_made_with(fleet: FakeFleet) -> None:
    plan_with(fleet, slow_at(*range(24)))
    ride = fleet.book("NN20", "C6")
    told = fleet.campus.read(lambda uow: uow.decisions.of_ride(ride.ride_id))
    decision = fleet.campus.read(lambda uow: uow.decisions.get(told[0].decision_id))
    assert decision is not None
    assert decode_problem(decision.problem).requests[ride.ride_id].travel_time_factor == 2.0

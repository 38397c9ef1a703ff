"""Stored decisions can be made again from their snapshots, bit for bit, and say who was to come before."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import timedelta
from itertools import pairwise

import pytest

from server.domain.planning.decisions import Decision
from server.domain.rides.rides import Ride, RideState
from server.loops.dispatcher import Dispatcher
from server.loops.solver import InlineSolver
from server.usecases.planning.decisions import DecisionUnreadable, repeated
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map

WISHES = (("NN7", "NN20"), ("NN20", "C1"), ("C6", "GYM"), ("GYM", "NN7"))


@pytest.fixture(scope="module")
def decided() -> Iterator[FakeFleet]:
    """Bookings with one shuttle in service, and a refusal; then another shuttle, and improvement."""
    campus = CampusUnderTest(shipped_map("snow-lion"))
    fleet = FakeFleet(campus, shipped_map("snow-lion"), 2)
    for shuttle in fleet.shuttles:
        shuttle.connect()
    fleet.shuttles[0].resume()
    for number, wish in enumerate(WISHES):
        fleet.book(*wish, earliest=campus.clock.now() + timedelta(seconds=100 * number))
    assert fleet.book("NN7", "C6", 2, wheelchairs=1).state is RideState.REFUSED
    fleet.shuttles[1].resume()
    dispatcher = Dispatcher(campus.transactions, campus.bus, InlineSolver(), campus.ids, "snow-lion", 40)
    for _ in range(20):
        fleet.step()
        campus.wait_for(dispatcher.run_once())
    yield fleet
    campus.close()


def decisions(fleet: FakeFleet) -> tuple[Decision, ...]:
    now = fleet.campus.clock.now()
    return fleet.campus.read(lambda uow: uow.decisions.between(now - timedelta(hours=1), now))


def rides(fleet: FakeFleet) -> tuple[Ride, ...]:
    return fleet.campus.read(lambda uow: uow.views.rides(limit=100))


def test_bookings_refusals_and_improvements_come_out_the_same_again(decided: FakeFleet) -> None:
    stored = decisions(decided)
    assert [decision.kind for decision in stored].count("booking") == len(WISHES) + 1
    assert "improvement" in {decision.kind for decision in stored}
    for decision in stored:
        assert repeated(decision) == decision.answer, decision.kind


def test_what_another_version_stored_is_named_unreadable(decided: FakeFleet) -> None:
    decision = decisions(decided)[0]
    for changed in (replace(decision, problem=b"{}"), replace(decision, given=b"[1]")):
        with pytest.raises(DecisionUnreadable):
            repeated(changed)


def test_a_ride_that_changed_its_shuttle_says_who_was_to_come_and_when(decided: FakeFleet) -> None:
    moved = 0
    for ride in rides(decided):
        known = decided.campus.read(lambda uow, r=ride: uow.decisions.of_ride(r.ride_id))  # type: ignore[misc]
        for before, after in pairwise(known):
            assert before.best is not None
            assert after.best is not None
            assert after.runner_up is not None
            moved += 1
            assert after.runner_up.vehicle_id == before.best.vehicle_id != after.best.vehicle_id
            assert after.runner_up.extra_cost_s == 0.0
            assert ride.requested_at <= after.best.pickup_at < after.best.arrival_at
    assert moved

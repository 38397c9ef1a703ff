"""Every ride state against every event: what becomes of the ride, in one table.

The machine of `test_ride_machine` plays the same events in any order; here each pair is named.
"""

from collections.abc import Callable, Iterator

import pytest

from contract.wire.messages import (
    RiderAlighted,
    RiderBoarded,
    RiderDidNotAlight,
    RiderNoShow,
    VehicleEvent,
    VisitChanged,
)
from server.domain.errors import DomainError
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import Ride, RideState
from server.usecases.fleet import interventions
from server.usecases.planning import plans, promises
from server.usecases.rides import destinations, rides
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fresh_database import fresh_database
from tests.server.usecases.small_campus import small_campus

S = RideState
TWO_HOURS_S = 7200.0


class Stage:
    """Two shuttles, and a ride of the first one that has come to a certain state."""

    def __init__(self) -> None:
        road_map = small_campus()
        self.campus = CampusUnderTest(road_map, engine=fresh_database())
        self.fleet = FakeFleet(self.campus, road_map, 2).start()
        self.ride = self.fleet.book("stop-1", "stop-3", 2)
        self.shuttle = next(s for s in self.fleet.shuttles if s.vehicle_id == self.ride.vehicle_id)
        self.other = next(s for s in self.fleet.shuttles if s is not self.shuttle)

    def say(self, *events: VehicleEvent) -> None:
        for event in events:
            self.shuttle.say(event)

    def now(self) -> Ride:
        return self.fleet.ride(self.ride.ride_id)

    def at_the_door(self) -> None:
        plan = self.campus.read(lambda uow: plans.plan_of(uow, self.shuttle.vehicle_id))
        self.say(VisitChanged(plan.visits[0].visit_id, plan.visits[0].stop_id, "under_way"))

    def refused(self) -> None:
        self.ride = self.fleet.book("stop-1", "stop-3", 2, wheelchairs=2)

    def bring_to(self, state: RideState) -> None:
        ride_id = self.ride.ride_id
        boarded, alighted = RiderBoarded(ride_id, "code"), RiderAlighted(ride_id, "code")
        stays = RiderDidNotAlight(ride_id)
        ways: dict[RideState, Callable[[], None]] = {
            S.REQUESTED: lambda: self.campus.do(
                lambda uow: plans.release_waiting(uow, self.shuttle.vehicle_id)
            ),
            S.ASSIGNED: lambda: None,
            S.BOARDING: self.at_the_door,
            S.ABOARD: lambda: self.say(boarded),
            S.COMPLETED: lambda: self.say(boarded, alighted),
            S.REFUSED: self.refused,
            S.CANCELLED: self.cancel,
            S.NO_SHOW: lambda: self.say(RiderNoShow(ride_id)),
            S.FAILED: lambda: self.say(boarded, stays, stays),
        }
        ways[state]()
        assert self.now().state is state

    def order_other_and_take_back(self) -> None:
        """The other shuttle gets an order for the ride, and the ride goes back to the first one."""
        mine, others, by = self.shuttle.vehicle_id, self.other.vehicle_id, "operator"
        self.campus.do(lambda uow: interventions.reassign(uow, mine, by, self.ride.ride_id, others))
        assert self.campus.read(lambda uow: uow.orders.has_named(others, self.ride.ride_id))
        self.campus.do(lambda uow: interventions.reassign(uow, others, by, self.ride.ride_id, mine))
        assert self.now().vehicle_id == mine

    # ------------------------------------------------------------ events

    def cancel(self) -> None:
        self.campus.do(lambda uow: rides.cancel(uow, self.ride.ride_id, "passenger"))

    def redirect(self) -> None:
        self.campus.do(
            lambda uow: destinations.change_destination(
                uow, rides.ride_of(uow, self.ride.ride_id), "stop-2", "passenger"
            )
        )

    def tap(self) -> None:
        self.campus.do(lambda uow: rides.tap(uow, self.ride.ride_id, "board"))

    def boarded(self) -> None:
        self.say(RiderBoarded(self.ride.ride_id, "code"))

    def boarded_elsewhere(self) -> None:
        self.other.say(RiderBoarded(self.ride.ride_id, "sensor"))

    def alighted_elsewhere(self) -> None:
        self.other.say(RiderAlighted(self.ride.ride_id, "sensor"))

    def no_show_elsewhere(self) -> None:
        self.other.say(RiderNoShow(self.ride.ride_id))

    def did_not_alight_elsewhere(self) -> None:
        for _ in range(2):
            self.other.say(RiderDidNotAlight(self.ride.ride_id))

    def alighted(self) -> None:
        self.say(RiderAlighted(self.ride.ride_id, "code"))

    def no_show(self) -> None:
        self.say(RiderNoShow(self.ride.ride_id))

    def did_not_alight(self) -> None:
        self.say(RiderDidNotAlight(self.ride.ride_id))

    def vehicle_is_lost(self) -> None:
        self.shuttle.disconnect()
        self.campus.clock.advance(TWO_HOURS_S)
        self.other.report()
        self.look()

    def vehicle_boots(self) -> None:
        self.shuttle.boot_id, self.shuttle.told, self.shuttle.sequence = "boot-2", [], 0
        self.shuttle.mode = "held"
        self.shuttle.connect()
        self.look()

    def look(self) -> None:
        self.campus.do(plans.assign_waiting)
        self.campus.do(promises.check_promises)


# The state that follows; a text is the code of the refusal, after which the ride is as it was.
EVENTS: dict[str, Callable[[Stage], None]] = {
    "cancel": Stage.cancel,
    "redirect": Stage.redirect,
    "tap": Stage.tap,
    "boarded": Stage.boarded,
    # The other shuttle never had the ride: what it says of it has no effect.
    "boarded_elsewhere": Stage.boarded_elsewhere,
    "alighted_elsewhere": Stage.alighted_elsewhere,
    "no_show_elsewhere": Stage.no_show_elsewhere,
    "did_not_alight_elsewhere": Stage.did_not_alight_elsewhere,
    "alighted": Stage.alighted,
    "no_show": Stage.no_show,
    "did_not_alight": Stage.did_not_alight,
    "vehicle_is_lost": Stage.vehicle_is_lost,
    "vehicle_boots": Stage.vehicle_boots,
    "look": Stage.look,
}
OVER = {"cancel": "ride_ended", "redirect": "ride_ended", "tap": "ride_ended"}
AFTER: dict[RideState, dict[str, RideState | str]] = {
    S.REQUESTED: {
        "cancel": S.CANCELLED,
        "redirect": S.ASSIGNED,
        "tap": "ride_not_assigned",
        "boarded": S.ABOARD,
        "vehicle_is_lost": S.ASSIGNED,
        "vehicle_boots": S.ASSIGNED,
        "look": S.ASSIGNED,
    },
    S.ASSIGNED: {
        "cancel": S.CANCELLED,
        "boarded": S.ABOARD,
        "no_show": S.NO_SHOW,
    },
    S.BOARDING: {
        "cancel": S.CANCELLED,
        "boarded": S.ABOARD,
        "no_show": S.NO_SHOW,
    },
    S.ABOARD: {"tap": "ride_already_aboard", "alighted": S.COMPLETED},
    S.COMPLETED: OVER,
    S.REFUSED: OVER,
    S.CANCELLED: OVER | {"boarded": S.ABOARD},
    S.NO_SHOW: OVER | {"boarded": S.ABOARD},
    S.FAILED: OVER,
}


@pytest.fixture
def stage() -> Iterator[Stage]:
    made = Stage()
    yield made
    made.campus.close()


@pytest.mark.parametrize("event", EVENTS)
@pytest.mark.parametrize("state", list(RideState))
def test_what_an_event_makes_of_a_ride(stage: Stage, state: RideState, event: str) -> None:
    stage.bring_to(state)
    before = stage.now()
    expected = AFTER[state].get(event, state)
    if isinstance(expected, str) and not isinstance(expected, RideState):
        with pytest.raises(DomainError) as refused:
            EVENTS[event](stage)
        assert refused.value.code == expected
        assert stage.now() == before
        return
    EVENTS[event](stage)
    after = stage.now()
    assert after.state is expected
    assert after.has_ended == (after.ended_at is not None)
    require_kept(stage, after)


@pytest.mark.parametrize("state", [S.REQUESTED, S.ASSIGNED, S.BOARDING, S.CANCELLED, S.NO_SHOW])
def test_a_party_that_boards_the_shuttle_which_had_the_ride_before_is_aboard_it(
    stage: Stage, state: RideState
) -> None:
    stage.order_other_and_take_back()
    stage.bring_to(state)
    stage.boarded_elsewhere()
    ride = stage.now()
    assert (ride.state, ride.vehicle_id) == (S.ABOARD, stage.other.vehicle_id)
    require_kept(stage, ride)


def test_a_report_on_a_ride_that_the_shuttle_never_had_is_an_incident_of_that_shuttle(stage: Stage) -> None:
    stage.boarded_elsewhere()
    stage.boarded_elsewhere()
    (incident,) = stage.campus.read(lambda uow: uow.views.incidents())
    assert (incident.kind, incident.vehicle_id) == (IncidentKind.FALSE_REPORT, stage.other.vehicle_id)
    assert stage.now() == stage.ride


def test_a_party_aboard_one_shuttle_cannot_be_let_out_by_another_that_had_the_ride_before(
    stage: Stage,
) -> None:
    stage.order_other_and_take_back()
    stage.bring_to(S.ABOARD)
    stage.alighted_elsewhere()
    stage.did_not_alight_elsewhere()
    assert (stage.now().state, stage.now().vehicle_id) == (S.ABOARD, stage.shuttle.vehicle_id)


def require_kept(stage: Stage, ride: Ride) -> None:
    """Final, waiting for a vehicle, or in the plan of the vehicle that has it, and of no other."""
    known = stage.campus.read(lambda uow: uow.plans.all())
    having = [plan.vehicle_id for plan in known if ride.ride_id in plan.ride_ids]
    if ride.has_ended or ride.state is RideState.REQUESTED:
        assert [v for v in having if v != stage.shuttle.vehicle_id] == []
    else:
        assert having == [ride.vehicle_id]


def test_the_table_names_every_state() -> None:
    assert set(AFTER) == set(RideState)
    assert all(set(row) <= set(EVENTS) for row in AFTER.values())

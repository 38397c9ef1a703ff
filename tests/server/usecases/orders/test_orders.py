"""Plans as orders: what goes over the wire, when a resting shuttle leaves, and what needs no revision."""

from dataclasses import replace
from datetime import timedelta

import msgspec
import pytest

from contract.wire.messages import OrderRejected, SectionGrant, VisitChanged
from server.domain.instants import ns_of
from server.domain.orders.orders import IssuedOrder, OrderState
from server.domain.planning.plans import Plan, PlannedVisit, next_version
from server.domain.record.events import RecordedEvent
from server.usecases.fleet import events
from server.usecases.orders import orders, sections
from server.usecases.planning import plans
from server.usecases.ports.unit_of_work import UnitOfWork
from tests.server.usecases.fake_fleet import FakeFleet


def current(fleet: FakeFleet, vehicle_id: str) -> IssuedOrder:
    order = fleet.campus.read(lambda uow: uow.orders.current(vehicle_id))
    assert order is not None
    return order


def plan_of(fleet: FakeFleet, vehicle_id: str) -> Plan:
    return fleet.campus.read(lambda uow: plans.plan_of(uow, vehicle_id))


def taken(fleet: FakeFleet) -> str:
    """A ride is booked; the shuttle that has it."""
    ride = fleet.book("NN20", "C6", 2)
    assert ride.vehicle_id is not None
    return ride.vehicle_id


def test_an_order_says_where_when_for_whom_and_over_which_sections(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    vehicle_id = taken(fleet)
    order, plan = current(fleet, vehicle_id), plan_of(fleet, vehicle_id)
    sent = order.payload
    ride = fleet.rides()[0]
    board, alight, rest = sent.visits
    stop = fleet.network.stops["NN20"]
    assert (board.kind, board.stop_id, board.name, board.name_en) == ("stop", "NN20", stop.name, stop.name_en)
    assert [(t.ride_id, t.party) for t in board.board] == [(ride.ride_id, 2)]
    assert (board.alight, alight.board) == ((), ())
    assert [t.ride_id for t in alight.alight] == [ride.ride_id]
    assert (rest.kind, rest.stop_id, rest.name, rest.dwell_s, rest.not_before_ns) == ("rest", "", "", 0.0, 0)
    for visit, planned in zip(sent.visits, plan.ordered, strict=True):
        assert (visit.visit_id, visit.lane_id, visit.s_m) == (planned.visit_id, planned.lane_id, planned.s_m)
        assert visit.dwell_s == planned.dwell_s
        assert visit.route[-1] == planned.lane_id
        assert not visit.timed
    assert plan.visits[0].not_before is not None
    assert board.not_before_ns == ns_of(plan.visits[0].not_before)
    assert (sent.revision, order.state, order.plan_version) == (1, OrderState.ISSUED, plan.version)
    assert sent.map_version == fleet.network.map_version
    until = fleet.campus.clock.now() + timedelta(seconds=fleet.campus.rules.order_valid_s)
    assert sent.expires_ns == ns_of(until)
    held = next(
        o.held for o in fleet.campus.read(lambda uow: uow.sections.all()) if o.vehicle_id == vehicle_id
    )
    grants = tuple(SectionGrant(s.section_id, s.fence) for s in held)
    assert sent.sections, "where it stands; more of the road follows in grants"
    assert sent.sections == grants[: len(sent.sections)]


def test_a_resting_shuttle_leaves_as_late_as_it_can_for_a_ride_of_later(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    begins = fleet.campus.clock.now() + timedelta(hours=1)
    ride = fleet.book("NN20", "C6", earliest=begins)
    assert ride.vehicle_id is not None
    first = plan_of(fleet, ride.vehicle_id).visits[0]
    assert first.not_before is not None
    assert fleet.campus.read(lambda uow: uow.orders.current(ride.vehicle_id or "")) is None
    shuttle = next(s for s in fleet.shuttles if s.vehicle_id == ride.vehicle_id)
    fleet.run_until(lambda: shuttle.order is not None)
    left_at = fleet.campus.clock.now()
    fleet.run_until(lambda: "under_way" in shuttle.states.values())
    waited_s = (first.not_before - fleet.campus.clock.now()).total_seconds() - first.dwell_s
    assert begins - left_at < timedelta(minutes=20)
    early_s = fleet.campus.read(lambda uow: uow.rules.early_s(timed=False))
    # This shuttle drives a little faster than planned.
    assert early_s + 10.0 <= waited_s <= early_s + 60.0


def test_a_party_that_gets_off_does_not_wait_for_one_that_boards_later(driven_fleet: FakeFleet) -> None:
    """As after a clock was set back: the shuttle rests with a party aboard."""
    fleet = driven_fleet
    ride = fleet.book("NN20", "C6", earliest=fleet.campus.clock.now() + timedelta(hours=1))
    vehicle_id = ride.vehicle_id or ""
    assert fleet.campus.read(lambda uow: uow.orders.current(vehicle_id)) is None
    plan = plan_of(fleet, vehicle_id)
    first = replace(plan.visits[0], alight=("ride-aboard",))
    changed = next_version(plan, (first, *plan.visits[1:]))
    fleet.campus.do(lambda uow: uow.plans.save(changed, plan.version))
    assert fleet.campus.do(lambda uow: orders.reissue(uow, vehicle_id)) is not None


def test_a_plan_that_changes_only_behind_the_order_needs_no_revision(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    vehicle_id = taken(fleet)
    fleet.step()
    before, plan = current(fleet, vehicle_id), plan_of(fleet, vehicle_id)
    newer = replace(plan, version=plan.version + 1)
    fleet.campus.do(lambda uow: uow.plans.save(newer, plan.version))
    assert fleet.campus.do(lambda uow: orders.reissue(uow, vehicle_id)) is None
    after = current(fleet, vehicle_id)
    assert (after.revision, after.plan_version) == (before.revision, newer.version)
    assert fleet.campus.do(lambda uow: orders.reissue(uow, vehicle_id)) is None


def test_parties_of_one_visit_named_in_another_order_need_no_revision(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    vehicle_id = taken(fleet)
    assert fleet.book("NN20", "C6").vehicle_id == vehicle_id
    plan, order = plan_of(fleet, vehicle_id), current(fleet, vehicle_id)
    first = plan.visits[0]
    assert len(first.board) == 2
    turned = replace(first, board=first.board[::-1])
    fleet.campus.do(lambda uow: uow.plans.save(next_version(plan, (turned, *plan.visits[1:])), plan.version))
    assert fleet.campus.do(lambda uow: orders.reissue(uow, vehicle_id)) is None
    after = current(fleet, vehicle_id)
    assert (after.revision, after.plan_version) == (order.revision, plan.version + 1)


def test_a_visit_that_takes_longer_or_boards_another_rider_is_told_with_a_revision(
    driven_fleet: FakeFleet,
) -> None:
    fleet = driven_fleet
    vehicle_id = taken(fleet)
    fleet.step()
    for change in ({"dwell_s": 60.0}, {"board": ()}, {"not_before": None}):
        before, plan = current(fleet, vehicle_id), plan_of(fleet, vehicle_id)
        visits = (replace(plan.visits[0], **change), *plan.visits[1:])  # type: ignore[arg-type]
        newer = replace(plan, version=plan.version + 1, visits=visits)
        fleet.campus.do(lambda uow, n=newer, p=plan: uow.plans.save(n, p.version))  # type: ignore[misc]
        issued = fleet.campus.do(lambda uow: orders.reissue(uow, vehicle_id))
        assert issued is not None, change
        assert (issued.order_id, issued.revision) == (before.order_id, before.revision + 1)


@pytest.mark.parametrize(("ahead_m", "goes_round"), [(3.0, True), (20.0, False)])
def test_a_new_stop_too_near_to_brake_for_is_come_to_by_going_round(
    driven_fleet: FakeFleet, ahead_m: float, goes_round: bool
) -> None:
    fleet = driven_fleet
    vehicle_id = taken(fleet)
    shuttle = next(s for s in fleet.shuttles if s.vehicle_id == vehicle_id)

    def has_road_ahead() -> bool:
        held = next(
            o.held_ids
            for o in fleet.campus.read(lambda uow: uow.sections.all())
            if o.vehicle_id == vehicle_id
        )
        sections = [fleet.network.sections[name] for name in held]
        granted_m = max(s.s_to_m for s in sections if s.lane_id == shuttle.place.lane_id)
        return shuttle.driven_m > 0.0 and granted_m - shuttle.place.s_m > 25.0

    fleet.run_until(has_road_ahead)
    here, plan = shuttle.place, plan_of(fleet, vehicle_id)
    needed_m = fleet.campus.rules.stopping_m(shuttle.speed_mps)
    assert 3.0 < needed_m < 20.0
    near = PlannedVisit("new", "stop", "", here.lane_id, here.s_m + ahead_m)
    newer = next_version(plan, (near, *plan.visits))
    fleet.campus.do(lambda uow: uow.plans.save(newer, plan.version))
    issued = fleet.campus.do(lambda uow: orders.reissue(uow, vehicle_id))
    assert issued is not None
    first = issued.payload.visits[0]
    assert first.visit_id == "new"
    assert (len(first.route) > 1) is goes_round


def test_an_order_taken_back_is_followed_by_one_with_a_new_id(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    vehicle_id = taken(fleet)
    before = current(fleet, vehicle_id)
    fleet.campus.do(lambda uow: orders.withdraw(uow, vehicle_id))
    withdrawn = current(fleet, vehicle_id)
    assert (withdrawn.state, withdrawn.reason) == (OrderState.DONE, "withdrawn")
    issued = fleet.campus.do(lambda uow: orders.reissue(uow, vehicle_id))
    assert issued is not None
    assert issued.order_id != before.order_id
    assert issued.revision == 1


def test_an_answer_to_an_earlier_revision_changes_nothing(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    vehicle_id = taken(fleet)
    fleet.campus.do(lambda uow: orders.repeat(uow, vehicle_id))
    second = current(fleet, vehicle_id)
    assert second.revision == 2
    late = OrderRejected(1, second.order_id, 1, "malformed", "", ())
    assert fleet.campus.do(lambda uow: orders.rejected(uow, vehicle_id, late)) is None
    assert current(fleet, vehicle_id) == second


def reject(fleet: FakeFleet, vehicle_id: str, code: str) -> IssuedOrder | None:
    """The answer to a rejection of the present order: its next revision, if there is one."""
    order = current(fleet, vehicle_id)
    answer = OrderRejected(1, order.order_id, order.revision, code, "", ())  # type: ignore[arg-type]
    return fleet.campus.do(lambda uow: orders.rejected(uow, vehicle_id, answer))


def test_rejections_for_different_reasons_are_tried_again_and_three_in_a_row_for_one_are_not(
    driven_fleet: FakeFleet,
) -> None:
    fleet = driven_fleet
    vehicle_id = taken(fleet)
    for code in ("unreachable", "malformed", "unreachable", "unreachable"):
        assert reject(fleet, vehicle_id, code) is not None
    assert reject(fleet, vehicle_id, "unreachable") is None
    incidents = fleet.campus.read(lambda uow: uow.incidents.all_open())
    assert [(i.kind.value, i.vehicle_id) for i in incidents] == [("order_rejected", vehicle_id)]
    order = current(fleet, vehicle_id)
    assert order.revision == 5
    fleet.campus.do(lambda uow: orders.accepted(uow, vehicle_id, order.order_id, order.revision))
    assert fleet.campus.read(lambda uow: uow.incidents.all_open()) == ()


def test_a_rejected_order_is_issued_again_when_the_vehicle_leaves_its_visit(driven_fleet: FakeFleet) -> None:
    """It stood at a visit that the plan did not have any more, and rejected every order without it."""
    fleet = driven_fleet
    vehicle_id = taken(fleet)
    while reject(fleet, vehicle_id, "visit_under_way") is not None:
        assert current(fleet, vehicle_id).revision < 9
    rejected = current(fleet, vehicle_id)
    assert rejected.state is OrderState.REJECTED
    left = RecordedEvent(vehicle_id, "boot-9", 0, 1, 1, VisitChanged("visit-gone", "NN20", "done"))
    fleet.campus.do(lambda uow: events.apply_event(uow, left))
    again = current(fleet, vehicle_id)
    assert (again.state, again.revision) == (OrderState.ISSUED, rejected.revision + 1)


def test_an_order_that_names_a_stop_of_riders_who_are_gone_is_replaced(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    vehicle_id = taken(fleet)
    fleet.run_until(lambda: current(fleet, vehicle_id).state is OrderState.ACCEPTED)
    before = current(fleet, vehicle_id)

    def riders_are_gone(uow: UnitOfWork) -> IssuedOrder | None:
        plan = plans.plan_of(uow, vehicle_id)
        rest_only = next_version(plan, plan.ordered[-1:], plan.resting_place_id)
        uow.plans.save(rest_only, plan.version)
        orders.visits_removed(uow, plan, rest_only)
        return orders.reissue(uow, vehicle_id)

    replaced = fleet.campus.do(riders_are_gone)
    assert replaced is not None
    assert [visit.kind for visit in replaced.payload.visits] == ["rest"]
    assert (replaced.order_id, replaced.revision) == (before.order_id, before.revision + 1)


@pytest.mark.parametrize("waits", ["next", "off its route", "a loop farther"])
def test_a_shuttle_that_waits_for_another_section_than_its_next_gets_its_order_again(
    driven_fleet: FakeFleet, waits: str
) -> None:
    fleet = driven_fleet
    vehicle_id = taken(fleet)
    shuttle = next(s for s in fleet.shuttles if s.vehicle_id == vehicle_id)
    fleet.run_until(lambda: current(fleet, vehicle_id).state is OrderState.ACCEPTED)
    before = current(fleet, vehicle_id)

    def wait_and_grant(uow: UnitOfWork) -> None:
        occupancy = next(o for o in uow.sections.all() if o.vehicle_id == vehicle_id)
        mine = (*occupancy.held_ids, *occupancy.ahead)
        other = next(section_id for section_id in fleet.network.sections if section_id not in mine)
        waiting_for = {
            "next": occupancy.ahead[0],
            "off its route": other,
            "a loop farther": occupancy.ahead[1],
        }[waits]
        uow.vehicles.save_position(
            vehicle_id,
            msgspec.structs.replace(
                shuttle.status(),
                waiting_for=waiting_for,
                speed_mps=0.0,
                order_id=before.order_id,
                revision=before.revision,
            ),
        )
        sections.extend_grants(uow)

    fleet.campus.do(wait_and_grant)
    assert current(fleet, vehicle_id).revision == before.revision + (0 if waits == "next" else 1)

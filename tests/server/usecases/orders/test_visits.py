"""What a shuttle reports of its visits becomes the plan, the ride and the position that are stored."""

from dataclasses import replace

import msgspec
import pytest

from contract.geometry import Pose2
from contract.wire.messages import Status, VisitState
from server.domain.orders.orders import OrderState
from server.domain.planning.plans import PlannedVisit
from server.domain.rides.rides import RideState
from server.domain.service.timetable import DepartureState
from server.usecases.fleet import departures
from server.usecases.orders import visits
from server.usecases.planning import plans
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fake_shuttle import FakeShuttle


def to_pickup(fleet: FakeFleet) -> tuple[FakeShuttle, PlannedVisit, str]:
    """A shuttle, the visit at which its ride boards, and the ride."""
    ride = fleet.book("NN20", "C6")
    shuttle = next(s for s in fleet.shuttles if s.vehicle_id == ride.vehicle_id)
    visit = next(
        v for v in fleet.campus.read(lambda u: plans.plan_of(u, shuttle.vehicle_id)).visits if v.board
    )
    return shuttle, visit, ride.ride_id


def stored_status(fleet: FakeFleet, vehicle_id: str) -> Status:
    where = fleet.campus.read(lambda uow: uow.vehicles.whereabouts(vehicle_id))
    assert where is not None
    assert where.status is not None
    return where.status


def stored_pose(fleet: FakeFleet, vehicle_id: str) -> Pose2:
    return stored_status(fleet, vehicle_id).pose_map


def test_an_arrival_lets_its_riders_board_and_those_of_no_other_shuttle(driven_fleet: FakeFleet) -> None:
    shuttle, visit, ride_id = to_pickup(driven_fleet)
    ride = driven_fleet.ride(ride_id)
    other = next(s for s in driven_fleet.shuttles if s is not shuttle)
    driven_fleet.campus.do(lambda uow: uow.rides.save(replace(ride, vehicle_id=other.vehicle_id)))
    driven_fleet.campus.do(lambda u: visits.change(u, shuttle.vehicle_id, visit.visit_id, "under_way"))
    assert driven_fleet.ride(ride_id).state is RideState.ASSIGNED


def test_an_arrival_is_taken_over_once_and_never_backwards(driven_fleet: FakeFleet) -> None:
    shuttle, visit, ride_id = to_pickup(driven_fleet)
    change = lambda state: driven_fleet.campus.do(  # noqa: E731
        lambda u: visits.change(u, shuttle.vehicle_id, visit.visit_id, state)
    )
    assert change("under_way") == visit
    assert driven_fleet.ride(ride_id).state is RideState.BOARDING
    assert change("under_way") is None
    assert change("pending") is None
    plan = driven_fleet.campus.read(lambda uow: plans.plan_of(uow, shuttle.vehicle_id))
    assert plan.visit(visit.visit_id) == replace(visit, state="under_way")
    assert driven_fleet.campus.do(lambda u: visits.change(u, "ghost", visit.visit_id, "done")) is None


def test_a_shuttle_near_its_stop_is_shown_at_it_and_one_far_away_where_it_is(driven_fleet: FakeFleet) -> None:
    shuttle, visit, _ = to_pickup(driven_fleet)
    x_m, y_m, yaw_rad = driven_fleet.network.pose(visit.lane_id, visit.s_m)
    for away_m, is_moved in ((visits.NEAR_M + 0.1, False), (visits.NEAR_M, True)):
        shuttle.astray = Pose2(x_m + away_m, y_m, 0.0)
        shuttle.report()
        before = stored_pose(driven_fleet, shuttle.vehicle_id)
        driven_fleet.campus.do(
            lambda u, m=is_moved: visits.change(  # type: ignore[misc]
                u, shuttle.vehicle_id, visit.visit_id, "done" if m else "under_way"
            )
        )
        after = stored_pose(driven_fleet, shuttle.vehicle_id)
        assert after == (Pose2(x_m, y_m, yaw_rad) if is_moved else before)


def test_a_shuttle_that_reports_a_visit_is_shown_as_standing(driven_fleet: FakeFleet) -> None:
    shuttle, visit, _ = to_pickup(driven_fleet)
    x_m, y_m, yaw_rad = driven_fleet.network.pose(visit.lane_id, visit.s_m)
    status = stored_status(driven_fleet, shuttle.vehicle_id)
    rolling = msgspec.structs.replace(status, pose_map=Pose2(x_m, y_m, yaw_rad), speed_mps=0.4)
    driven_fleet.campus.do(lambda uow: uow.vehicles.save_position(shuttle.vehicle_id, rolling))
    driven_fleet.campus.do(lambda u: visits.change(u, shuttle.vehicle_id, visit.visit_id, "under_way"))
    assert stored_status(driven_fleet, shuttle.vehicle_id).speed_mps == 0.0


def test_a_skipped_visit_moves_nobody(driven_fleet: FakeFleet) -> None:
    shuttle, visit, _ = to_pickup(driven_fleet)
    x_m, y_m, _ = driven_fleet.network.pose(visit.lane_id, visit.s_m)
    shuttle.astray = Pose2(x_m + 3.0, y_m, 0.0)
    shuttle.report()
    driven_fleet.campus.do(lambda u: visits.change(u, shuttle.vehicle_id, visit.visit_id, "skipped"))
    assert stored_pose(driven_fleet, shuttle.vehicle_id) == shuttle.astray


@pytest.mark.parametrize(("last", "is_done"), [("done", True), ("skipped", False)])
def test_a_departure_is_done_when_its_last_call_was_made(
    driven_fleet: FakeFleet, last: VisitState, is_done: bool
) -> None:
    campus = driven_fleet.campus
    campus.clock.advance(-1200.0)
    (departure, *_) = campus.do(departures.plan_departures)
    vehicle_id = departure.vehicle_id or ""
    plan = campus.read(lambda uow: plans.plan_of(uow, vehicle_id))
    calls = [visit for visit in plan.visits if visit.departure_id == departure.departure_id]
    assert len(calls) == len(departure.calls) > 1
    for visit in calls:
        made = campus.read(lambda uow: uow.departures.get(departure.departure_id))
        assert made is not None
        assert made.state is DepartureState.ASSIGNED
        state = last if visit is calls[-1] else "done"
        campus.do(lambda u, v=visit, s=state: visits.change(u, vehicle_id, v.visit_id, s))  # type: ignore[misc]
    made = campus.read(lambda uow: uow.departures.get(departure.departure_id))
    assert made is not None
    assert (made.state is DepartureState.DONE) is is_done


def test_an_order_of_which_every_visit_was_made_is_done(driven_fleet: FakeFleet) -> None:
    shuttle, _, _ = to_pickup(driven_fleet)
    driven_fleet.step()
    order = driven_fleet.campus.read(lambda uow: uow.orders.current(shuttle.vehicle_id))
    assert order is not None
    for visit in order.payload.visits:
        assert current_state(driven_fleet, shuttle) is not OrderState.DONE
        driven_fleet.campus.do(
            lambda u, v=visit: visits.change(u, shuttle.vehicle_id, v.visit_id, "done")  # type: ignore[misc]
        )
    assert current_state(driven_fleet, shuttle) is OrderState.DONE


def test_a_report_on_an_order_that_is_not_accepted_yet_needs_no_revision_while_it_names_open_visits_only(
    driven_fleet: FakeFleet,
) -> None:
    shuttle, first, _ = to_pickup(driven_fleet)
    report = lambda state: driven_fleet.campus.do(  # noqa: E731
        lambda u: visits.change(u, shuttle.vehicle_id, first.visit_id, state)
    )

    def is_up_to_date() -> bool:
        order = driven_fleet.campus.read(lambda uow: uow.orders.current(shuttle.vehicle_id))
        plan = driven_fleet.campus.read(lambda uow: plans.plan_of(uow, shuttle.vehicle_id))
        assert order is not None
        assert order.state is OrderState.ISSUED
        return order.plan_version == plan.version

    assert is_up_to_date()
    report("under_way")
    assert is_up_to_date()
    report("done")
    assert not is_up_to_date(), "it names a visit that is over"


def test_an_order_that_is_behind_its_plan_stays_behind_after_a_report(driven_fleet: FakeFleet) -> None:
    """A report that marked it as up to date would hide that it still needs its revision."""
    shuttle, first, _ = to_pickup(driven_fleet)
    driven_fleet.step()
    order = driven_fleet.campus.read(lambda uow: uow.orders.current(shuttle.vehicle_id))
    assert order is not None
    assert order.state is OrderState.ACCEPTED
    behind = replace(order, plan_version=order.plan_version - 1)
    driven_fleet.campus.do(lambda uow: uow.orders.save(behind))
    driven_fleet.campus.do(lambda u: visits.change(u, shuttle.vehicle_id, first.visit_id, "under_way"))
    assert driven_fleet.campus.read(lambda uow: uow.orders.current(shuttle.vehicle_id)) == behind


def current_state(fleet: FakeFleet, shuttle: FakeShuttle) -> OrderState:
    order = fleet.campus.read(lambda uow: uow.orders.current(shuttle.vehicle_id))
    assert order is not None
    return order.state

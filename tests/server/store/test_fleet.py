"""Vehicles, plans, orders and sections: what is stored is found again, the newest of it as the present."""

from dataclasses import replace
from datetime import timedelta

import msgspec
import pytest

from contract.geometry import Pose2
from contract.wire.messages import Order, RiderTask, Status, Visit
from server.domain.errors import PlanChanged
from server.domain.fleet.shifts import Shifts
from server.domain.fleet.vehicles import StatusReport, Vehicle, VehicleCommand, Whereabouts
from server.domain.orders.orders import IssuedOrder, OrderState
from server.domain.orders.sections import HeldSection, Occupancy
from server.domain.planning.plans import Plan, PlannedVisit
from server.domain.planning.travel_time_factors import DrivenLeg, TravelTimeFactors
from server.usecases.record.retention import forget_old
from tests.server.store.conftest import Record
from tests.server.usecases.campus_under_test import MORNING as NOW

SECOND, HOUR, DAY = timedelta(seconds=1), timedelta(hours=1), timedelta(days=1)
SHUTTLE = Vehicle("snow-lion", "shuttle-1", "Shuttle 1", 6, 1, NOW)
FULL = replace(
    SHUTTLE,
    epoch=3,
    boot_id="boot-2",
    connected=True,
    software="0.1",
    stack="gem",
    map_version="m",
    mode="autonomous",
    held=False,
    in_service=False,
    placed=True,
    unavailable_since=NOW,
    hold_ends=NOW + HOUR,
    charging=True,
    shifts=Shifts(()),
    quarantined_at=NOW,
)
STATUS = Status(
    3, 77, Pose2(1.0, 2.0, 0.5), 1.5, 0.1, 0.2, "autonomous", 0.8, False, "lane-1", 12.5, "order-1", 2, "v1"
)
ORDER = Order(1, "order-1", 1, "map", (Visit("v1", "rest", "", "lane-1", 3.0, ()),), (), 0)
ISSUED = IssuedOrder("snow-lion", "shuttle-1", "order-1", 1, 1, OrderState.ISSUED, ORDER, NOW)


def add_vehicles(record: Record, *vehicles: Vehicle) -> None:
    record.do(lambda uow: [uow.vehicles.add(vehicle) for vehicle in vehicles])


def a_report(received_s: float, x_m: float = 1.0, vehicle_id: str = "shuttle-1") -> StatusReport:
    status = msgspec.structs.replace(STATUS, pose_map=Pose2(x_m, 2.0, 0.5), stamp_ns=int(received_s * 1e9))
    return StatusReport(vehicle_id, "boot-2", NOW + received_s * SECOND, status)


def test_vehicles_are_found_as_they_were_stored_and_retired_ones_are_not_listed(record: Record) -> None:
    other = replace(SHUTTLE, vehicle_id="shuttle-0")
    add_vehicles(record, SHUTTLE, other)
    record.do(lambda uow: uow.vehicles.save(FULL))
    assert record.found(lambda uow: uow.vehicles.get("shuttle-1")) == FULL
    assert record.found(lambda uow: uow.vehicles.all()) == (other, FULL)
    assert record.found(lambda uow: uow.vehicles.get("ghost")) is None
    record.do(lambda uow: uow.vehicles.save(replace(other, retired=True)))
    assert record.found(lambda uow: uow.vehicles.all()) == (FULL,)
    kept = record.found(lambda uow: uow.vehicles.get("shuttle-0"))
    assert kept is not None
    assert kept.retired


def test_the_newest_status_is_where_a_vehicle_is_and_all_of_them_are_its_history(record: Record) -> None:
    add_vehicles(record, SHUTTLE)
    record.do(lambda uow: uow.vehicles.save_status([a_report(1.0, 10.0), a_report(2.0, 20.0)]))
    where = record.found(lambda uow: uow.vehicles.whereabouts("shuttle-1"))
    assert where == Whereabouts("shuttle-1", NOW + 2 * SECOND, a_report(2.0, 20.0).status)
    assert record.found(lambda uow: uow.vehicles.all_whereabouts()) == (where,)
    points = record.found(lambda uow: uow.views.history("shuttle-1", NOW, NOW + HOUR))
    assert [(point.x_m, point.received_at) for point in points] == [
        (10.0, NOW + SECOND),
        (20.0, NOW + 2 * SECOND),
    ]
    assert record.found(lambda uow: uow.vehicles.whereabouts("ghost")) is None


def test_any_frame_counts_as_heard_and_a_corrected_position_leaves_the_history(record: Record) -> None:
    add_vehicles(record, SHUTTLE)
    record.do(lambda uow: uow.vehicles.save_status([a_report(1.0, 10.0)]))
    record.do(lambda uow: uow.vehicles.heard("shuttle-1", NOW + HOUR))
    corrected = msgspec.structs.replace(STATUS, lane_id="lane-9")
    record.do(lambda uow: uow.vehicles.save_position("shuttle-1", corrected))
    where = record.found(lambda uow: uow.vehicles.whereabouts("shuttle-1"))
    assert where == Whereabouts("shuttle-1", NOW + HOUR, corrected)
    (point,) = record.found(lambda uow: uow.views.history("shuttle-1", NOW, NOW + HOUR))
    assert point.x_m == 10.0


def test_positions_older_than_the_rules_say_are_forgotten(record: Record) -> None:
    add_vehicles(record, SHUTTLE)
    days = record.campus.rules.history_days
    record.do(lambda uow: uow.vehicles.save_status([a_report(0.0), a_report(1.0), a_report(2.0)]))
    record.campus.clock.advance(days * 86400.0 + 1.0)
    assert record.do(forget_old) == 1
    points = record.found(lambda uow: uow.views.history("shuttle-1", NOW, NOW + HOUR))
    assert [point.received_at for point in points] == [NOW + SECOND, NOW + 2 * SECOND]


def test_commands_wait_in_the_order_in_which_they_were_given_until_they_have_ended(record: Record) -> None:
    add_vehicles(record, SHUTTLE)
    commands = [
        VehicleCommand("snow-lion", f"c{n}", "shuttle-1", "hold", "why", "ann", NOW + n * SECOND)
        for n in range(3)
    ]
    record.do(lambda uow: [uow.vehicles.add_command(command) for command in commands])
    refused = replace(commands[1], state="failed", detail="no position")
    record.do(lambda uow: uow.vehicles.save_command(refused))
    assert record.found(lambda uow: uow.vehicles.pending_commands("shuttle-1")) == (commands[0], commands[2])
    assert record.found(lambda uow: uow.vehicles.command("c1")) == refused
    assert record.found(lambda uow: uow.vehicles.pending_commands("shuttle-2")) == ()
    view = record.found(lambda uow: uow.views.vehicle("shuttle-1"))
    assert view is not None
    assert view.last_command == commands[2]


def test_a_plan_is_saved_over_the_version_that_was_read_and_no_other(record: Record) -> None:
    visit = PlannedVisit("v1", "stop", "C6", "l", 1.0, ("r1",), ("r2",), not_before=NOW, latest=NOW, eta=NOW)
    plan = Plan("snow-lion", "shuttle-1", 1, (visit, replace(visit, visit_id="v2", why="charge")), "rest-1")
    record.do(lambda uow: uow.plans.save(plan, 0))
    assert record.found(lambda uow: uow.plans.get("shuttle-1")) == plan
    assert record.found(lambda uow: uow.plans.all()) == (plan,)
    newer = replace(plan, version=2, visits=(visit,))
    for wrong in (0, 2):
        with pytest.raises(PlanChanged):
            record.do(lambda uow, v=wrong: uow.plans.save(newer, v))  # type: ignore[misc]
    assert record.found(lambda uow: uow.plans.get("shuttle-1")) == plan
    record.do(lambda uow: uow.plans.save(newer, 1))
    assert record.found(lambda uow: uow.plans.get("shuttle-1")) == newer


def test_the_newest_revision_of_the_newest_order_is_the_current_one(record: Record) -> None:
    second = replace(ISSUED, revision=2, plan_version=2)
    third = replace(ISSUED, order_id="order-2", plan_version=3)
    other = replace(ISSUED, vehicle_id="shuttle-2", order_id="order-9")
    for order in (ISSUED, other, second, third):
        record.do(lambda uow, o=order: uow.orders.add(o))  # type: ignore[misc]
        assert record.found(lambda uow, o=order: uow.orders.current(o.vehicle_id)) == order  # type: ignore[misc]
    rejected = replace(second, state=OrderState.REJECTED, reason="expired: too late")
    record.do(lambda uow: uow.orders.save(rejected))
    assert record.found(lambda uow: uow.orders.current("shuttle-1")) == third
    assert record.found(lambda uow: uow.orders.find("shuttle-1", "order-1", 2)) == rejected
    assert record.found(lambda uow: uow.orders.find("shuttle-1", "order-1", 3)) is None
    done = replace(third, state=OrderState.DONE)
    record.do(lambda uow: uow.orders.save(done))
    assert record.found(lambda uow: uow.orders.current("shuttle-1")) == done
    assert record.found(lambda uow: uow.orders.current("shuttle-2")) == other


def test_a_vehicle_has_been_ordered_the_rides_that_any_of_its_orders_named(record: Record) -> None:
    visit = Visit("v1", "stop", "s", "l", 1.0, (), (RiderTask("ride-1", 1, "1234"),))
    named = replace(ISSUED, payload=msgspec.structs.replace(ORDER, visits=(visit,)))
    for order in (named, replace(ISSUED, revision=2, plan_version=2)):
        record.do(lambda uow, o=order: uow.orders.add(o))  # type: ignore[misc]
    asked = [
        ("shuttle-1", "ride-1"),
        ("shuttle-1", "ride-"),
        ("shuttle-1", "ride_1"),
        ("shuttle-2", "ride-1"),
    ]
    assert record.do(lambda uow: [uow.orders.has_named(*one) for one in asked]) == [True, False, False, False]


def test_sections_are_kept_in_route_order_and_fences_only_rise(record: Record) -> None:
    first, second = (record.do(lambda uow: uow.sections.next_fence()) for _ in range(2))
    assert second > first
    mine = Occupancy("shuttle-2", (HeldSection("b", first), HeldSection("a", second)), ("d", "c"), "goal")
    other = Occupancy("shuttle-1", (HeldSection("x", second + 1),), ())
    record.do(lambda uow: (uow.sections.save(mine), uow.sections.save(other)))
    assert record.found(lambda uow: uow.sections.all()) == (other, mine)
    record.do(lambda uow: uow.sections.remove("shuttle-1"))
    assert record.found(lambda uow: uow.sections.all()) == (mine,)


def test_a_leg_ends_once_and_driven_legs_are_forgotten_when_they_are_older(record: Record) -> None:
    record.do(lambda uow: uow.travel_time_factors.begin_leg("shuttle-1", "C6", NOW))
    record.do(lambda uow: uow.travel_time_factors.begin_leg("shuttle-1", "NN20", NOW + SECOND))
    ended = record.do(lambda uow: uow.travel_time_factors.end_leg("shuttle-1"))
    assert ended == ("NN20", NOW + SECOND)
    assert record.do(lambda uow: uow.travel_time_factors.end_leg("shuttle-1")) is None
    legs = [
        DrivenLeg("snow-lion", "shuttle-1", NOW + n * DAY, "C6", "NN20", 8, 100.0, 120.0) for n in range(3)
    ]
    record.do(lambda uow: [uow.travel_time_factors.add(leg) for leg in reversed(legs)])
    assert record.found(lambda uow: uow.travel_time_factors.legs()) == tuple(legs)
    assert record.do(lambda uow: uow.travel_time_factors.forget_before(legs[1].left_at)) == 1
    assert record.found(lambda uow: uow.travel_time_factors.legs()) == tuple(legs[1:])


def test_the_learnt_factors_replace_those_before(record: Record) -> None:
    assert record.found(lambda uow: uow.travel_time_factors.present()) is None
    for factor in (1.5, 1.2):
        learnt = TravelTimeFactors((factor,) * 24, (3,) * 24, NOW)
        record.do(lambda uow, f=learnt: uow.travel_time_factors.save(f))  # type: ignore[misc]
        assert record.found(lambda uow: uow.travel_time_factors.present()) == learnt

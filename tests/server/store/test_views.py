"""What pages read of a vehicle: its plan, its order and whether the order is behind the plan."""

from dataclasses import replace

import pytest

from server.domain.planning.plans import Plan
from tests.server.store.conftest import Record
from tests.server.store.test_fleet import ISSUED, SHUTTLE, add_vehicles


@pytest.mark.parametrize(("ordered_version", "waits"), [(0, True), (1, False)])
def test_an_order_waits_only_while_its_plan_is_newer(
    record: Record, ordered_version: int, waits: bool
) -> None:
    add_vehicles(record, SHUTTLE)
    record.do(lambda uow: uow.plans.save(Plan("snow-lion", "shuttle-1", 1), 0))
    record.do(lambda uow: uow.orders.add(replace(ISSUED, plan_version=ordered_version)))
    view = record.found(lambda uow: uow.views.vehicle("shuttle-1"))
    assert view is not None
    assert view.order_waits is waits

"""What is on its way to a shuttle: its order until it has accepted it, its road as long as it drives."""

from contract.wire.messages import Grants, Order
from server.usecases.orders.outbox import Outbox, outbox_of
from tests.server.usecases.fake_fleet import FakeFleet


def outbox(fleet: FakeFleet, vehicle_id: str) -> Outbox:
    return fleet.campus.read(lambda uow: outbox_of(uow, vehicle_id))


def test_an_order_is_sent_until_it_is_accepted_and_its_road_until_it_is_done(driven_fleet: FakeFleet) -> None:
    fleet = driven_fleet
    ride = fleet.book("NN20", "C6", 2)
    vehicle_id = ride.vehicle_id
    assert vehicle_id is not None
    new = outbox(fleet, vehicle_id)
    assert isinstance(new.order, Order)
    assert new.order.visits[0].board[0].ride_id == ride.ride_id
    assert isinstance(new.grants, Grants)
    assert new.order.sections == new.grants.sections
    assert new.grants.order_id == new.order.order_id
    fleet.run_until(lambda: outbox(fleet, vehicle_id).order is None)
    assert not fleet.ride(ride.ride_id).has_ended
    assert outbox(fleet, vehicle_id).grants is not None
    fleet.run_until_idle(2000.0)
    assert outbox(fleet, vehicle_id) == Outbox(None, None, (), ())


def test_a_shuttle_without_an_order_is_sent_none(driven_fleet: FakeFleet) -> None:
    for shuttle in driven_fleet.shuttles:
        assert outbox(driven_fleet, shuttle.vehicle_id) == Outbox(None, None, (), ())

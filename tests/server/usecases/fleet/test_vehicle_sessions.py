"""What the server records of a vehicle that connects before there is a map."""

from dataclasses import replace
from functools import partial

from contract.geometry import Pose2
from contract.wire.messages import Status
from server.domain.fleet.vehicles import StatusReport
from server.store.transactions import InlineTransactions
from server.usecases.fleet import vehicle_sessions
from server.usecases.fleet.vehicle_sessions import HelloFacts
from server.usecases.record import identity
from tests.server.usecases.campus_under_test import CampusUnderTest


def test_a_vehicle_reports_its_position_though_its_campus_has_no_map_yet(campus: CampusUnderTest) -> None:
    """An engineer enrols the first vehicle before an operator has loaded the map."""
    context = replace(campus.context, campus_id="without-map")
    bare = InlineTransactions(campus.engine, context, campus.bus)
    enrolled = partial(
        identity.create_enrolment_code, vehicle_id="cart", name="cart", by="ann", seats=4, wheelchair_places=0
    )
    campus.wait_for(bare.run(enrolled))
    hello = HelloFacts("cart", "boot-1", "1", "gem", "map-0", (), None, 4, 0)
    session = campus.wait_for(bare.run(lambda uow: vehicle_sessions.open_session(uow, hello)))
    assert session.epoch == 1
    here = Pose2(3.0, 4.0, 0.0)
    status = Status(1, 0, here, 0.0, 0.0, 0.0, "held", 0.9, False, "", 0.0, "", 0, "")
    report = StatusReport("cart", "boot-1", campus.clock.now(), status)
    campus.wait_for(bare.run(lambda uow: vehicle_sessions.record_status(uow, [report])))
    (where,) = campus.wait_for(bare.read(lambda uow: uow.vehicles.all_whereabouts()))
    assert where.status is not None
    assert (where.vehicle_id, where.status.pose_map) == ("cart", here)

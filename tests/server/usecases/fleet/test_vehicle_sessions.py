"""What the server records of a vehicle that connects: without a map, and after a start of its agent."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import pytest

from contract.geometry import Pose2
from contract.wire.messages import Command, EventLogState, ModeChanged, SectionReleased, Status
from server.domain.fleet.vehicles import StatusReport, Vehicle
from server.domain.orders.sections import HeldSection
from server.store.transactions import InlineTransactions
from server.usecases.fleet import vehicle_sessions
from server.usecases.fleet.vehicle_sessions import HelloFacts
from server.usecases.orders import outbox
from server.usecases.ports import topics
from server.usecases.record import identity
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.roads.road_positions import under_body
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fresh_database import fresh_database
from tests.server.usecases.shipped_maps import shipped_map


@pytest.fixture
def fleet() -> Iterator[FakeFleet]:
    campus = CampusUnderTest(shipped_map("snow-lion"), engine=fresh_database())
    yield FakeFleet(campus, shipped_map("snow-lion"), 1).start()
    campus.close()


def starts(fleet: FakeFleet, boot_id: str, run_boot_id: str = "") -> None:
    """The process that talks to the server starts, and says hello."""
    shuttle = fleet.shuttles[0]
    shuttle.disconnect()
    hello = HelloFacts(
        shuttle.vehicle_id, boot_id, "test", "fake", shuttle.network.map_version, (), None, 6, 0, run_boot_id
    )
    fleet.campus.do(lambda uow: vehicle_sessions.open_session(uow, hello))


def accepts_rides(fleet: FakeFleet) -> bool:
    vehicle_id = fleet.shuttles[0].vehicle_id
    return fleet.campus.read(lambda uow: enrolled_vehicle(uow, vehicle_id)).accepts_rides


def vehicle_of(fleet: FakeFleet) -> Vehicle:
    return fleet.campus.read(lambda uow: enrolled_vehicle(uow, fleet.shuttles[0].vehicle_id))


def held_by(fleet: FakeFleet) -> tuple[HeldSection, ...]:
    return fleet.campus.read(lambda uow: uow.sections.held_by(fleet.shuttles[0].vehicle_id))


def waiting_commands(fleet: FakeFleet) -> tuple[Command, ...]:
    return fleet.campus.do(lambda uow: outbox.outbox_of(uow, fleet.shuttles[0].vehicle_id)).commands


def test_a_shuttle_whose_link_alone_has_started_drives_on_and_takes_rides(fleet: FakeFleet) -> None:
    """Its mode has not changed, so it says none."""
    assert accepts_rides(fleet)
    starts(fleet, "link-2", run_boot_id=fleet.shuttles[0].boot_id)
    assert accepts_rides(fleet)


def test_a_shuttle_whose_link_alone_has_started_stays_held(fleet: FakeFleet) -> None:
    fleet.shuttles[0].hold()
    starts(fleet, "link-2", run_boot_id=fleet.shuttles[0].boot_id)
    assert not accepts_rides(fleet)


def test_a_database_without_the_newest_events_goes_on_with_the_next_one(fleet: FakeFleet) -> None:
    """It was restored from a backup; the vehicle has forgotten what had been stored."""
    shuttle = fleet.shuttles[0]
    fences = {one.fence for one in fleet.campus.read(lambda uow: uow.sections.held_by(shuttle.vehicle_id))}
    shuttle.disconnect()
    shuttle.told += [ModeChanged("held")] * 5
    shuttle.sequence = len(shuttle.told)
    shuttle.connect()
    assert not accepts_rides(fleet)
    shuttle.resume()
    assert accepts_rides(fleet)
    (command,) = waiting_commands(fleet)
    assert command.kind == "hold", "it may drive on what others are granted now"
    held = fleet.campus.read(lambda uow: uow.sections.held_by(shuttle.vehicle_id))
    assert held
    assert min(one.fence for one in held) > max(fences) + 1_000_000, "no fence is given twice"


def test_a_driving_shuttle_that_is_not_known_is_placed_when_it_stands(fleet: FakeFleet) -> None:
    """It has left the sections under it before it knows that it holds them."""
    shuttle = fleet.shuttles[0]
    ride = fleet.book("NN20", "C6")
    fleet.run_until(lambda: shuttle.driven_m > 30.0)
    shuttle.disconnect()
    shuttle.told += [ModeChanged("autonomous")] * 5
    shuttle.sequence = len(shuttle.told)
    shuttle.connect()
    for _ in range(2):
        fleet.step()
    assert not vehicle_of(fleet).placed
    shuttle.hold()
    fleet.step()
    assert vehicle_of(fleet).placed
    held = [one.section_id for one in held_by(fleet)]
    assert held == list(under_body(fleet.network, shuttle.place.lane_id, shuttle.place.s_m))
    shuttle.resume()
    fleet.run_until(lambda: fleet.ride(ride.ride_id).has_ended, 3600.0)
    fleet.run_until_idle(3600.0)


def test_a_shuttle_that_has_left_its_only_section_is_placed_again_where_it_stands(fleet: FakeFleet) -> None:
    """A driver has driven it by hand, or it has slid: it holds that section until its place is known."""
    shuttle = fleet.shuttles[0]
    ride = fleet.book("NN20", "C6")
    fleet.run_until(lambda: shuttle.driven_m > 30.0)
    shuttle.hold()
    *behind, last = held_by(fleet)
    for one in behind:
        shuttle.say(SectionReleased(one.section_id, one.fence))
    topic = topics.vehicle(fleet.campus.road_map.campus_id, shuttle.vehicle_id)
    fleet.campus.bus.heard(topic)
    shuttle.say(SectionReleased(last.section_id, last.fence))
    assert fleet.campus.bus.heard(topic), "the console shows at once that its place is not known"
    assert (vehicle_of(fleet).placed, held_by(fleet)) == (False, (last,))
    fleet.step()
    assert vehicle_of(fleet).placed
    assert min(one.fence for one in held_by(fleet)) > last.fence
    shuttle.resume()
    fleet.run_until(lambda: fleet.ride(ride.ride_id).has_ended, 3600.0)
    fleet.run_until_idle(3600.0)


@pytest.mark.parametrize("run_boot_id", ["", "tick-2"])
def test_a_shuttle_that_has_started_is_held(fleet: FakeFleet, run_boot_id: str) -> None:
    starts(fleet, "boot-2", run_boot_id)
    assert not accepts_rides(fleet)


def test_a_vehicle_reports_its_position_though_its_campus_has_no_map_yet(campus: CampusUnderTest) -> None:
    """An engineer enrols the first vehicle before an operator has loaded the map."""
    context = replace(campus.context, campus_id="without-map")
    bare = InlineTransactions(campus.engine, context, campus.bus)
    enrolled = partial(
        identity.create_enrolment_code, vehicle_id="cart", name="cart", by="ann", seats=4, wheelchair_places=0
    )
    campus.wait_for(bare.run(enrolled))
    # It has told more than this database knows, too: a copy from before the map was put back.
    logs = (EventLogState("boot-1", 7, 7),)
    hello = HelloFacts("cart", "boot-1", "1", "gem", "map-0", logs, None, 4, 0)
    session = campus.wait_for(bare.run(lambda uow: vehicle_sessions.open_session(uow, hello)))
    assert session.epoch == 1
    here = Pose2(3.0, 4.0, 0.0)
    status = Status(1, 0, here, 0.0, 0.0, 0.0, "held", 0.9, False, "", 0.0, "", 0, "")
    report = StatusReport("cart", "boot-1", campus.clock.now(), status)
    campus.wait_for(bare.run(lambda uow: vehicle_sessions.record_status(uow, [report])))
    (where,) = campus.wait_for(bare.read(lambda uow: uow.vehicles.all_whereabouts()))
    assert where.status is not None
    assert (where.vehicle_id, where.status.pose_map) == ("cart", here)

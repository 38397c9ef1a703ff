"""A vehicle that breaks the protocol: its own incident, its own disconnection, and the fleet goes on."""

from datetime import timedelta

import pytest
from sqlalchemy import update

from contract.geometry import Pose2
from contract.wire.codec import encode
from contract.wire.messages import ModeChanged, Status
from server.domain.fleet.vehicles import Vehicle, Whereabouts
from server.store import tables
from server.usecases.fleet import quarantine
from server.usecases.ports.unit_of_work import UnitOfWork
from tests.server.api.server_under_test import ServerUnderTest, snow_lion
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.test_hub import at_rest, incident_kinds

REST = snow_lion().resting_places[0]


def record_of(server: ServerUnderTest, vehicle_id: str = "shuttle-1") -> Vehicle:
    def work(uow: UnitOfWork) -> Vehicle:
        vehicle = uow.vehicles.get(vehicle_id)
        assert vehicle is not None
        return vehicle

    vehicle: Vehicle = server.transact(work)
    return vehicle


def review(server: ServerUnderTest) -> None:
    """As the silence monitor does every second."""
    server.transact(quarantine.review)


def a_mad_status(vehicle: SpokenVehicle) -> bytes:
    still = Pose2(0.0, 0.0, 0.0)
    return encode(Status(vehicle.epoch, 5, still, -5e200, 0.0, 0.0, "held", 0.9, False, "", 0.0, "", 0, ""))


def booked_state(server: ServerUnderTest) -> str:
    answer = server.post("/rides", {"from_stop": "NN20", "to_stop": "C6"})
    assert answer.status_code == 201, answer.text
    state: str = answer.json()["state"]
    return state


def test_the_mad_one_is_cut_off_and_another_shuttle_still_gets_the_rides(server: ServerUnderTest) -> None:
    mad, sane = SpokenVehicle(server).dial().hello(), SpokenVehicle(server, "shuttle-2").dial().hello()
    at_rest(server, mad, 0)
    at_rest(server, sane, 1)
    mad.say(a_mad_status(mad))
    server.elapse(1.0)
    assert mad.goodbye == "malformed"
    assert "protocol_violation" in incident_kinds(server)
    assert booked_state(server) == "assigned"
    (ride,) = server.get("/rides").json()
    assert ride["vehicle_id"] == "shuttle-2"


def test_it_gets_rides_again_once_it_has_kept_to_the_protocol_for_a_while(server: ServerUnderTest) -> None:
    mad = SpokenVehicle(server).dial().hello()
    at_rest(server, mad)
    mad.say(a_mad_status(mad))
    back = SpokenVehicle(server).dial().hello()
    back.event(1, ModeChanged("autonomous", detail="resumed"))
    server.elapse(30.0)
    review(server)
    assert not record_of(server).accepts_rides
    assert booked_state(server) == "refused"
    server.elapse(31.0)
    review(server)
    assert record_of(server).accepts_rides
    assert "protocol_violation" not in incident_kinds(server)
    assert booked_state(server) == "assigned"


def test_each_breach_begins_the_time_again(server: ServerUnderTest) -> None:
    for _ in range(3):
        mad = SpokenVehicle(server).dial().hello()
        mad.say(a_mad_status(mad))
        server.elapse(40.0)
        review(server)
        assert record_of(server).quarantined_at is not None


def test_a_vehicle_that_stays_away_stays_in_quarantine(server: ServerUnderTest) -> None:
    mad = SpokenVehicle(server).dial().hello()
    mad.say(a_mad_status(mad))
    server.elapse(300.0)
    review(server)
    assert record_of(server).quarantined_at is not None


def poison(server: ServerUnderTest, **columns: object) -> None:
    """Change rows as a former version of the server could have left them, and read them as after a start."""

    def work(uow: UnitOfWork) -> None:
        # A transaction that has not said that it writes is rolled back.
        uow.rides._require_lock()  # type: ignore[attr-defined]
        connection = uow.rides._connection  # type: ignore[attr-defined]
        for table in (tables.vehicles, tables.whereabouts):
            values = {name: value for name, value in columns.items() if name in table.c}
            if values:
                connection.execute(update(table).where(table.c.vehicle_id == "shuttle-1").values(**values))

    server.transact(work)
    server.run(server.transactions.close())


@pytest.mark.parametrize(
    "columns",
    [
        {"seats": 2**62},
        {"seats": -3},
        {"wheelchair_places": 2**40},
        {"status": '{"type":"status","speed_mps":-5e200}'},
        {"status": "no JSON"},
    ],
)
def test_a_poisoned_record_from_before_harms_no_booking(
    server: ServerUnderTest, columns: dict[str, object]
) -> None:
    for number, vehicle_id in enumerate(("shuttle-1", "shuttle-2")):
        at_rest(server, SpokenVehicle(server, vehicle_id).dial().hello(), number)
    poison(server, **columns)
    review(server)
    assert "protocol_violation" in incident_kinds(server)
    assert booked_state(server) == "assigned"
    (ride,) = server.get("/rides").json()
    assert ride["vehicle_id"] == "shuttle-2"


def test_a_valid_status_replaces_one_that_could_not_be_read(server: ServerUnderTest) -> None:
    vehicle = SpokenVehicle(server).dial().hello()
    at_rest(server, vehicle)
    poison(server, status="no JSON")
    at_rest(server, vehicle)
    server.elapse(1.0)

    def where(uow: UnitOfWork) -> Whereabouts | None:
        return uow.vehicles.whereabouts("shuttle-1")

    known: Whereabouts = server.transact(where)
    assert known.unreadable == ""
    assert known.status is not None
    assert server.clock.now() - known.heard_at < timedelta(seconds=10)


def test_an_incident_that_was_closed_during_the_quarantine_opens_again_and_says_why(
    server: ServerUnderTest,
) -> None:
    mad = SpokenVehicle(server).dial().hello()
    mad.say(a_mad_status(mad))
    headers = server.sign_in()
    (incident,) = server.get("/incidents").json()
    assert "speed_mps" in incident["cause"]
    server.post(f"/incidents/{incident['incident_id']}/close", headers=headers)
    review(server)
    (reopened,) = server.get("/incidents").json()
    assert reopened["kind"] == "protocol_violation"
    assert reopened["cause"].startswith("in quarantine since 08:00:0")

"""What screens show: what comes by the bus at once, and whatever was missed a few seconds later."""

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest

from contract.geometry import Pose2
from contract.wire.messages import ModeChanged
from server.domain.rides.rides import RideState, ended
from server.live.feed import LINGER_MS, READ_ALL_EVERY_S
from server.live.scene import RideScene, SceneBoard, VehicleScene
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.rides import rides
from server.usecases.rides.tickets import ride_by_token
from tests.server.api.server_under_test import ServerUnderTest, snow_lion
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.vehicle_key import VehicleKeyPair

REST = snow_lion().resting_places[0]


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerUnderTest]:
    server = ServerUnderTest(tmp_path)
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
    yield server
    server.close()


def board(server: ServerUnderTest) -> SceneBoard:
    return server.services.feed.board


def shown_ride(server: ServerUnderTest) -> RideScene | None:
    return next((scene for _, scene in board(server).rides.values()), None)


def shown_vehicle(server: ServerUnderTest) -> VehicleScene:
    scene = board(server).vehicle("shuttle-1")
    assert scene is not None
    return scene


def shown_pose(server: ServerUnderTest) -> Pose2:
    status = shown_vehicle(server).status
    assert status is not None
    return status.pose_map


def ready(server: ServerUnderTest) -> SpokenVehicle:
    """At its resting place, free to drive."""
    vehicle = SpokenVehicle(server).dial().hello()
    x_m, y_m, yaw_rad = server.transact(lambda uow: uow.network().pose(REST.lane_id, REST.s_m))
    vehicle.event(0, ModeChanged("autonomous", detail="resumed"))
    vehicle.status(x_m, y_m, yaw_rad, lane_id=REST.lane_id, s_m=REST.s_m)
    server.elapse(1.5)
    return vehicle


def booked(server: ServerUnderTest) -> str:
    """The ride's id."""
    answer = server.post("/rides", {"from_stop": "NN20", "to_stop": "C6"})
    assert answer.status_code == 201, answer.text
    found: str = server.transact(lambda uow: ride_by_token(uow, answer.json()["token"]).ride_id)
    return found


def test_a_position_is_shown_as_soon_as_the_vehicle_has_told_it(server: ServerUnderTest) -> None:
    vehicle = ready(server)
    heard_ms, here = shown_vehicle(server).heard_ms, shown_pose(server)
    vehicle.status(here.x_m + 3.0, here.y_m, here.yaw_rad, speed_mps=2.5, lane_id=REST.lane_id)
    server.elapse(0.3)
    now = shown_vehicle(server)
    assert now.status is not None
    assert (now.status.pose_map.x_m, now.status.speed_mps) == (pytest.approx(here.x_m + 3.0), 2.5)
    assert now.heard_ms > heard_ms


def test_a_full_reading_of_the_store_does_not_bring_an_old_position_back(server: ServerUnderTest) -> None:
    vehicle = ready(server)
    for step in range(1, 30):
        here = shown_pose(server)
        vehicle.status(here.x_m + 0.5, here.y_m, here.yaw_rad, lane_id=REST.lane_id)
        server.elapse(0.5)
        assert shown_pose(server).x_m == pytest.approx(here.x_m + 0.5), step


def test_a_booking_appears_with_its_shuttle_and_the_shuttle_with_its_next_stop(
    server: ServerUnderTest,
) -> None:
    ready(server)
    ride_id = booked(server)
    server.elapse(0.6)
    ride = shown_ride(server)
    assert ride is not None
    assert (ride.ride_id, ride.state, ride.vehicle_id) == (ride_id, "assigned", "shuttle-1")
    assert shown_vehicle(server).task.next_stop == "NN20"


def test_an_ended_ride_stays_for_two_minutes_so_that_its_passenger_sees_how_it_ended(
    server: ServerUnderTest,
) -> None:
    ready(server)
    ride_id = booked(server)
    server.transact(lambda uow: rides.cancel(uow, ride_id, "passenger"))
    server.elapse(1.0)
    ride = shown_ride(server)
    assert ride is not None
    assert ride.state == "cancelled"
    server.elapse(LINGER_MS / 1000.0 - 5.0)
    assert shown_ride(server) is not None
    server.elapse(5.0 + READ_ALL_EVERY_S)
    assert shown_ride(server) is None


def test_a_change_of_which_the_bus_lost_the_word_is_shown_after_ten_seconds(server: ServerUnderTest) -> None:
    ready(server)
    ride_id = booked(server)
    server.elapse(1.0)

    def silently(uow: UnitOfWork) -> None:
        uow.rides.save(ended(rides.ride_of(uow, ride_id), RideState.FAILED, uow.now, "vehicle_lost"))

    server.transact(silently)
    server.elapse(READ_ALL_EVERY_S + 0.5)
    ride = shown_ride(server)
    assert ride is not None
    assert ride.state == "failed"


def test_a_vehicle_that_is_gone_is_no_longer_shown(server: ServerUnderTest) -> None:
    ready(server)
    headers = server.sign_in()
    assert server.request("DELETE", "/vehicles/shuttle-1", headers=headers).status_code == 200
    server.elapse(READ_ALL_EVERY_S + 0.5)
    assert board(server).vehicle("shuttle-1") is None


def test_incidents_and_the_map_are_on_the_board_from_the_start(server: ServerUnderTest) -> None:
    assert board(server).map_version == snow_lion().map_version
    assert board(server).incidents.open == 0
    ready(server)
    ride_id = booked(server)
    server.transact(lambda uow: rides.call_help(uow, ride_id, "I cannot find the shuttle"))
    server.elapse(0.6)
    assert board(server).incidents.open == 1


async def first_look(server: ServerUnderTest) -> VehicleScene:
    async with server.services.feed.watched() as seen:
        scene = seen.vehicle("shuttle-1")
    assert scene is not None
    return scene


def test_nothing_is_read_while_nobody_watches_and_the_first_who_comes_sees_the_present(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    server = ServerUnderTest(tmp_path, is_watched=False)
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
    ready(server)
    assert server.run(first_look(server)).task.next_stop == ""
    booked(server)
    with monkeypatch.context() as unread:
        unread.setattr("server.live.feed._reading", None)
        server.elapse(3 * READ_ALL_EVERY_S)
    assert server.run(first_look(server)).task.next_stop == "NN20"
    server.close()


def test_a_viewer_who_leaves_during_the_first_reading_takes_nothing_from_the_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    server = ServerUnderTest(tmp_path, is_watched=False)
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)

    async def slow(work: object) -> None:
        await asyncio.sleep(60.0)

    async def leaves() -> None:
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(first_look(server), 1.0)

    with monkeypatch.context() as slowly:
        slowly.setattr(server.transactions, "read", slow)
        left = server.conductor.loop.create_task(leaves())
        server.elapse(2.0)
        assert left.done()
    left.result()
    assert server.run(first_look(server)).facts.name == "Shuttle-1"
    server.close()


def test_operators_hear_at_once_that_a_vehicle_holds_but_not_of_every_position(
    server: ServerUnderTest,
) -> None:
    vehicle = ready(server)
    server.elapse(1.0)
    news = server.services.feed.news
    x_m, y_m, yaw_rad = server.transact(lambda uow: uow.network().pose(REST.lane_id, REST.s_m))
    vehicle.status(x_m + 1.0, y_m, yaw_rad, lane_id=REST.lane_id, s_m=REST.s_m)
    assert not news.is_set()
    vehicle.status(x_m + 1.0, y_m, yaw_rad, lane_id=REST.lane_id, s_m=REST.s_m, mode="held")
    assert news.is_set()
    assert not server.services.feed.news.is_set(), "the next news is another event"

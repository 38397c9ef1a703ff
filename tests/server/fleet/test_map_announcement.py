"""A map is published while vehicles are connected: each learns of it over its link, until it drives by it."""

import hashlib

import msgspec
import pytest

from contract.roads.load import encode_map, with_version
from contract.wire.messages import MapPublished
from server.usecases.fleet import campus
from tests.server.api.server_under_test import ServerUnderTest, snow_lion
from tests.server.fleet.spoken_vehicle import SpokenVehicle
from tests.server.fleet.vehicle_key import VehicleKeyPair

AFTER = with_version(msgspec.structs.replace(snow_lion(), name="Renamed", map_version=""))


@pytest.fixture
def ready(server: ServerUnderTest) -> ServerUnderTest:
    server.enrol("shuttle-1", VehicleKeyPair("shuttle-1").public_base64)
    return server


def publish(server: ServerUnderTest) -> None:
    server.transact(lambda uow: campus.load_map(uow, encode_map(AFTER), "ann", activate=True))


def announced(vehicle: SpokenVehicle) -> list[MapPublished]:
    return [message for message in vehicle.heard if isinstance(message, MapPublished)]


def test_a_connected_vehicle_is_told_at_once_and_again_and_a_new_one_with_its_welcome(
    ready: ServerUnderTest,
) -> None:
    vehicle = SpokenVehicle(ready).dial().hello(protocol=2)
    assert announced(vehicle) == []
    publish(ready)
    ready.elapse(0.5)
    (first,) = announced(vehicle)
    assert first.map_version == AFTER.map_version
    assert first.sha256 == hashlib.sha256(encode_map(AFTER)).hexdigest()
    ready.elapse(7.0)
    assert len(announced(vehicle)) >= 3, "until it says hello with that map"
    again = SpokenVehicle(ready).dial().hello(protocol=2)
    assert [one.map_version for one in announced(again)] == [AFTER.map_version]


def test_a_vehicle_of_the_older_protocol_is_not_sent_what_it_does_not_know(ready: ServerUnderTest) -> None:
    vehicle = SpokenVehicle(ready).dial().hello(protocol=1)
    publish(ready)
    ready.elapse(4.0)
    assert announced(vehicle) == []
    assert vehicle.closed == ""
    known = ready.transact(lambda uow: uow.vehicles.get("shuttle-1"))
    assert known is not None
    assert known.map_failure == "old_agent"

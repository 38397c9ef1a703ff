from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.server.api.server_under_test import ServerUnderTest
from tests.server.fleet.vehicle_key import VehicleKeyPair


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerUnderTest]:
    server = ServerUnderTest(tmp_path)
    for vehicle_id in ("shuttle-1", "shuttle-2"):
        server.enrol(vehicle_id, VehicleKeyPair(vehicle_id).public_base64)
    yield server
    server.close()

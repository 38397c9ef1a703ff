from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.server.api.server_under_test import ServerUnderTest


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerUnderTest]:
    server = ServerUnderTest(tmp_path)
    yield server
    server.close()

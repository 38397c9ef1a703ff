"""The live server with crashes: database, journal and tracebacks hold no secret."""

import asyncio
import io
import logging
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tests.campusloop.live.live_server import LiveServer, live_server, obedient_vehicle
from tests.campusloop.secret_search import Secrets
from tests.campusloop.telemetry.restored_journal import restored_journal
from tests.server.api.server_under_test import PASSWORD
from vehicle_agent.runtime.processes.journal import write_journal

KINDS = {
    "token",
    "boarding_code",
    "csrf_token",
    "secret",
    "enrolment code",
    "idempotency key",
    "password",
    "cookie campusloop_session",
}
SERIES = {
    "from_stop": "NN20",
    "to_stop": "C6",
    "weekdays": [0, 1, 2, 3, 4, 5, 6],
    "leave": "12:00",
    "ends_on": (datetime.now(UTC) + timedelta(days=3)).date().isoformat(),
}


@pytest.fixture
def journal() -> Iterator[io.StringIO]:
    """The journal as the server writes it, all levels."""
    with restored_journal():
        written = io.StringIO()
        write_journal("server", written, logging.DEBUG)
        yield written


async def hand_out_secrets(server: LiveServer) -> str:
    """A ride's token; each other kind of secret is handed out as well."""
    key = {"Idempotency-Key": "the-key-of-a-booking"}
    async with obedient_vehicle(server):
        ride = {"from_stop": "NN20", "to_stop": "C6"}
        booked = await server.http.post("/rides", json=ride, headers=key)
        token: str = booked.raise_for_status().json()["token"]
        (await server.http.post("/series", json=SERIES)).raise_for_status()
        await server.developer_token("read", "drive")
        webhook = {"url": "https://hooks.example.org/", "event_types": ["ride.*"]}
        await server.change("POST", "/webhooks", webhook)
        await server.change("POST", f"/rides/{token}/help", {"text": "Hello?"})
        (await server.http.get("/rides")).raise_for_status()
    return token


async def crash(server: LiveServer, database: Path, token: str) -> None:
    """Take tables away under the running server, then send secrets to what needs them."""
    with closing(sqlite3.connect(database)) as connection:
        for table in ("taps", "operator_sessions", "developer_tokens", "enrolment_codes", "series"):
            connection.execute(f"DROP TABLE {table}")
    enrolment = {"code": "an-enrolment-code-that-fails", "vehicle_id": "shuttle-9", "public_key": "x"}
    bearer = {"Authorization": "Bearer a-developer-token-that-fails"}
    answers = [
        await server.http.post(f"/rides/{token}/board"),
        await server.http.get("/rides"),
        await server.http.get("/rides", headers=bearer),
        await server.http.post("/enrolments", json=enrolment),
        await server.http.get(f"/series/{token}"),
    ]
    assert 500 in {answer.status_code for answer in answers}


def test_database_journal_and_tracebacks_hold_no_secret(
    tmp_path: Path, journal: io.StringIO, capfd: pytest.CaptureFixture[str]
) -> None:
    secrets = Secrets()
    secrets.add("password", PASSWORD)
    for kind in ("an-enrolment-code-that-fails", "a-developer-token-that-fails"):
        secrets.add(kind, kind)

    async def morning() -> None:
        async with asyncio.timeout(40), live_server(tmp_path, secrets=secrets) as server:
            token = await hand_out_secrets(server)
            found = secrets.found_in_folder(tmp_path)
            assert found == set()
            await crash(server, tmp_path / "campusloop.db", token)

    asyncio.run(morning())
    said = journal.getvalue() + "".join(capfd.readouterr())
    assert "OperationalError" in said, "nothing has crashed"
    assert secrets.kinds() >= KINDS
    assert secrets.found_in("journal", said.encode()) == set()

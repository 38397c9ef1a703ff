"""The doctor names each defect of an installation with what to do."""

import asyncio
import os
import socketserver
import threading
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from sqlalchemy import insert

from campusloop.live.certificate import VALID_DAYS, self_signed
from campusloop.operations.examination import examine
from campusloop.operations.finding import Finding
from campusloop.operations.machine import EARLIEST, wrong_packages
from campusloop.operations.network import readiness
from server.push_key_file import push_identity_of
from server.store.engine import open_engine
from server.store.tables import server_events
from server.ticket_key_file import ticket_keys_of
from tests.campusloop.live.live_server import live_server
from tests.server.store.backups.writing_campus import a_database, set_revision

NOW = datetime(2026, 9, 1, 8, tzinfo=UTC)


def an_installation(folder: Path) -> dict[str, str]:
    """The settings of an installation without a defect."""
    (folder / "var").mkdir()
    (folder / "dist" / "console").mkdir(parents=True)
    for page in ("index.html", "console/index.html"):
        (folder / "dist" / page).write_text("<html></html>")
    a_database(folder / "var" / "campusloop.db")
    ticket_keys_of(folder / "var" / "ticket.key")
    push_identity_of(folder / "var" / "push.key")
    return {
        "CAMPUSLOOP_VAR_DIR": str(folder / "var"),
        "CAMPUSLOOP_WEB_DIST": str(folder / "dist"),
        "CAMPUSLOOP_PORT": "0",
        "CAMPUSLOOP_DISK_FREE_BYTES_MIN": "0",
    }


def findings(environment: dict[str, str], now: datetime = NOW) -> dict[str, Finding]:
    return {finding.check: finding for finding in examine(environment, now)}


def not_good(found: dict[str, Finding]) -> set[str]:
    """Without the kernels: whether they are compiled depends on what ran before this test."""
    return {name for name, finding in found.items() if finding.state != "good"} - {"kernels"}


def test_an_installation_without_a_defect_is_good_and_stays_as_it_was(tmp_path: Path) -> None:
    environment = an_installation(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    assert not_good(findings(environment)) == set()
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(
    ("changes", "check", "words"),
    [
        ({"CAMPUSLOOP_PORT": "many"}, "settings", "CAMPUSLOOP_PORT"),
        ({"CAMPUSLOOP_DISK_FREE_BYTES_MIN": str(2**60)}, "folder", "MiB free"),
        ({"CAMPUSLOOP_MAP_PATH": "nowhere.json"}, "map", "nowhere.json"),
        ({"CAMPUSLOOP_SERVICE_OPENS": "25:00"}, "map", "SERVICE_OPENS"),
        ({"CAMPUSLOOP_WEB_DIST": "nowhere"}, "pages", "no page for / and /console"),
        ({"CAMPUSLOOP_BUS_URL": "nats://u:hush@127.0.0.1:1"}, "bus", "no answer at 127.0.0.1:1"),
        ({"CAMPUSLOOP_SEGMENTS_URL": "nonsense://u:hush@x"}, "segments", "names no object store"),
        ({"CAMPUSLOOP_DATABASE_URL": "mysql://x"}, "database", "sqlite"),
        ({"CAMPUSLOOP_DATABASE_URL": "postgresql://u:hush@127.0.0.1:1/x"}, "database", "cannot be used"),
        ({"CAMPUSLOOP_TLS_CERT": "c.pem", "CAMPUSLOOP_TLS_KEY": "k.pem"}, "tls", "cannot be used"),
    ],
)
def test_a_bad_setting_is_one_bad_check_that_names_it_and_shows_no_password(
    tmp_path: Path, changes: dict[str, str], check: str, words: str
) -> None:
    found = findings(an_installation(tmp_path) | changes)
    assert not_good(found) == {check}
    assert found[check].state == "bad"
    assert words in found[check].text
    assert found[check].remedy
    assert "hush" not in str(found)


def test_a_variable_that_is_no_setting_is_a_warning(tmp_path: Path) -> None:
    found = findings(an_installation(tmp_path) | {"CAMPUSLOOP_POTR": "8080"})
    assert found["settings"].state == "warning"
    assert "CAMPUSLOOP_POTR" in found["settings"].text


def test_variables_of_the_command_line_are_no_settings_and_no_mistakes(tmp_path: Path) -> None:
    others = {"CAMPUSLOOP_SERVER": "http://127.0.0.1:8080", "CAMPUSLOOP_TOKEN": "secret"}
    assert findings(an_installation(tmp_path) | others)["settings"].state == "good"


@pytest.mark.parametrize(("name", "check"), [("ticket.key", "ticket keys"), ("push.key", "push key")])
def test_keys_that_are_missing_open_to_others_or_broken_are_told(
    tmp_path: Path, name: str, check: str
) -> None:
    environment, file = an_installation(tmp_path), tmp_path / "var" / name
    told = {}
    file.chmod(0o644)
    told["open"] = findings(environment)[check]
    file.write_text("no key")
    told["broken"] = findings(environment)[check]
    file.unlink()
    told["missing"] = findings(environment)[check]
    assert {name: finding.state for name, finding in told.items()} == {
        "open": "warning",
        "broken": "bad",
        "missing": "warning",
    }
    assert "chmod 600" in told["open"].remedy
    assert not file.exists()


def test_a_folder_that_cannot_be_written_is_bad(tmp_path: Path) -> None:
    environment = an_installation(tmp_path)
    (tmp_path / "file").touch()
    found = findings(environment | {"CAMPUSLOOP_VAR_DIR": str(tmp_path / "file" / "var")})
    assert found["folder"].state == "bad"
    assert "cannot be written" in found["folder"].text


@pytest.mark.parametrize(
    ("age", "state", "words"),
    [
        (timedelta(days=VALID_DAYS + 1), "bad", "expired on 2026-08-31"),
        (timedelta(days=VALID_DAYS - 7), "warning", "expires in 7 days"),
        (timedelta(days=-2), "bad", "begins on 2026-09-03"),
        (timedelta(0), "good", f"valid for {VALID_DAYS} more days"),
    ],
)
def test_a_certificate_is_judged_by_the_days_that_it_has_left(
    tmp_path: Path, age: timedelta, state: str, words: str
) -> None:
    certificate, key = self_signed(tmp_path / "tls", ("localhost",), NOW - age)
    given = {"CAMPUSLOOP_TLS_CERT": str(certificate), "CAMPUSLOOP_TLS_KEY": str(key)}
    found = findings(an_installation(tmp_path) | given)["tls"]
    assert found.state == state
    assert words in found.text


def test_a_database_of_a_newer_version_is_bad(tmp_path: Path) -> None:
    environment = an_installation(tmp_path)
    set_revision(tmp_path / "var" / "campusloop.db", "9999")
    found = findings(environment)["database"]
    assert found.state == "bad"
    assert "9999, which this version does not know" in found.text


def test_a_truncated_database_is_bad_and_a_backup_is_the_remedy(tmp_path: Path) -> None:
    environment = an_installation(tmp_path)
    path = tmp_path / "var" / "campusloop.db"
    os.truncate(path, path.stat().st_size // 2)
    found = findings(environment)["database"]
    assert found.state == "bad"
    assert "campusloop restore" in found.remedy


def test_a_clock_behind_the_newest_record_or_the_program_is_bad(tmp_path: Path) -> None:
    environment = an_installation(tmp_path)
    engine = open_engine(f"sqlite:///{tmp_path}/var/campusloop.db")
    with engine.begin() as connection:
        row = {"campus_id": "c", "number": 1, "happened_at": NOW + timedelta(hours=1)}
        texts = {"name": "ride.booked", "subject": "", "made_by": "", "detail": "{}"}
        connection.execute(insert(server_events).values(**row, **texts))
    engine.dispose()
    assert "3600 s in the future" in findings(environment)["clock"].text
    assert findings(environment, EARLIEST - timedelta(days=1))["clock"].state == "bad"
    assert findings(environment, NOW + timedelta(hours=2))["clock"].state == "good"


def test_packages_that_are_missing_or_too_old_are_named() -> None:
    wrong = wrong_packages(("numpy>=999", "no-such-package>=1", "pytest", "absent; extra == 'dev'"))
    assert len(wrong) == 2
    assert "needs >=999" in wrong[0]
    assert wrong[1] == "no-such-package is missing"


@pytest.mark.parametrize(
    "answer", [b"220 mail.example ready\r\n", b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\n{}"]
)
def test_a_port_that_another_program_uses_is_bad(tmp_path: Path, answer: bytes) -> None:
    environment = an_installation(tmp_path)

    class Answering(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            self.request.recv(1)
            self.request.sendall(answer)

    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Answering) as other:
        serving = threading.Thread(target=other.serve_forever)
        serving.start()
        found = findings(environment | {"CAMPUSLOOP_PORT": str(other.server_address[1])})["port"]
        other.shutdown()
        serving.join(30.0)
    assert found.state == "bad"
    assert "is in use" in found.text


def test_a_bus_that_is_no_nats_server_is_bad(tmp_path: Path) -> None:
    class Mail(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            self.request.sendall(b"220 mail.example ready\r\n")

    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Mail) as other:
        serving = threading.Thread(target=other.serve_forever)
        serving.start()
        bus = {"CAMPUSLOOP_BUS_URL": f"nats://127.0.0.1:{other.server_address[1]}"}
        found = findings(an_installation(tmp_path) | bus)["bus"]
        other.shutdown()
        serving.join(30.0)
    assert found.state == "bad"
    assert "is not a NATS server" in found.text


def test_a_standing_task_that_fails_is_named() -> None:
    task = {"name": "dispatcher", "state": "failing", "failures": 3, "last_good_at": None}
    good = {"name": "silence", "state": "good", "failures": 0, "last_good_at": None}
    answer = {
        "ready": False,
        "database": "good",
        "disk_has_room": True,
        "map_version": "m",
        "tasks": [task, good],
    }
    found = readiness("http://127.0.0.1:8080", answer)
    assert found.state == "bad"
    assert found.text.endswith("is not ready: task dispatcher is failing (3 failures)")


@pytest.mark.real
def test_a_server_that_is_not_ready_is_bad_with_the_reason_and_a_ready_one_good(tmp_path: Path) -> None:
    environment = an_installation(tmp_path)

    async def scenario(free_bytes_min: int) -> Finding:
        var = tmp_path / f"live-{free_bytes_min}"
        async with live_server(var, disk_free_bytes_min=free_bytes_min) as server:
            port = server.origin.rsplit(":", 1)[1]
            found = await asyncio.to_thread(
                findings, environment | {"CAMPUSLOOP_PORT": port, "CAMPUSLOOP_VAR_DIR": str(var)}
            )
            assert found["database"].state == "good", found["database"]
            return found["port"]

    ready = asyncio.run(scenario(0))
    assert ready.state == "good", ready
    unready = asyncio.run(scenario(2**60))
    assert unready.state == "bad"
    assert "too little room" in unready.text

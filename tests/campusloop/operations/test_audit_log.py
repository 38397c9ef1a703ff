"""`campusloop audit verify`: what it says of a database."""

from pathlib import Path

import pytest
from sqlalchemy import Engine
from typer.testing import CliRunner

from campusloop.cli import app_of
from server.domain.instants import EPOCH
from server.domain.record.audit import AuditAction, Caller, Head, entry_after
from server.store.engine import open_engine
from server.store.tables import audit_entries, metadata

ANN = Caller("operator", "ann", "192.0.2.7")


@pytest.fixture
def database(tmp_path: Path) -> Engine:
    """A log of three entries."""
    engine = open_engine(f"sqlite:///{tmp_path / 'campus.db'}")
    metadata.create_all(engine)
    head = Head()
    with engine.begin() as connection:
        for _ in range(3):
            entry = entry_after(head, "campus", EPOCH, ANN, AuditAction("hold_vehicle"), "salt")
            head = Head(entry.number, entry.sha256)
            connection.execute(
                audit_entries.insert().values(
                    campus_id="campus",
                    number=entry.number,
                    happened_at=EPOCH,
                    kind=entry.kind,
                    made_by=entry.by,
                    action="hold_vehicle",
                    subject="",
                    detail="",
                    outcome="done",
                    command_id="",
                    address=entry.address,
                    salt=entry.salt,
                    address_sha256=entry.address_sha256,
                    previous_sha256=entry.previous_sha256,
                    sha256=entry.sha256,
                )
            )
    return engine


def verify(engine: Engine, *more: str) -> tuple[int, str]:
    arguments = ["audit", "verify", "--database", str(engine.url), *more]
    result = CliRunner().invoke(app_of(["audit"]), arguments)
    return result.exit_code, result.output


def test_a_whole_log_is_told_with_its_head(database: Engine) -> None:
    code, said = verify(database)
    assert code == 0
    assert "3 entries follow one another; head 3:" in said
    head = said.rsplit("head ", 1)[1].strip()
    assert verify(database, "--head", head)[0] == 0


def test_a_changed_entry_is_named(database: Engine) -> None:
    with database.begin() as connection:
        connection.exec_driver_sql("UPDATE audit_entries SET made_by = 'eve' WHERE number = 2")
    code, said = verify(database)
    assert code == 1
    assert "broken at entry 2" in said


def test_a_log_that_was_cut_off_is_told_by_a_head_that_was_noted(database: Engine) -> None:
    head = verify(database)[1].rsplit("head ", 1)[1].strip()
    with database.begin() as connection:
        connection.exec_driver_sql("DELETE FROM audit_entries WHERE number = 3")
    assert verify(database)[0] == 0
    code, said = verify(database, "--head", head)
    assert code == 1
    assert "no such entry" in said


def test_a_head_that_cannot_be_read_is_refused(database: Engine) -> None:
    assert verify(database, "--head", "3")[0] == 2

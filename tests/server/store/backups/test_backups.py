"""Backups of a database file: complete, verified, and restored without harm to what was there."""

import os
import shutil
import sqlite3
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

import pytest
from alembic import command

from server.store.backups.backup import BackupRefused, back_up
from server.store.backups.restore import RestoreRefused, restore
from server.store.engine import open_engine
from server.store.schema import alembic_config, head_revision, is_current, upgrade_to_head
from tests.server.store.backups.writing_campus import a_database, numbers, set_revision, written_meanwhile
from tests.server.store.test_database_file import used_by_another_process

NOW = datetime(2026, 9, 1, 8, tzinfo=UTC)
KEPT = "campusloop.db.before-20260901T080000Z"


def a_backup(folder: Path, rows: int = 1) -> Path:
    back_up(a_database(folder / "source.db", rows), folder / "backup.db")
    return folder / "backup.db"


def test_a_backup_while_a_writer_writes_has_every_row_acknowledged_before_and_no_gap(tmp_path: Path) -> None:
    with written_meanwhile(tmp_path / "campusloop.db") as writer:
        before = writer.wait_for(50)
        back_up(tmp_path / "campusloop.db", tmp_path / "backup.db")
        writer.wait_for(writer.acknowledged + 10)  # the backup has not stopped the writer
    restore(tmp_path / "backup.db", tmp_path / "new" / "campusloop.db", NOW, replace=False)
    restored = numbers(tmp_path / "new" / "campusloop.db")
    assert len(restored) >= before
    assert restored == list(range(len(restored)))


def test_a_backup_is_one_file_that_only_its_user_may_read_and_counts_its_rows(tmp_path: Path) -> None:
    contents = back_up(a_database(tmp_path / "campusloop.db"), tmp_path / "backup.db")
    assert (tmp_path / "backup.db").stat().st_mode & 0o077 == 0
    assert [path.name for path in tmp_path.glob("*backup.db*")] == ["backup.db"]
    assert contents.revision == head_revision()
    assert contents.rows["rides"] == 0


def test_an_existing_file_is_never_overwritten_by_a_backup(tmp_path: Path) -> None:
    (tmp_path / "backup.db").write_bytes(b"last year's")
    with pytest.raises(BackupRefused, match="another name"):
        back_up(a_database(tmp_path / "campusloop.db"), tmp_path / "backup.db")
    assert (tmp_path / "backup.db").read_bytes() == b"last year's"


def damage(path: Path) -> None:
    """Overwrite a page in the middle."""
    with path.open("r+b") as file:
        file.seek(8 * 4096)
        file.write(b"\xff" * 4096)


def test_a_damaged_database_gives_no_backup_and_leaves_no_draft(tmp_path: Path) -> None:
    damage(a_database(tmp_path / "campusloop.db"))
    with pytest.raises(BackupRefused, match=r"damaged|malformed"):
        back_up(tmp_path / "campusloop.db", tmp_path / "to.db")
    assert not list(tmp_path.glob("*to.db*"))


def truncated(folder: Path) -> Path:
    path = a_backup(folder)
    os.truncate(path, path.stat().st_size // 2)
    return path


def empty(folder: Path) -> Path:
    (folder / "backup.db").touch()
    return folder / "backup.db"


def a_text(folder: Path) -> Path:
    (folder / "backup.db").write_text("not a database\n" * 500)
    return folder / "backup.db"


def another_programs(folder: Path) -> Path:
    with closing(sqlite3.connect(folder / "backup.db")) as made:
        made.execute("CREATE TABLE bookmarks (url TEXT)")
    return folder / "backup.db"


def of_a_newer_version(folder: Path) -> Path:
    set_revision(path := a_backup(folder), "9999")
    return path


def without_a_table(folder: Path) -> Path:
    with closing(sqlite3.connect(path := a_backup(folder))) as connection:
        connection.execute("DROP TABLE rides")
    return path


def copied_with_its_log(folder: Path) -> Path:
    path = a_backup(folder)
    path.with_name("backup.db-wal").write_bytes(b"a part of the rows")
    return path


def missing(folder: Path) -> Path:
    return folder / "backup.db"


@pytest.mark.parametrize(
    ("made", "reason"),
    [
        (truncated, "malformed|damaged|disk image"),
        (empty, "not a Campusloop database"),
        (a_text, "not a database"),
        (another_programs, "not a Campusloop database"),
        (of_a_newer_version, "9999, which this version does not know"),
        (without_a_table, "lacks the tables rides"),
        (copied_with_its_log, "campusloop backup"),
        (missing, "is not a file"),
    ],
)
def test_what_is_no_backup_is_refused_and_the_database_untouched(
    tmp_path: Path, made: object, reason: str
) -> None:
    assert callable(made)
    (tmp_path / "var").mkdir()
    target = a_database(tmp_path / "var" / "campusloop.db", rows=3)
    before = {path.name: path.read_bytes() for path in (tmp_path / "var").iterdir()}
    with pytest.raises(RestoreRefused, match=reason):
        restore(made(tmp_path), target, NOW, replace=True)
    assert {path.name: path.read_bytes() for path in (tmp_path / "var").iterdir()} == before


def test_a_restore_refuses_while_a_server_has_the_database_and_names_its_process(tmp_path: Path) -> None:
    target = a_database(tmp_path / "campusloop.db", rows=3)
    with (
        used_by_another_process(target) as holder,
        pytest.raises(RestoreRefused, match=rf"process {holder.pid}\); stop it"),
    ):
        restore(a_backup(tmp_path), target, NOW, replace=True)
    assert numbers(target) == [0, 1, 2]


def test_an_existing_database_is_replaced_only_when_told(tmp_path: Path) -> None:
    target = a_database(tmp_path / "campusloop.db", rows=3)
    with pytest.raises(RestoreRefused, match="--replace"):
        restore(a_backup(tmp_path), target, NOW, replace=False)
    assert numbers(target) == [0, 1, 2]


def test_a_replaced_database_is_kept_with_the_rows_of_its_log(tmp_path: Path) -> None:
    """As a killed server leaves it: the newest rows are in the log, not in the database's own file."""
    (tmp_path / "live").mkdir()
    live = a_database(tmp_path / "live" / "campusloop.db", rows=3)
    target = tmp_path / "campusloop.db"
    with closing(sqlite3.connect(live)) as killed:
        killed.execute("INSERT INTO counters VALUES ('c', '3', 3)")
        killed.commit()
        for side in ("", "-wal"):
            shutil.copy(f"{live}{side}", f"{target}{side}")
    restored = restore(a_backup(tmp_path, rows=7), target, NOW, replace=True)
    assert restored.kept == tmp_path / KEPT
    assert numbers(target) == list(range(7))
    assert numbers(tmp_path / KEPT) == [0, 1, 2, 3]


def test_a_log_without_a_database_is_not_applied_to_the_restored_one(tmp_path: Path) -> None:
    target = tmp_path / "campusloop.db"
    target.with_name("campusloop.db-wal").write_bytes(b"of a database that was deleted")
    restore(a_backup(tmp_path, rows=7), target, NOW, replace=False)
    assert not target.with_name("campusloop.db-wal").exists()
    assert (tmp_path / f"{KEPT}-wal").read_bytes() == b"of a database that was deleted"


def test_a_backup_of_an_earlier_version_is_restored_and_migrated_at_the_start(tmp_path: Path) -> None:
    engine = open_engine(f"sqlite:///{tmp_path}/old.db")
    config = alembic_config()
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.upgrade(config, "0005")
    engine.dispose()
    back_up(tmp_path / "old.db", tmp_path / "backup.db")
    restored = restore(tmp_path / "backup.db", tmp_path / "campusloop.db", NOW, replace=False)
    assert restored.contents.revision == "0005"
    assert not restored.contents.is_current
    engine = open_engine(f"sqlite:///{tmp_path}/campusloop.db")
    upgrade_to_head(engine)
    assert is_current(engine)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can make files that the server cannot open")
def test_root_does_not_restore_into_the_folder_of_another_user(tmp_path: Path) -> None:
    backup = a_backup(tmp_path)
    (tmp_path / "var").mkdir()
    os.chown(tmp_path / "var", 4321, -1)
    with pytest.raises(RestoreRefused, match="user 4321"):
        restore(backup, tmp_path / "var" / "campusloop.db", NOW, replace=False)
    assert not list((tmp_path / "var").iterdir())

"""One server for an SQLite file: a second one is refused for as long as the first one's process lives."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from server.store.database_file import DatabaseFile, DatabaseInUse, database_file
from server.store.engine import open_engine
from tests.server.usecases.fresh_database import write_fresh_database

_HOLD = """import sys
from pathlib import Path
from server.store.database_file import DatabaseFile
file = DatabaseFile(Path(sys.argv[1]))
file.lock()
print("locked", flush=True)
sys.stdin.read()"""


@contextmanager
def used_by_another_process(path: Path) -> Iterator["subprocess.Popen[bytes]"]:
    holder = subprocess.Popen(
        [sys.executable, "-c", _HOLD, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    try:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"locked\n"
        yield holder
    finally:
        holder.kill()
        holder.communicate(timeout=30.0)


def test_a_second_process_is_told_who_uses_the_database_and_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "campusloop.db"
    with used_by_another_process(path) as holder, pytest.raises(DatabaseInUse) as refused:
        DatabaseFile(path).lock()
    assert f"process {holder.pid}" in str(refused.value)
    assert "CAMPUSLOOP_VAR_DIR" in str(refused.value)


def test_another_name_of_the_same_file_is_refused_too(tmp_path: Path) -> None:
    path = tmp_path / "campusloop.db"
    write_fresh_database(path)
    (tmp_path / "link.db").symlink_to(path)
    with used_by_another_process(path), pytest.raises(DatabaseInUse):
        DatabaseFile(tmp_path / "link.db").lock()


def test_a_copy_put_in_the_place_of_an_open_database_is_still_locked(tmp_path: Path) -> None:
    path = tmp_path / "campusloop.db"
    write_fresh_database(path)
    with used_by_another_process(path):
        write_fresh_database(tmp_path / "copy.db")
        (tmp_path / "copy.db").replace(path)
        with pytest.raises(DatabaseInUse):
            DatabaseFile(path).lock()


def test_the_lock_ends_with_its_process_however_that_ends(tmp_path: Path) -> None:
    path = tmp_path / "campusloop.db"
    with used_by_another_process(path) as holder:
        holder.kill()
        holder.wait(timeout=30.0)
        file = DatabaseFile(path)
        file.lock()
    file.close()
    again = DatabaseFile(path)
    again.lock()
    again.close()


def test_only_a_database_in_a_file_has_a_lock(tmp_path: Path) -> None:
    assert database_file(open_engine("sqlite://")) is None
    assert database_file(open_engine("postgresql://nowhere/campus")) is None
    assert database_file(open_engine(f"sqlite:///{tmp_path}/campusloop.db")) is not None

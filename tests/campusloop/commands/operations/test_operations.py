"""`campusloop backup`, `restore` and `doctor` from the outside."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from tests.server.store.backups.writing_campus import a_database, numbers, written_meanwhile
from tests.server.store.test_database_file import used_by_another_process

RUN = CliRunner()
APP = app_of(("backup", "restore", "doctor"))


@pytest.fixture
def var_dir(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("CAMPUSLOOP_VAR_DIR", str(tmp_path / "var"))
    (tmp_path / "var").mkdir()
    return tmp_path / "var"


def test_the_database_of_the_settings_is_backed_up_while_written_and_restored_elsewhere(
    tmp_path: Path, var_dir: Path
) -> None:
    backup, elsewhere = tmp_path / "backup.db", tmp_path / "elsewhere.db"
    with written_meanwhile(var_dir / "campusloop.db") as writer:
        before = writer.wait_for(20)
        done = RUN.invoke(APP, ["backup", "--to", str(backup)])
    assert done.exit_code == 0, done.output
    assert "verified backup" in done.output
    assert "rides 0" in done.output
    done = RUN.invoke(APP, ["restore", "--from", str(backup), "--database", f"sqlite:///{elsewhere}"])
    assert done.exit_code == 0, done.output
    assert len(numbers(elsewhere)) >= before


def test_a_restore_under_a_running_server_ends_with_2_and_changes_nothing(
    tmp_path: Path, var_dir: Path
) -> None:
    database = a_database(var_dir / "campusloop.db", rows=3)
    assert RUN.invoke(APP, ["backup", "--to", str(tmp_path / "backup.db")]).exit_code == 0
    with used_by_another_process(database):
        done = RUN.invoke(APP, ["restore", "--from", str(tmp_path / "backup.db"), "--replace"])
    assert done.exit_code == 2
    assert "stop it" in done.output
    assert numbers(database) == [0, 1, 2]


def test_on_postgresql_a_restore_names_the_program_to_use() -> None:
    arguments = ["restore", "--from", "b", "--database", "postgresql://u:hush@127.0.0.1:1/x"]
    done = RUN.invoke(APP, arguments)
    assert done.exit_code == 2
    assert "pg_restore" in done.output
    assert "hush" not in done.output


def test_the_doctor_ends_with_1_and_one_line_for_each_check(var_dir: Path) -> None:
    done = RUN.invoke(APP, ["doctor", "--map", "nowhere.json", "--port", "0"])
    assert done.exit_code == 1
    lines = done.output.splitlines()
    assert len(lines) == 14
    assert any(line.startswith("bad     map       nowhere.json") and " -> " in line for line in lines)


def test_the_doctor_gives_programs_the_same_findings(var_dir: Path) -> None:
    done = RUN.invoke(APP, ["doctor", "--map", "nowhere.json", "--port", "0", "--json"])
    assert done.exit_code == 1
    states = {finding["check"]: finding["state"] for finding in json.loads(done.output)}
    assert states["map"] == "bad"
    assert states["folder"] == "good"

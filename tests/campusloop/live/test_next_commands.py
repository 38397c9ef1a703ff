"""The commands that a demo leaves behind."""

from pathlib import Path

from campusloop.live.next_commands import DEMO_FOLDER, next_commands


def test_the_demo_of_make_leaves_commands_as_it_was_called() -> None:
    assert next_commands(DEMO_FOLDER / "none", None, ".venv/bin/campusloop") == []
    lines = next_commands(DEMO_FOLDER, "ABC234", ".venv/bin/campusloop")
    assert lines[-1].endswith(": .venv/bin/campusloop dispatch explain ABC234")


def test_another_folder_is_named_and_quoted_with_its_database(tmp_path: Path) -> None:
    folder = tmp_path / "my demo"
    run = folder / "agents" / "shuttle-1" / "boot" / "0000.mcap"
    run.parent.mkdir(parents=True)
    run.touch()
    view, explain = next_commands(folder, "ABC234", "/usr/lib/python3/campusloop/__main__.py")
    assert view == f"replay in the browser: campusloop view '{folder}'"
    assert explain.endswith(
        f"campusloop dispatch explain ABC234 --database 'sqlite:///{folder}/campusloop.db'"
    )

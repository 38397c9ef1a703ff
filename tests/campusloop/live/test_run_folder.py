from pathlib import Path

import pytest

from campusloop.live.run_folder import ForeignFolder, empty_folder


def test_an_earlier_demos_folder_is_emptied(tmp_path: Path) -> None:
    folder = empty_folder(tmp_path / "runs")
    (folder / "old.mcap").touch()
    assert empty_folder(folder) == folder
    assert not (folder / "old.mcap").exists()


def test_somebody_elses_folder_is_left_alone(tmp_path: Path) -> None:
    thesis = tmp_path / "thesis.tex"
    thesis.touch()
    with pytest.raises(ForeignFolder, match="--folder"):
        empty_folder(tmp_path)
    assert thesis.exists()

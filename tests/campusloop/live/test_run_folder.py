from pathlib import Path

import pytest

from campusloop.live.run_folder import NotOurFolder, emptied


def test_an_earlier_demos_folder_is_emptied(tmp_path: Path) -> None:
    folder = emptied(tmp_path / "runs")
    (folder / "old.mcap").touch()
    assert emptied(folder) == folder
    assert not (folder / "old.mcap").exists()


def test_somebody_elses_folder_is_left_alone(tmp_path: Path) -> None:
    thesis = tmp_path / "thesis.tex"
    thesis.touch()
    with pytest.raises(NotOurFolder, match="--folder"):
        emptied(tmp_path)
    assert thesis.exists()

from pathlib import Path

import pytest

from campusloop.live.run_viewer import RunViewError, ViewedRun, runs_in
from tests.contract.runlog.test_segment import write_segment


def test_every_segment_below_a_folder_is_found_with_whose_it_is(tmp_path: Path) -> None:
    deep = tmp_path / "snow_lion" / "runs" / "0000.mcap"
    write_segment(deep, 20)
    assert runs_in((tmp_path,)) == (ViewedRun(deep, "shuttle-1", "boot-1"),)
    assert runs_in((deep,)) == runs_in((tmp_path,))


def test_an_empty_folder_and_a_file_that_is_no_run_log_are_named(tmp_path: Path) -> None:
    with pytest.raises(RunViewError, match="no run logs"):
        runs_in((tmp_path,))
    (tmp_path / "other.mcap").write_bytes(b"not a run")
    with pytest.raises(RunViewError, match=r"other\.mcap"):
        runs_in((tmp_path,))

from pathlib import Path

import pytest

from contract.runlog.extent import extent
from contract.runlog.reader import RunLogError, open_segment
from tests.contract.runlog.test_segment import UTC_OFFSET_NS, write_segment


def test_extent_reads_the_summary_or_as_far_as_the_file_is_sound(tmp_path: Path) -> None:
    whole, cut = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    write_segment(whole, 4000)
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size * 2 // 3])
    assert open_segment(cut).header == open_segment(whole).header
    assert extent(whole) == (UTC_OFFSET_NS + 20_000_000, UTC_OFFSET_NS + 4000 * 20_000_000)
    first_ns, last_ns = extent(cut)
    assert first_ns == UTC_OFFSET_NS + 20_000_000
    assert first_ns < last_ns < UTC_OFFSET_NS + 4000 * 20_000_000
    with pytest.raises(RunLogError):
        extent(tmp_path / "missing.mcap")

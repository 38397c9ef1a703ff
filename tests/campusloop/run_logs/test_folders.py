"""Which runs are found in a folder, and how one of them is named."""

import hashlib
import shutil
from pathlib import Path

import msgspec
import pytest
import zstandard

from campusloop.run_logs.folders import RunNotFound, one_run, runs_found
from contract.runlog.reader import RunLogError
from contract.runlog.records import REPORT_TOPIC
from contract.runlog.writer import SegmentWriter
from contract.wire.codec import encode
from tests.contract.runlog.test_segment import UTC_OFFSET_NS, a_header, a_status, write_segment


def write_number(folder: Path, number: int, boot_id: str = "boot-1", begin_ns: int = 0) -> Path:
    """A segment of two seconds with reports only, after those of lower numbers."""
    path = folder / f"{number:04d}.mcap"
    header = msgspec.structs.replace(a_header(), segment=number, boot_id=boot_id)
    writer = SegmentWriter(path, header, b"state", b"profile", zstandard.compress(b"{}"))
    for report in range(11):
        stamp_ns = begin_ns + (number * 2_000 + report * 200) * 1_000_000
        writer.add(REPORT_TOPIC, stamp_ns, encode(a_status(stamp_ns)))
    writer.close()
    return path


def copied_by_a_server(segment: Path, store: Path) -> Path:
    sha256 = hashlib.sha256(segment.read_bytes()).hexdigest()
    copy = store / sha256[:2] / f"{sha256}.mcap"
    copy.parent.mkdir(parents=True)
    return Path(shutil.copy(segment, copy))


def test_segments_of_a_boot_are_one_run_and_the_newest_run_comes_first(tmp_path: Path) -> None:
    old = [write_number(tmp_path / "boot-1", number) for number in (0, 1)]
    new = [write_number(tmp_path / "boot-2", 0, "boot-2", begin_ns=60_000_000_000)]
    newest, oldest = runs_found(tmp_path).runs
    assert (newest.name, list(newest.paths)) == ("shuttle-1/boot-2", new)
    assert (oldest.name, list(oldest.paths)) == ("shuttle-1/boot-1", old)
    assert oldest.first_ns == UTC_OFFSET_NS
    assert oldest.duration_s == 4.0
    assert oldest.missing_numbers == ()


def test_a_segment_that_is_not_there_is_missing(tmp_path: Path) -> None:
    for number in (2, 5):
        write_number(tmp_path, number)
    (run,) = runs_found(tmp_path).runs
    assert run.missing_numbers == (3, 4)


def test_equal_names_in_two_folders_are_two_runs_and_are_named_by_their_folders(tmp_path: Path) -> None:
    for folder in ("one", "two"):
        write_number(tmp_path / folder, 0)
    assert len(runs_found(tmp_path).runs) == 2
    with pytest.raises(RunNotFound) as refusal:
        one_run("shuttle-1/boot-1", tmp_path)
    assert str(tmp_path / "one") in str(refusal.value)
    run, _ = one_run(str(tmp_path / "two"), tmp_path)
    assert run.folder == tmp_path / "two"


def test_the_servers_copies_are_told_only_where_the_vehicles_files_are_not(tmp_path: Path) -> None:
    segments = [write_number(tmp_path / "vehicle", number) for number in (0, 1)]
    copies = [copied_by_a_server(segment, tmp_path / "segments") for segment in segments]
    (run,) = runs_found(tmp_path).runs
    assert list(run.paths) == segments
    (stored,) = runs_found(tmp_path / "segments").runs
    assert list(stored.paths) == copies
    segments[1].unlink()
    both = runs_found(tmp_path).runs
    assert sorted(len(run.segments) for run in both) == [1, 2]


def test_a_file_that_cannot_be_used_is_named_and_hides_no_run(tmp_path: Path) -> None:
    write_number(tmp_path, 0)
    other = tmp_path / "0001.mcap"
    other.write_bytes(b"no run")
    found = runs_found(tmp_path)
    assert len(found.runs) == 1
    assert found.unreadable[other].code == "not_a_run"
    run, unreadable = one_run("shuttle-1/boot-1", tmp_path)
    assert run.paths == (tmp_path / "0000.mcap",)
    assert [error.code for error in unreadable] == ["not_a_run"]
    with pytest.raises(RunLogError, match=r"0001\.mcap"):
        one_run(str(other), tmp_path)


def test_a_segment_that_a_kill_cut_short_reaches_as_far_as_it_is_sound(tmp_path: Path) -> None:
    whole, cut = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    write_segment(whole, 3_000)
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    (of_whole,), (of_cut,) = runs_found(whole).runs, runs_found(cut).runs
    assert 10.0 < of_cut.duration_s < of_whole.duration_s - 10.0


def test_what_is_not_there_is_refused_with_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(RunNotFound, match="name a folder with run logs"):
        runs_found(tmp_path / "nowhere")
    with pytest.raises(RunNotFound, match="no run logs"):
        runs_found(tmp_path)
    write_number(tmp_path, 0)
    with pytest.raises(RunNotFound, match="campusloop runs list"):
        one_run("shuttle-2/boot-1", tmp_path)

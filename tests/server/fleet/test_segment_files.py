"""Run segments on the server's disk: whole and proven, or not at all."""

import hashlib
from pathlib import Path

import pytest

from server.fleet.segment_files import SegmentFiles, SegmentHashError, SegmentSizeError
from tests.full_disk import full_disk

DATA = b"recorded drive"
SHA256 = hashlib.sha256(DATA).hexdigest()


def test_a_proven_segment_lies_where_its_hash_says(tmp_path: Path) -> None:
    files = SegmentFiles(tmp_path, 100)
    with files.receive(SHA256, "one") as incoming:
        incoming.write(DATA[:5])
        incoming.write(DATA[5:])
        assert not files.has(SHA256), "not before it is proven"
        incoming.prove()
        kept = incoming.keep()
    assert kept == tmp_path / SHA256[:2] / f"{SHA256}.mcap"
    assert kept.read_bytes() == DATA
    assert files.has(SHA256)
    assert list((tmp_path / "incoming").iterdir()) == []


def test_bytes_with_another_hash_are_not_kept(tmp_path: Path) -> None:
    files = SegmentFiles(tmp_path, 100)
    with files.receive(SHA256, "one") as incoming:
        incoming.write(DATA + b"!")
        with pytest.raises(SegmentHashError):
            incoming.prove()
    assert not files.has(SHA256)
    assert list((tmp_path / "incoming").iterdir()) == []


def test_a_segment_may_be_as_large_as_allowed_and_no_larger(tmp_path: Path) -> None:
    files = SegmentFiles(tmp_path, len(DATA))
    with files.receive(SHA256, "one") as incoming:
        incoming.write(DATA)
        incoming.prove()
        with pytest.raises(SegmentSizeError, match=str(len(DATA))):
            incoming.write(b"!")
    assert list((tmp_path / "incoming").iterdir()) == []


def test_on_a_full_disk_nothing_is_kept(tmp_path: Path) -> None:
    files = SegmentFiles(tmp_path, 100)
    incoming = files.receive(SHA256, "one")
    incoming.write(DATA)
    with full_disk(), pytest.raises(OSError, match="File too large"):
        incoming.prove()
    assert not files.has(SHA256)


def test_two_uploads_of_one_segment_at_once_do_not_disturb_each_other(tmp_path: Path) -> None:
    files = SegmentFiles(tmp_path, 100)
    with files.receive(SHA256, "one") as first, files.receive(SHA256, "two") as second:
        for incoming in (first, second):
            incoming.write(DATA)
        for incoming in (first, second):
            incoming.prove()
            assert incoming.keep().read_bytes() == DATA

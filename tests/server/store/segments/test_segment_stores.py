"""Run segments: whole and proven, or not at all, whether they lie in a folder or in an object store."""

import hashlib
import os
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from obstore.store import MemoryStore

from server.store.segments.bucket import CACHE_AGE_S_MIN, SegmentBucket, open_bucket
from server.store.segments.choice import open_segment_store, open_tile_store
from server.store.segments.folder import SegmentFolder
from server.store.segments.incoming import SegmentHashError, SegmentSizeError
from server.store.segments.segment_store import SegmentStore, SegmentStoreError
from tests.full_disk import full_disk

DATA = b"recorded drive"
SHA256 = hashlib.sha256(DATA).hexdigest()
NewStore = Callable[[int], SegmentStore]


@pytest.fixture(params=["folder", "bucket"])
def new_store(request: pytest.FixtureRequest, tmp_path: Path) -> NewStore:
    """Makes a store for segments of at most so many bytes."""
    if request.param == "folder":
        return lambda bytes_max: SegmentFolder(tmp_path, bytes_max)
    return lambda bytes_max: SegmentBucket(MemoryStore(), tmp_path, bytes_max)


def put(store: SegmentStore, data: bytes) -> str:
    sha256 = hashlib.sha256(data).hexdigest()
    with store.receive(sha256, f"upload-{sha256[:8]}") as incoming:
        incoming.write(data)
        incoming.prove()
        store.keep(incoming)
    return sha256


def left_over(folder: Path) -> list[Path]:
    return list((folder / "incoming").iterdir())


def test_a_proven_segment_is_kept_and_comes_back(new_store: NewStore, tmp_path: Path) -> None:
    store = new_store(100)
    with store.receive(SHA256, "one") as incoming:
        incoming.write(DATA[:5])
        incoming.write(DATA[5:])
        assert not store.has(SHA256), "not before it is proven"
        assert store.fetch(SHA256) is None
        incoming.prove()
        store.keep(incoming)
    for _ in range(2):
        path = store.fetch(SHA256)
        assert path is not None
        assert path.read_bytes() == DATA
    assert store.has(SHA256)
    assert left_over(tmp_path) == []


def test_bytes_with_another_hash_are_not_kept(new_store: NewStore, tmp_path: Path) -> None:
    store = new_store(100)
    with store.receive(SHA256, "one") as incoming:
        incoming.write(DATA + b"!")
        with pytest.raises(SegmentHashError):
            incoming.prove()
    assert not store.has(SHA256)
    assert left_over(tmp_path) == []


def test_a_segment_may_be_as_large_as_allowed_and_no_larger(new_store: NewStore, tmp_path: Path) -> None:
    store = new_store(len(DATA))
    with store.receive(SHA256, "one") as incoming:
        incoming.write(DATA)
        incoming.prove()
        with pytest.raises(SegmentSizeError, match=str(len(DATA))):
            incoming.write(b"!")
    assert left_over(tmp_path) == []


def test_on_a_full_disk_nothing_is_kept(new_store: NewStore) -> None:
    store = new_store(100)
    incoming = store.receive(SHA256, "one")
    incoming.write(DATA)
    with full_disk(), pytest.raises(OSError, match="File too large"):
        incoming.prove()
    assert not store.has(SHA256)


def test_two_uploads_of_one_segment_at_once_do_not_disturb_each_other(new_store: NewStore) -> None:
    store = new_store(100)
    with store.receive(SHA256, "one") as first, store.receive(SHA256, "two") as second:
        for incoming in (first, second):
            incoming.write(DATA)
        for incoming in (first, second):
            incoming.prove()
            store.keep(incoming)
            path = store.fetch(SHA256)
            assert path is not None
            assert path.read_bytes() == DATA


def test_two_replicas_with_one_bucket_have_the_same_segments(tmp_path: Path) -> None:
    bucket = MemoryStore()
    one, other = (SegmentBucket(bucket, tmp_path / name, 100) for name in ("one", "other"))
    put(one, DATA)
    path = other.fetch(SHA256)
    assert path is not None
    assert path.read_bytes() == DATA


def test_an_object_that_was_changed_in_the_bucket_is_not_shown(tmp_path: Path) -> None:
    bucket = MemoryStore()
    store = SegmentBucket(bucket, tmp_path, 100)
    put(store, DATA)
    bucket.put(f"{SHA256[:2]}/{SHA256}.mcap", b"another drive!")
    with pytest.raises(SegmentStoreError, match="hash"):
        store.fetch(SHA256)
    assert left_over(tmp_path) == []


def test_the_cache_forgets_what_was_not_used_for_long_and_fetches_it_again(tmp_path: Path) -> None:
    store = SegmentBucket(MemoryStore(), tmp_path, 100, cache_bytes_max=25)
    old, used, new = (put(store, bytes([number]) * 10) for number in range(3))
    paths = {}
    for name in (old, used):
        paths[name] = store.fetch(name)
        assert paths[name] is not None
        long_ago_s = time.time() - 2 * CACHE_AGE_S_MIN
        os.utime(paths[name], (long_ago_s, long_ago_s))
    store.fetch(used)
    store.fetch(new)
    assert not paths[old].exists()
    assert paths[used].exists()
    assert store.fetch(old) is not None


def test_a_bucket_out_of_reach_is_named_as_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:9")
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "key")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "secret")
    store = open_bucket("s3://campus/runs", tmp_path, 100)
    with pytest.raises(SegmentStoreError, match=r"127\.0\.0\.1:9/.*error sending") as refusal:
        store.has(SHA256)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("url", ["nonsense://x", "segments", "s3:"])
def test_a_url_that_names_no_store_is_refused(url: str, tmp_path: Path) -> None:
    with pytest.raises(SegmentStoreError):
        open_segment_store(url, tmp_path, 100)


def test_without_a_url_segments_lie_under_var_dir_and_a_file_url_names_another_folder(tmp_path: Path) -> None:
    put(open_segment_store("", tmp_path / "var", 100), DATA)
    put(open_segment_store(f"file://{tmp_path}/shared", tmp_path / "var", 100), DATA)
    for folder in ("var/segments", "shared"):
        assert (tmp_path / folder / SHA256[:2] / f"{SHA256}.mcap").read_bytes() == DATA


def test_what_is_removed_is_gone_from_store_and_cache_and_can_come_again(new_store: NewStore) -> None:
    store = new_store(100)
    put(store, DATA)
    assert store.fetch(SHA256) is not None
    for _ in range(2):
        store.remove(SHA256)
        assert not store.has(SHA256)
        assert store.fetch(SHA256) is None
    put(store, DATA)
    assert store.has(SHA256)


def test_tiles_of_localization_maps_lie_beside_the_segments(tmp_path: Path) -> None:
    put(open_tile_store("", tmp_path / "var"), DATA)
    put(open_tile_store(f"file://{tmp_path}/shared", tmp_path / "var"), DATA)
    for folder in ("var/localization-tiles", "shared/localization-tiles"):
        assert (tmp_path / folder / SHA256[:2] / f"{SHA256}.tile").read_bytes() == DATA
    with pytest.raises(SegmentStoreError):
        open_tile_store("nonsense://x", tmp_path)

"""Segments in an object store (S3, Google Cloud Storage, Azure), which every replica reaches."""

import os
import time
from datetime import timedelta
from pathlib import Path
from uuid import uuid4

import obstore
from obstore.exceptions import BaseError
from obstore.store import ObjectStore

from server.store.segments.incoming import IncomingSegment, SegmentHashError, SegmentSizeError
from server.store.segments.segment_store import SEGMENT_ENDING, SegmentStoreError, key_of

# The vehicle tries again after 20 s, so a request does not wait longer than that for a store that is away.
_CONNECT_TIMEOUT_S = 5
_RETRY_TIMEOUT_S = 15
_PIECE_BYTES_MIN = 256 * 1024
CACHE_BYTES_MAX = 4 << 30
# A file that was fetched may not have been opened yet, or is being sent.
CACHE_AGE_S_MIN = 600.0


class SegmentBucket:
    """Objects `ab/abcdef....mcap`.

    `folder` has the uploads until their hash is checked (`incoming/`), and copies of the segments that were
    used last (`cache/`). It may be lost at any time.
    """

    def __init__(
        self,
        store: ObjectStore,
        folder: Path,
        bytes_max: int,
        cache_bytes_max: int = CACHE_BYTES_MAX,
        ending: str = SEGMENT_ENDING,
    ) -> None:
        self._store = store
        self._ending = ending
        self._incoming, self._cache = folder / "incoming", folder / "cache"
        self._bytes_max = bytes_max
        self._cache_bytes_max = cache_bytes_max

    def receive(self, sha256: str, name: str) -> IncomingSegment:
        return IncomingSegment(sha256, self._incoming / f"{name}.part", self._bytes_max)

    def has(self, sha256: str) -> bool:
        try:
            obstore.head(self._store, key_of(sha256, self._ending))
        except FileNotFoundError:
            return False
        except (BaseError, OSError) as error:
            raise _unusable(error) from error
        return True

    def keep(self, incoming: IncomingSegment) -> None:
        try:
            obstore.put(self._store, key_of(incoming.sha256, self._ending), incoming.path)
        except (BaseError, OSError) as error:
            raise _unusable(error) from error

    def fetch(self, sha256: str) -> Path | None:
        path = self._cache / key_of(sha256, self._ending)
        try:
            os.utime(path)
        except FileNotFoundError:
            return path if self._download(sha256, path) else None
        return path

    def remove(self, sha256: str) -> None:
        try:
            obstore.delete(self._store, key_of(sha256, self._ending))
        except FileNotFoundError:
            pass  # S3 does not tell, other stores do.
        except (BaseError, OSError) as error:
            raise _unusable(error) from error
        (self._cache / key_of(sha256, self._ending)).unlink(missing_ok=True)

    def _download(self, sha256: str, path: Path) -> bool:
        try:
            found = obstore.get(self._store, key_of(sha256, self._ending))
            size_bytes = found.meta["size"]
            # Two requests may fetch one segment at the same time.
            with IncomingSegment(sha256, self._incoming / f"{uuid4().hex}.part", size_bytes) as copy:
                for piece in found.stream(min_chunk_size=_PIECE_BYTES_MIN):
                    copy.write(bytes(piece))
                copy.prove()
                self._evict(size_bytes)
                path.parent.mkdir(parents=True, exist_ok=True)
                os.replace(copy.path, path)
        except FileNotFoundError:
            return False
        except (BaseError, OSError, SegmentHashError, SegmentSizeError) as error:
            raise _unusable(error) from error
        return True

    def _evict(self, size_bytes: int) -> None:
        """Make room for a file: delete those that were not used for the longest time."""
        files = sorted(
            ((found.st_mtime, found.st_size, path) for path, found in _present(self._cache, self._ending)),
            key=lambda file: file[0],
        )
        too_many = sum(size for _, size, _ in files) + size_bytes - self._cache_bytes_max
        now_s = time.time()
        for used_s, size, path in files:
            if too_many <= 0 or now_s - used_s < CACHE_AGE_S_MIN:
                return
            path.unlink(missing_ok=True)
            too_many -= size


def open_bucket(url: str, folder: Path, bytes_max: int, ending: str = SEGMENT_ENDING) -> SegmentBucket:
    """The bucket that a URL names: s3://BUCKET/PREFIX, gs://, az://.

    Credentials, region and endpoint come from the environment by the cloud's own names (AWS_ACCESS_KEY_ID,
    AWS_ENDPOINT_URL, GOOGLE_SERVICE_ACCOUNT, AZURE_STORAGE_ACCOUNT_KEY, ...). It connects at its first use.
    Raises SegmentStoreError for a URL that cannot be used.
    """
    try:
        store = obstore.store.from_url(
            url,
            # The clouds' own endpoints are HTTPS; another one is as the environment names it.
            client_options={"connect_timeout": timedelta(seconds=_CONNECT_TIMEOUT_S), "allow_http": True},
            retry_config={"max_retries": 3, "retry_timeout": timedelta(seconds=_RETRY_TIMEOUT_S)},
        )
    except (BaseError, ValueError, TypeError) as error:
        # The library's message has the whole URL, which may have a password in it.
        raise SegmentStoreError("it names no object store: s3://, gs:// or az://BUCKET/PREFIX") from error
    return SegmentBucket(store, folder, bytes_max, ending=ending)


def _present(folder: Path, ending: str) -> list[tuple[Path, os.stat_result]]:
    found = []
    for path in folder.glob(f"*/*{ending}"):
        try:
            found.append((path, path.stat()))
        except FileNotFoundError:
            continue  # Another request has evicted it.
    return found


def _unusable(error: BaseException) -> SegmentStoreError:
    return SegmentStoreError(f"the store is not usable now: {_first_line(error)}")


def _first_line(error: BaseException) -> str:
    """The library's messages go on with a dump of the error's structure."""
    return str(error).strip().split("\n", 1)[0]

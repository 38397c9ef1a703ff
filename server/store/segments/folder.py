"""Segments in a folder, for one server, or on a disk that all replicas share."""

import os
from pathlib import Path

from server.store.segments.incoming import IncomingSegment
from server.store.segments.segment_store import SEGMENT_ENDING, key_of


class SegmentFolder:
    """Files `ab/abcdef....mcap`. Uploads are in `incoming/` until their hash is checked."""

    def __init__(self, folder: Path, bytes_max: int, ending: str = SEGMENT_ENDING) -> None:
        self._folder = folder
        self._ending = ending
        self._bytes_max = bytes_max

    def receive(self, sha256: str, name: str) -> IncomingSegment:
        return IncomingSegment(sha256, self._folder / "incoming" / f"{name}.part", self._bytes_max)

    def has(self, sha256: str) -> bool:
        return self._path(sha256).exists()

    def keep(self, incoming: IncomingSegment) -> None:
        target = self._path(incoming.sha256)
        target.parent.mkdir(parents=True, exist_ok=True)
        os.replace(incoming.path, target)
        # The vehicle deletes its copy after the answer: the name must outlive a power cut too.
        _sync_folder(target.parent)

    def fetch(self, sha256: str) -> Path | None:
        path = self._path(sha256)
        return path if path.exists() else None

    def remove(self, sha256: str) -> None:
        self._path(sha256).unlink(missing_ok=True)

    def _path(self, sha256: str) -> Path:
        return self._folder / key_of(sha256, self._ending)


def _sync_folder(folder: Path) -> None:
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)

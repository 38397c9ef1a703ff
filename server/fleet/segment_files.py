"""Run segments as files named by the hash of their content. No file is overwritten."""

import hashlib
import os
from pathlib import Path


class SegmentHashError(Exception):
    """The bytes received do not have the promised hash."""


class SegmentSizeError(Exception):
    """More bytes came than a segment may have."""


class SegmentFiles:
    """A folder of segments, `ab/abcdef....mcap`. Uploads are in `incoming/` until their hash is checked."""

    def __init__(self, folder: Path, bytes_max: int) -> None:
        self._folder = folder
        self.bytes_max = bytes_max

    def path(self, sha256: str) -> Path:
        return self._folder / sha256[:2] / f"{sha256}.mcap"

    def has(self, sha256: str) -> bool:
        return self.path(sha256).exists()

    def receive(self, sha256: str, name: str) -> "IncomingSegment":
        """name: unique among the uploads under way."""
        folder = self._folder / "incoming"
        folder.mkdir(parents=True, exist_ok=True)
        return IncomingSegment(self, sha256, folder / f"{name}.part")


class IncomingSegment:
    """An upload under way. As a context manager it removes the file at the end, unless it was kept."""

    def __init__(self, files: SegmentFiles, sha256: str, path: Path) -> None:
        self.path = path
        self.size_bytes = 0
        self._files, self._sha256 = files, sha256
        self._digest = hashlib.sha256()
        self._file = path.open("wb")

    def __enter__(self) -> "IncomingSegment":
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()
        self.path.unlink(missing_ok=True)

    def write(self, data: bytes) -> None:
        """Raises SegmentSizeError."""
        self.size_bytes += len(data)
        if self.size_bytes > self._files.bytes_max:
            raise SegmentSizeError(f"a segment has at most {self._files.bytes_max} bytes")
        self._digest.update(data)
        self._file.write(data)

    def prove(self) -> Path:
        """Flush the file and check its hash; it is still in `incoming/`. Raises SegmentHashError."""
        self._file.flush()
        os.fsync(self._file.fileno())
        if self._digest.hexdigest() != self._sha256:
            raise SegmentHashError(f"the {self.size_bytes} bytes received hash to {self._digest.hexdigest()}")
        return self.path

    def keep(self) -> Path:
        """Move the checked file to its place."""
        target = self._files.path(self._sha256)
        target.parent.mkdir(parents=True, exist_ok=True)
        os.replace(self.path, target)
        return target

"""An upload under way: a file on this machine until its hash is checked."""

import hashlib
import os
from pathlib import Path


class SegmentHashError(Exception):
    """The bytes received do not have the promised hash."""


class SegmentSizeError(Exception):
    """More bytes came than a segment may have."""


class IncomingSegment:
    """A file that is removed at the end of the context, unless it was moved."""

    def __init__(self, sha256: str, path: Path, bytes_max: int) -> None:
        self.sha256 = sha256
        self.path = path
        self.size_bytes = 0
        self._bytes_max = bytes_max
        self._digest = hashlib.sha256()
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = path.open("wb")

    def __enter__(self) -> "IncomingSegment":
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()
        self.path.unlink(missing_ok=True)

    def write(self, data: bytes) -> None:
        """Raises SegmentSizeError."""
        self.size_bytes += len(data)
        if self.size_bytes > self._bytes_max:
            raise SegmentSizeError(f"a segment has at most {self._bytes_max} bytes")
        self._digest.update(data)
        self._file.write(data)

    def prove(self) -> Path:
        """Flush the file and check its hash. Raises SegmentHashError."""
        self._file.flush()
        os.fsync(self._file.fileno())
        if self._digest.hexdigest() != self.sha256:
            raise SegmentHashError(f"the {self.size_bytes} bytes received hash to {self._digest.hexdigest()}")
        return self.path

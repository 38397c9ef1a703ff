"""How much room video may take: the oldest finished segments are deleted for the newest."""

import shutil
from collections.abc import Callable
from pathlib import Path

import structlog

from vehicle_agent.runtime.video.segment_names import segments_in

log = structlog.get_logger()

# Left for run logs and maps, which matter more.
FREE_BYTES_MIN = 2 * 1024 * 1024 * 1024


class DiskRoom:
    """Look every few seconds; `has_room` is what was found. Thread-safe: it only assigns a bool."""

    def __init__(
        self, folder: Path, keep_bytes: int, free_bytes: Callable[[Path], int] | None = None
    ) -> None:
        self._folder, self._keep_bytes = folder, keep_bytes
        self._free_bytes = free_bytes or (lambda path: shutil.disk_usage(path).free)
        self.has_room = True

    def look(self) -> list[str]:
        """Deletes what is too much, oldest first; returns the names of what was deleted."""
        finished = sorted(
            (one for one in segments_in(self._folder) if one.length_ms is not None),
            key=lambda one: (one.utc_ns, one.camera),
        )
        sizes = {one: size_of(self._folder / one.text()) for one in finished}
        total, free, gone = sum(sizes.values()), self._free_bytes(self._folder), []
        for one in finished:
            if total <= self._keep_bytes and free >= FREE_BYTES_MIN:
                break
            (self._folder / one.text()).unlink(missing_ok=True)
            total, free = total - sizes[one], free + sizes[one]
            gone.append(one.text())
        if gone:
            log.info("video.deleted", segments=len(gone), newest=gone[-1])
        self.has_room = free >= FREE_BYTES_MIN
        return gone


def size_of(path: Path) -> int:
    """Bytes; 0 for a file that is gone by now."""
    try:
        return path.stat().st_size
    except FileNotFoundError:
        return 0

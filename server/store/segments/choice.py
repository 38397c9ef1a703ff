"""Which store the settings name."""

from pathlib import Path

from server.store.segments.bucket import open_bucket
from server.store.segments.folder import SegmentFolder
from server.store.segments.segment_store import SegmentStore


def open_segment_store(url: str, var_dir: Path, bytes_max: int) -> SegmentStore:
    """The store at `url`; without one, the folder `segments` of var_dir.

    Raises SegmentStoreError for a URL that cannot be used.
    """
    folder = var_dir / "segments"
    if not url:
        return SegmentFolder(folder, bytes_max)
    if url.startswith("file://"):
        return SegmentFolder(Path(url.removeprefix("file://")), bytes_max)
    return open_bucket(url, folder, bytes_max)

"""Which stores the settings name."""

from pathlib import Path

from contract.localization_manifest import TILE_BYTES_MAX
from server.store.segments.bucket import open_bucket
from server.store.segments.folder import SegmentFolder
from server.store.segments.segment_store import SegmentStore

TILES_FOLDER, TILE_ENDING = "localization-tiles", ".tile"


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


def open_tile_store(url: str, var_dir: Path) -> SegmentStore:
    """Tiles of localization maps: in the folder `localization-tiles` of the segments' URL, or of var_dir.

    Raises SegmentStoreError for a URL that cannot be used.
    """
    folder = var_dir / TILES_FOLDER
    if not url:
        return SegmentFolder(folder, TILE_BYTES_MAX, TILE_ENDING)
    if url.startswith("file://"):
        return SegmentFolder(Path(url.removeprefix("file://")) / TILES_FOLDER, TILE_BYTES_MAX, TILE_ENDING)
    return open_bucket(f"{url.rstrip('/')}/{TILES_FOLDER}", folder, TILE_BYTES_MAX, TILE_ENDING)

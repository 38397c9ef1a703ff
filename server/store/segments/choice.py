"""Which stores the settings name."""

from pathlib import Path

from contract.localization_manifest import TILE_BYTES_MAX
from server.store.segments.bucket import open_bucket
from server.store.segments.folder import SegmentFolder
from server.store.segments.segment_store import SegmentStore

TILES_FOLDER, TILE_ENDING = "localization-tiles", ".tile"
SCANS_FOLDER, SCANS_ENDING = "scans", ".zip"
# A vehicle ends a parcel at 8 MB; the map of a campus, with its picture, has less than this.
SCANS_BYTES_MAX = 512 * 1024 * 1024
VIDEOS_FOLDER, VIDEO_ENDING = "videos", ".webm"
# Five minutes at 5 Mbit/s.
VIDEO_BYTES_MAX = 256 * 1024 * 1024


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
    return _open_beside(url, var_dir, TILES_FOLDER, TILE_BYTES_MAX, TILE_ENDING)


def open_scan_store(url: str, var_dir: Path) -> SegmentStore:
    """Parcels of scans, and the maps proposed of them: in the folder `scans`, as `open_tile_store`."""
    return _open_beside(url, var_dir, SCANS_FOLDER, SCANS_BYTES_MAX, SCANS_ENDING)


def open_video_store(url: str, var_dir: Path) -> SegmentStore:
    """Video segments: in the folder `videos`, as `open_tile_store`."""
    return _open_beside(url, var_dir, VIDEOS_FOLDER, VIDEO_BYTES_MAX, VIDEO_ENDING)


def _open_beside(url: str, var_dir: Path, name: str, bytes_max: int, ending: str) -> SegmentStore:
    folder = var_dir / name
    if not url:
        return SegmentFolder(folder, bytes_max, ending)
    if url.startswith("file://"):
        return SegmentFolder(Path(url.removeprefix("file://")) / name, bytes_max, ending)
    return open_bucket(f"{url.rstrip('/')}/{name}", folder, bytes_max, ending)

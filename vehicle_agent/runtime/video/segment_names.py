"""The segments of a folder: their names are its index (`contract.video`)."""

from pathlib import Path

from contract.video import SegmentName, name_of


def segments_in(folder: Path) -> list[SegmentName]:
    """All segments of a folder, by camera and time. A folder that is not there has none."""
    try:
        files = list(folder.iterdir())
    except FileNotFoundError:
        return []
    names = (name_of(file.name) for file in files)
    return sorted(
        (name for name in names if name is not None), key=lambda one: (one.camera, one.stamp_ns, one.utc_ns)
    )

"""The folder that a demo writes to: emptied at the start, but never somebody else's."""

import shutil
from pathlib import Path

MARKER = "campusloop-demo"


class NotOurFolder(Exception):
    """There is something in the folder that no demo has put there; the message says what to do."""


def emptied(folder: Path) -> Path:
    """The folder, there and empty but for its marker. Raises NotOurFolder."""
    marker = folder / MARKER
    if folder.exists() and any(folder.iterdir()) and not marker.exists():
        raise NotOurFolder(f"{folder} holds files that no demo wrote; name another one with --folder")
    if folder.exists():
        shutil.rmtree(folder)
    folder.mkdir(parents=True)
    marker.touch()
    return folder

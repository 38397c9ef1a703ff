"""The folder that a demo writes to. It is emptied at the start; a folder with other files is refused."""

import shutil
from pathlib import Path

MARKER = "campusloop-demo"


class ForeignFolder(Exception):
    """The folder holds files that no demo has written; the message says what to do."""


def empty_folder(folder: Path) -> Path:
    """Create the folder, or delete its contents; it then holds only its marker. Raises ForeignFolder."""
    marker = folder / MARKER
    if folder.exists() and any(folder.iterdir()) and not marker.exists():
        raise ForeignFolder(f"{folder} holds files that no demo wrote; name another one with --folder")
    if folder.exists():
        shutil.rmtree(folder)
    folder.mkdir(parents=True)
    marker.touch()
    return folder

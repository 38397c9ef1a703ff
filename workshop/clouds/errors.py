"""Why a recording cannot be read."""

from pathlib import Path


class CloudFileError(Exception):
    """A file or bag that cannot be read as point clouds; the message names it and says why."""

    def __init__(self, path: Path, detail: str) -> None:
        super().__init__(f"{path}: {detail}")

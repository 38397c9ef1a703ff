"""A file that processes of one machine share as memory."""

import mmap
import os
from pathlib import Path


def mapped(path: Path, size: int, create: bool) -> mmap.mmap:
    """The file's first `size` bytes as memory; create: by its writer, which also makes the folder.

    Raises OSError if there is no such file to read, or it is being made and not whole yet.
    """
    if create:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        # A file that has its size is left as it is, and never shrinks: a reader that has it mapped would be
        # killed.
        if path.stat().st_size != size:
            os.truncate(path, size)
    with path.open("r+b") as file:
        if os.fstat(file.fileno()).st_size < size:
            raise OSError(f"{path} is not whole yet")
        return mmap.mmap(file.fileno(), size)

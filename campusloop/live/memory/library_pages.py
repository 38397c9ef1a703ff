"""Pages of libraries that only the start has read."""

import ctypes
import os
import re
from collections.abc import Iterator
from pathlib import Path

import structlog

log = structlog.get_logger("server.memory")

_MAPPINGS = Path("/proc/self/smaps")
# From mman.h of Linux.
_MADV_DONTNEED = 4
# ADDRESS-ADDRESS PERMISSIONS OFFSET DEVICE INODE PATH
_HEAD = re.compile(r"([0-9a-f]+)-([0-9a-f]+) (\S{4}) \S+ \S+ \S+ +(/.*)")


def let_go_of_library_pages() -> None:
    """Return the library pages that the process has read and not changed; nothing where there is no /proc.

    The compiler behind the kernels reads 70 MB of its own code to load what it compiled before, and is not
    used any more when all kernels are loaded. A page that is used again is read again, as a rule from the
    system's cache.
    """
    if not _MAPPINGS.exists():
        return
    library = ctypes.CDLL(None, use_errno=True)
    library.madvise.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int)
    for begin, end in _unchanged(_MAPPINGS.read_text()):
        if library.madvise(begin, end - begin, _MADV_DONTNEED) != 0:
            log.warning("library_pages.kept", error=os.strerror(ctypes.get_errno()))


def _unchanged(mappings: str) -> Iterator[tuple[int, int]]:
    """Where libraries lie that the process cannot write to and has no changed page of.

    The loader writes into some pages before it forbids writing (relocations): those are of the process alone,
    and would be lost.
    """
    found: tuple[int, int] | None = None
    for line in mappings.splitlines():
        head = _HEAD.fullmatch(line)
        if head is not None:
            begin, end, permissions, path = head.groups()
            is_library = "w" not in permissions and ".so" in Path(path).name
            found = (int(begin, 16), int(end, 16)) if is_library else None
        elif line.startswith("Anonymous:") and found is not None:
            if line.split()[1] == "0":
                yield found
            found = None

"""The text of a log file: plain, gzip or bzip2 by content, and as much of a truncated one as is whole."""

import bz2
import zlib
from pathlib import Path
from typing import Protocol

_GZIP, _BZIP2 = b"\x1f\x8b", b"BZh"
# zlib's code for "a gzip header is expected".
_GZIP_WINDOW_BITS = 31


class _Decompressor(Protocol):
    """One stream of a compressed file: what bz2 and zlib have in common."""

    @property
    def eof(self) -> bool: ...
    @property
    def unused_data(self) -> bytes: ...
    def decompress(self, data: bytes, /) -> bytes: ...


class LogFileError(ValueError):
    """The file cannot be read at all; the message is one sentence for the person who named it."""


def read_log_text(path: Path) -> tuple[str, bool]:
    """(the text, whether it is cut off in the compressed stream).

    Bytes that are not ASCII become replacement characters: they occur in comments and host names only.
    Raises LogFileError where the file is missing, is a folder, or holds no readable compressed data.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise LogFileError(f"{path} cannot be read: {error.strerror or error}.") from error
    is_cut = False
    if data.startswith((_GZIP, _BZIP2)):
        data, is_cut = _decompressed(path, data)
    return data.decode("ascii", errors="replace"), is_cut


def _decompressed(path: Path, data: bytes) -> tuple[bytes, bool]:
    """(what could be decompressed, whether the last stream is incomplete or damaged).

    Parallel compressors write several streams in a row.
    """
    magic = data[:2]
    out: list[bytes] = []
    while data[:2] == magic:
        stream = _decompressor(magic)
        try:
            out.append(stream.decompress(data))
        except (OSError, zlib.error) as error:
            if out:
                return b"".join(out), True
            raise LogFileError(f"{path} is a damaged compressed file: {error}.") from error
        if not stream.eof:
            return b"".join(out), True
        data = stream.unused_data
    return b"".join(out), False


def _decompressor(magic: bytes) -> _Decompressor:
    return zlib.decompressobj(_GZIP_WINDOW_BITS) if magic == _GZIP else bz2.BZ2Decompressor()

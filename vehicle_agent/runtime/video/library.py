"""PyAV, by which video is read, encoded and written. It is an extra, imported by its own processes only.

Its wheel contains libraries under the GPL (x264, x265), of which nothing here is used (decision 39).
"""

from importlib.util import find_spec
from types import ModuleType


class VideoLibraryMissing(Exception):
    """PyAV is not installed, or cannot encode; the message says how to install it."""


def is_installed() -> bool:
    """Whether PyAV is there, without loading it into this process."""
    return find_spec("av") is not None


def pyav() -> ModuleType:
    """PyAV with a VP8 encoder. Raises VideoLibraryMissing."""
    try:
        import av
    except ImportError as error:
        raise VideoLibraryMissing(
            "reading and recording cameras needs PyAV: install it with `make video`, or `pip install av`"
        ) from error
    if "libvpx" not in av.codecs_available:
        raise VideoLibraryMissing(
            f"PyAV {av.__version__} has no VP8 encoder (libvpx): its wheel has, which `make video` installs"
        )
    # Encoders and decoders write to stderr, one line for each damaged picture; what matters is told by us.
    av.logging.set_level(av.logging.PANIC)
    library: ModuleType = av
    return library

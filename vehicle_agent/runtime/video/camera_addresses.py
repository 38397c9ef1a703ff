"""How a camera is reached: a device, a stream or a file."""

import re
from pathlib import Path
from typing import Annotated
from urllib.parse import quote, urlsplit

import msgspec

_DEVICE = re.compile(r"/dev/video\d{1,3}$")

Size = Annotated[int, msgspec.Meta(ge=64, le=1920, multiple_of=2)]


def camera_address(name: str, source: str, folder: Path, user: str = "", password_file: str = "") -> str:
    """What is opened, with its password; files lie in the folder. Raises ValueError, OSError."""
    if _DEVICE.match(source):
        return source
    if "://" not in source:
        return str(folder / source)
    parts = urlsplit(source)
    if parts.scheme != "rtsp" or not parts.hostname:
        raise ValueError(f"{name}: {source!r} is none of /dev/videoN, rtsp://HOST/PATH, a file, ring")
    if parts.username or parts.password:
        raise ValueError(f"{name}: give user and password_file instead of a password in the URL")
    if not user:
        return source
    password = (folder / password_file).read_text().strip() if password_file else ""
    return source.replace("://", f"://{quote(user, '')}:{quote(password, '')}@", 1)

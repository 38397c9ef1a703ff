"""A file of secret keys: one key a line in base64, the newest first. It is never in the database."""

import base64
import binascii
import os
import secrets
from contextlib import suppress
from pathlib import Path

from server.domain.rides.ticket_keys import KEY_BYTES_MIN


class BadKeyFile(Exception):
    """The file cannot be used; the text says why and what to do."""


def keys_in_file(path: Path) -> list[bytes]:
    """The keys in the file, the newest first.

    A missing file is created with a new key, readable by its owner only.

    Raises BadKeyFile, OSError.
    """
    try:
        text = path.read_text(encoding="ascii")
    except FileNotFoundError:
        text = _created(path)
    except UnicodeDecodeError as error:
        raise BadKeyFile(f"{path} is not text: {_ADVICE}") from error
    return _keys(path, text)


_ADVICE = "one key a line in base64, the newest first, as `openssl rand -base64 32` makes them"


def _keys(path: Path, text: str) -> list[bytes]:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if not lines:
        raise BadKeyFile(f"{path} holds no key: {_ADVICE}")
    keys = []
    for number, line in enumerate(lines, 1):
        try:
            key = base64.b64decode(line, validate=True)
        except binascii.Error as error:
            raise BadKeyFile(f"{path}: key {number} is not base64: {_ADVICE}") from error
        if len(key) < KEY_BYTES_MIN:
            raise BadKeyFile(
                f"{path}: key {number} has {len(key)} bytes, fewer than {KEY_BYTES_MIN}: {_ADVICE}"
            )
        keys.append(key)
    return keys


def _created(path: Path) -> str:
    """Written beside its place and linked to it: a reader finds all of it, and two writers one key."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    file = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    try:
        with os.fdopen(file, "wb") as file_object:
            file_object.write(base64.b64encode(secrets.token_bytes(KEY_BYTES_MIN)) + b"\n")
            file_object.flush()
            os.fsync(file_object.fileno())
        # Another server may have been first: then its key is the one.
        with suppress(FileExistsError):
            os.link(draft, path)
    finally:
        draft.unlink()
    return path.read_text(encoding="ascii")

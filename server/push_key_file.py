"""The key with which the server signs its messages to push services, from its file."""

from pathlib import Path

from server.key_file import keys_in_file
from server.push_encryption import PushIdentity


def push_identity_of(path: Path) -> PushIdentity:
    """Of the first key in the file. A missing file is created with a new key, readable by its owner only.

    Raises BadKeyFile, OSError.
    """
    return PushIdentity(keys_in_file(path)[0])

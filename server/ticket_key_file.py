"""The ticket keys, from their file."""

from pathlib import Path

from server.domain.rides.ticket_keys import TicketKeys
from server.key_file import keys_in_file


def ticket_keys_of(path: Path) -> TicketKeys:
    """The keys in the file. A missing file is created with a new key, readable by its owner only.

    Raises BadKeyFile, OSError.
    """
    return TicketKeys(keys_in_file(path))

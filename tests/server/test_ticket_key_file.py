"""The file of the ticket keys is created once, readable by its owner only, and checked when it is read."""

import base64
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from server.key_file import BadKeyFile
from server.ticket_key_file import ticket_keys_of


def line(byte: int, length: int = 32) -> str:
    return base64.b64encode(bytes([byte]) * length).decode() + "\n"


def test_a_missing_file_is_created_for_its_owner_and_found_again(tmp_path: Path) -> None:
    path = tmp_path / "var" / "ticket.key"
    made = ticket_keys_of(path)
    assert path.stat().st_mode & 0o777 == 0o600
    assert ticket_keys_of(path).ids == made.ids
    assert [file.name for file in path.parent.iterdir()] == ["ticket.key"]


def test_servers_that_start_at_the_same_time_get_the_same_key(tmp_path: Path) -> None:
    with ThreadPoolExecutor(8) as servers:
        found = list(servers.map(ticket_keys_of, [tmp_path / "ticket.key"] * 8))
    assert len({keys.ids for keys in found}) == 1


def test_the_first_line_is_the_newest_key(tmp_path: Path) -> None:
    path = tmp_path / "ticket.key"
    path.write_text(line(1))
    (old_id,) = ticket_keys_of(path).ids
    path.write_text(line(2) + "\n" + line(1))
    keys = ticket_keys_of(path)
    assert keys.ids[1] == old_id
    assert keys.newest_id != old_id


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "no key"),
        ("not base64!\n", "key 1 is not base64"),
        (line(1) + line(2, 16), "key 2 has 16 bytes"),
        ("schlüssel", "not text"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_with_what_to_do(tmp_path: Path, text: str, what: str) -> None:
    path = tmp_path / "ticket.key"
    path.write_text(text)
    with pytest.raises(BadKeyFile, match=what) as refusal:
        ticket_keys_of(path)
    assert "openssl rand -base64 32" in str(refusal.value)
    assert line(1).strip() not in str(refusal.value)

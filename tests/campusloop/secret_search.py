"""Collects every secret that a server hands out, and searches everything that is left behind for them."""

import re
import sqlite3
from contextlib import closing
from pathlib import Path

import httpx

from contract.runlog.reader import messages

# Fields of answers that are secrets, whatever the endpoint.
SECRET_FIELDS = ("token", "boarding_code", "csrf_token", "secret")
ENROLMENT_CODES = "/enrolments/codes"
_SHORT = 8


class Secrets:
    """`listen` to a client; `found_in` then names what leaks, as (kind, place)."""

    def __init__(self) -> None:
        self.known: dict[str, str] = {}

    def listen(self, client: httpx.AsyncClient) -> None:
        client.event_hooks = {"request": [self._sent], "response": [self._answered]}

    def add(self, kind: str, secret: str) -> None:
        if secret:
            self.known[secret] = kind

    def kinds(self) -> set[str]:
        return set(self.known.values())

    def found_in(self, name: str, content: bytes) -> set[tuple[str, str]]:
        return {(kind, name) for secret, kind in self.known.items() if _occurs(secret, content)}

    def found_in_folder(self, folder: Path) -> set[tuple[str, str]]:
        """In every file as it is, in the rows of databases and in the messages of run logs."""
        found: set[tuple[str, str]] = set()
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            name = str(path.relative_to(folder))
            found |= self.found_in(name, path.read_bytes())
            if path.suffix == ".db":
                found |= self.found_in(f"rows of {name}", rows_of(path))
            if path.suffix == ".mcap":
                found |= self.found_in(f"messages of {name}", b"\n".join(m.data for m in messages(path)))
        return found

    async def _sent(self, request: httpx.Request) -> None:
        self.add("idempotency key", request.headers.get("idempotency-key", ""))

    async def _answered(self, response: httpx.Response) -> None:
        for name, value in response.cookies.items():
            self.add(f"cookie {name}", value)
        if response.headers.get("content-type", "").startswith("application/json"):
            await response.aread()
            self._collect(response.json())
            if response.request.url.path.endswith(ENROLMENT_CODES):
                self.add("enrolment code", response.json()["code"])

    def _collect(self, value: object) -> None:
        if isinstance(value, dict):
            for name, inner in value.items():
                if name in SECRET_FIELDS and isinstance(inner, str):
                    self.add(name, inner)
                self._collect(inner)
        elif isinstance(value, list):
            for inner in value:
                self._collect(inner)


def rows_of(database: Path) -> bytes:
    """Every row of every table, each value in quotes."""
    with closing(sqlite3.connect(database)) as connection:
        names = [row[0] for row in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
        rows = [connection.execute(f'SELECT * FROM "{name}"').fetchall() for name in names]
    assert any(rows), f"{database} is empty"
    return "\n".join(f'"{value}"' for table in rows for row in table for value in row).encode()


def _occurs(secret: str, content: bytes) -> bool:
    text = secret.encode()
    if len(secret) >= _SHORT:
        return text in content
    # Four digits occur everywhere: what counts is a whole value, in quotes, after `=`, or in MessagePack.
    packed = bytes([0xA0 | len(secret)]) + text
    value = rb"""(["'=])""" + re.escape(text) + rb"""(?=["'\s,&]|$)"""
    return packed in content or re.search(value, content) is not None

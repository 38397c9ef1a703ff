"""Clock, ids and password hashing as the use cases see them. Filled in by `app.py`."""

from datetime import datetime
from typing import Protocol


class Clock(Protocol):
    def now(self) -> datetime:
        """Aware UTC."""
        ...


class Ids(Protocol):
    """Names and secrets; seeded in virtual time."""

    def new_id(self, kind: str) -> str:
        """An id that no other thing has, e.g. new_id("ride")."""
        ...

    def ride_code(self) -> str:
        """Six characters that are not mistaken for one another when read aloud."""
        ...

    def token(self) -> str:
        """A secret of at least 128 bits, safe in a URL."""
        ...

    def seed(self) -> int:
        """For a random generator."""
        ...


class PasswordHasher(Protocol):
    def hash(self, password: str) -> str: ...

    def verify(self, password_hash: str, password: str) -> bool: ...

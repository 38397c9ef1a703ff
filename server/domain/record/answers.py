"""Answers to commands that named an idempotency key."""

from dataclasses import dataclass
from datetime import datetime


@dataclass(frozen=True, slots=True)
class KeyedRequest:
    """A command with an idempotency key. Only hashes of the key and of the request are kept.

    account  whose key it is: an operator, a developer token, or the holder of a ride's or series' token
    """

    account: str
    key_sha256: str
    request_sha256: str


@dataclass(frozen=True, slots=True)
class StoredAnswer:
    """sealed: the answer, readable only with the key itself, because it may hold a passenger's secrets."""

    campus_id: str
    request: KeyedRequest
    sealed: bytes
    made_at: datetime

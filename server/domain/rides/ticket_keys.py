"""The secrets of passengers, derived from keys of the server: links and boarding codes are stored nowhere."""

import base64
import hashlib
import hmac
from collections.abc import Sequence
from dataclasses import dataclass, field

from server.domain.errors import TicketKeyMissing

KEY_BYTES_MIN = 32
SECOND_FACTOR_BYTES = 20
# 144 bits of the digest: 24 characters in a URL.
_PROOF_BYTES, _PROOF_CHARACTERS = 18, 24


@dataclass(frozen=True, slots=True)
class RideSecrets:
    """The token of a ride's link, and the code that its riders type on board. Its repr shows neither."""

    token: str = field(repr=False)
    boarding_code: str = field(repr=False)


class TicketKeys:
    """Keys of the server, newest first. A ride or series keeps the id of the key that it was made with.

    A token is a proof (HMAC-SHA-256 of the id, shortened) followed by the id, so that it is checked without
    a stored copy. The id of a key is a part of its hash and no secret. Browsers of operators have such tokens
    too, without an id. Secrets of webhooks are derived as well.
    """

    def __init__(self, keys: Sequence[bytes]) -> None:
        assert all(len(key) >= KEY_BYTES_MIN for key in keys), "a ticket key has 32 bytes at least"
        self._keys = {_key_id(key): key for key in keys}

    @property
    def ids(self) -> tuple[str, ...]:
        """Newest first."""
        return tuple(self._keys)

    @property
    def newest_id(self) -> str:
        """Of the key for new rides. Raises TicketKeyMissing."""
        for key_id in self._keys:
            return key_id
        raise TicketKeyMissing("this process has no ticket key")

    def ride_secrets(self, key_id: str, ride_id: str) -> RideSecrets:
        """Empty ones for a ride that was erased, or whose key is gone: its link does not work either."""
        if key_id not in self._keys:
            return RideSecrets("", "")
        code = int.from_bytes(self._digest(key_id, "boarding code", ride_id)[:8]) % 10_000
        return RideSecrets(self._token(key_id, "ride", ride_id), f"{code:04d}")

    def series_token(self, key_id: str, series_id: str) -> str:
        """Empty as in `ride_secrets`."""
        return self._token(key_id, "series", series_id) if key_id in self._keys else ""

    def proves_ride(self, token: str, key_id: str, ride_id: str) -> bool:
        return key_id in self._keys and _same(token, self._token(key_id, "ride", ride_id))

    def proves_series(self, token: str, key_id: str, series_id: str) -> bool:
        return key_id in self._keys and _same(token, self._token(key_id, "series", series_id))

    def browser_token(self, nonce: str, operator: str) -> str:
        """For a browser in which this operator has signed in. Raises TicketKeyMissing."""
        return self._token(self.newest_id, f"browser of {operator}", nonce)

    def browser_of(self, token: str, operator: str) -> str:
        """The nonce of a browser in which this operator has signed in, "" for any other token."""
        nonce = subject_of(token)
        kind = f"browser of {operator}"
        return nonce if any(_same(token, self._token(key_id, kind, nonce)) for key_id in self._keys) else ""

    def second_factor_secret(self, key_id: str, factor_id: str) -> bytes:
        """Of an operator's authenticator (RFC 4226 wants 20 bytes). Raises TicketKeyMissing."""
        if key_id not in self._keys:
            raise TicketKeyMissing(
                f"second factors made with the ticket key {key_id} cannot be checked; put the key back"
            )
        return self._digest(key_id, "second factor", factor_id)[:SECOND_FACTOR_BYTES]

    def webhook_key(self, key_id: str, webhook_id: str, version: int) -> bytes | None:
        """What messages of a webhook are signed with, 32 bytes; None if the ticket key is gone."""
        return self._digest(key_id, "webhook", f"{webhook_id}\n{version}") if key_id in self._keys else None

    def _token(self, key_id: str, kind: str, subject: str) -> str:
        proof = self._digest(key_id, kind, subject)[:_PROOF_BYTES]
        return base64.urlsafe_b64encode(proof).decode() + subject

    def _digest(self, key_id: str, kind: str, subject: str) -> bytes:
        return hmac.digest(self._keys[key_id], f"campusloop {kind}\n{subject}".encode(), "sha256")


def subject_of(token: str) -> str:
    """The id that a token names, "" for one that names none. It proves nothing."""
    return token[_PROOF_CHARACTERS:]


def _key_id(key: bytes) -> str:
    return hashlib.sha256(b"campusloop ticket key\n" + key).hexdigest()[:16]


def _same(given: str, expected: str) -> bool:
    return hmac.compare_digest(given.encode(), expected.encode())

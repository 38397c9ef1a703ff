"""The outside world as ports: the machine's clock, chance and password hashing, and their seeded twins."""

import random
import secrets
from datetime import UTC, datetime

from argon2 import PasswordHasher as Argon2
from argon2.exceptions import VerificationError

# Read aloud and typed: no 0 O, 1 I L, 5 S, 8 B, 2 Z.
UNAMBIGUOUS = "34679ACDEFGHJKMNPQRTUVWXY"
RIDE_CODE_CHARACTERS = 6


class SystemClock:
    def now(self) -> datetime:
        return datetime.now(UTC)


class RandomIds:
    """Live: ids that cannot be guessed. Each one asks the system once, since asking yields the thread."""

    def new_id(self, kind: str) -> str:
        return f"{kind}-{secrets.token_hex(10)}"

    def ride_code(self) -> str:
        code, rest = "", secrets.randbits(128)
        for _ in range(RIDE_CODE_CHARACTERS):
            rest, letter = divmod(rest, len(UNAMBIGUOUS))
            code += UNAMBIGUOUS[letter]
        return code

    def token(self) -> str:
        return secrets.token_urlsafe(24)

    def seed(self) -> int:
        return secrets.randbits(63)


class SeededIds:
    """Virtual time: the same seed gives the same names in the same order."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self._numbers: dict[str, int] = {}

    def new_id(self, kind: str) -> str:
        self._numbers[kind] = self._numbers.get(kind, 0) + 1
        return f"{kind}-{self._numbers[kind]}"

    def ride_code(self) -> str:
        return "".join(self._random.choice(UNAMBIGUOUS) for _ in range(RIDE_CODE_CHARACTERS))

    def token(self) -> str:
        return f"{self._random.getrandbits(192):048x}"

    def seed(self) -> int:
        return self._random.getrandbits(63)


class Argon2Hasher:
    """Argon2id (RFC 9106) with the library's present recommendation."""

    def __init__(self) -> None:
        self._argon2 = Argon2()

    def hash(self, password: str) -> str:
        return self._argon2.hash(password)

    def verify(self, password_hash: str, password: str) -> bool:
        try:
            return self._argon2.verify(password_hash, password)
        except VerificationError:
            return False

"""Limits how often one client or account may try what could be guessed, and ask for what takes work."""

from dataclasses import dataclass

from server.domain.errors import DomainError

CLIENTS_MAX = 10_000


class TooManyTries(DomainError):
    """retry_after_s: when the next attempt is allowed."""

    code = "too_many_tries"

    def __init__(self, detail: str, retry_after_s: float) -> None:
        super().__init__(detail)
        self.retry_after_s = retry_after_s


@dataclass(slots=True)
class _Bucket:
    tokens: float
    filled_ns: int


class RateLimit:
    """A token bucket for each client network or account; time is given by the caller's clock.

    tries_per_minute  refill rate; a client may also save up that many tries
    """

    def __init__(self, tries_per_minute: int) -> None:
        self._burst = float(tries_per_minute)
        self._per_ns = tries_per_minute / 60e9
        self._buckets: dict[str, _Bucket] = {}

    def take(self, client: str, now_ns: int) -> None:
        """Count one try. Raises TooManyTries when the client has none left."""
        bucket = self._buckets.pop(client, None) or _Bucket(self._burst, now_ns)
        elapsed_ns = max(now_ns - bucket.filled_ns, 0)
        bucket.tokens = min(self._burst, bucket.tokens + elapsed_ns * self._per_ns)
        bucket.filled_ns = now_ns
        self._buckets[client] = bucket
        if len(self._buckets) > CLIENTS_MAX:
            del self._buckets[next(iter(self._buckets))]
        if bucket.tokens < 1.0:
            wait_s = (1.0 - bucket.tokens) / self._per_ns / 1e9
            raise TooManyTries(f"too many tries; wait {wait_s:.0f} s and try again", wait_s)
        bucket.tokens -= 1.0

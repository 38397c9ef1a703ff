"""How many connections each client network has: none may take the places of all others."""

from collections import Counter
from collections.abc import Sequence

from server.addresses import LOOPBACK, Network, budget_of, is_in


class ConnectionCounts:
    """per_client_max: of one address, or one /64 network; without_limit: networks of proxies.

    Programs on the own machine have no limit either.
    """

    def __init__(self, per_client_max: int, without_limit: Sequence[Network] = ()) -> None:
        self._per_client_max = per_client_max
        self._without_limit = (*LOOPBACK, *without_limit)
        self._open: Counter[str] = Counter()

    def opened(self, peer: str) -> bool:
        """Count a new connection; False, and not counted, if there are too many."""
        if is_in(peer, self._without_limit):
            return True
        client = budget_of(peer)
        if self._open[client] >= self._per_client_max:
            return False
        self._open[client] += 1
        return True

    def closed(self, peer: str) -> None:
        """A connection that was counted has ended."""
        client = budget_of(peer)
        if self._open[client] > 1:
            self._open[client] -= 1
        else:
            self._open.pop(client, None)

"""A campus, as a script sees it.

async with connect("http://127.0.0.1:8080", token) as campus:
    async for vehicle in campus.vehicles.list():
        print(vehicle.name, vehicle.mode)
"""

import random
import ssl
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import httpx

from campusloop_sdk.live import Live
from campusloop_sdk.live_models import Topic
from campusloop_sdk.models import Stop
from campusloop_sdk.resources import Closures, Rides, Vehicles
from campusloop_sdk.rest import Rest
from campusloop_sdk.webhooks import Webhooks

TIMEOUT = httpx.Timeout(30.0, connect=10.0)


class Campus:
    """rides, vehicles, closures, webhooks: requests; `live`: what changes."""

    def __init__(
        self, rest: Rest, url: str, token: str, tls: ssl.SSLContext | None, rng: random.Random
    ) -> None:
        self.rides, self.vehicles, self.closures = Rides(rest), Vehicles(rest), Closures(rest)
        self.webhooks = Webhooks(rest)
        self._rest, self._url, self._token, self._tls, self._rng = rest, url, token, tls, rng

    def stops(self) -> AsyncIterator[Stop]:
        """Every stop of the active map, in map order."""
        return self._rest.listed("/stops", Stop)

    def live(self, *topics: Topic) -> Live:
        """Updates of these topics: `async with campus.live("vehicles") as live`. Scope `read`."""
        url = self._url.replace("http", "ws", 1) + "/ws/developer"
        return Live(url, self._token, topics, self._tls if url.startswith("wss") else None, self._rng)


@asynccontextmanager
async def connect(
    server_url: str, token: str, *, tls: ssl.SSLContext | None = None, rng: random.Random | None = None
) -> AsyncIterator[Campus]:
    """The campus of the server at http(s)://HOST:PORT, with a developer token made in the console.

    tls  for a server with a self-signed certificate: a context that trusts it
    rng  spreads the pauses between attempts

    Nothing is sent before the first call.
    """
    url = server_url.rstrip("/")
    spread = rng or random.Random()
    headers = {"Authorization": f"Bearer {token}"}
    async with httpx.AsyncClient(
        base_url=f"{url}/api/v1", headers=headers, verify=tls or True, timeout=TIMEOUT
    ) as http:
        yield Campus(Rest(http, spread), url, token, tls, spread)

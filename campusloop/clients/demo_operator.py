"""The demo's operator: it releases shuttles that stopped because the machine was busy.

On a laptop, starting a browser can starve the simulator for a few tenths of a second. For the vehicle a
by-wire module or a sensor is then silent: it stops and waits for an operator.
"""

import asyncio
from collections.abc import Callable
from typing import Any, Protocol

import httpx

from campusloop.clients.operator_client import OperatorError

POLL_S = 2.0
# A vehicle that cannot be released must not delay the others.
RELEASE_TIMEOUT_S = 10.0
# Suffixes of the fault codes for inputs that come late or not at all.
_LATENESS = ("_lost", "_late", "_missing", "_stale", "_timeout")
# A by-wire module that has lost the heartbeat reports this fault next.
_CONSEQUENCE = "bywire_refuses_enable"


class OperatorPort(Protocol):
    """The part of `OperatorClient` that is used here."""

    async def incidents(self) -> list[dict[str, Any]]: ...

    async def release(self, vehicle_id: str) -> None: ...


class DemoOperator:
    """Releases a vehicle when its incident has been open for one poll.

    An incident that is acknowledged on the console is left to the person who acknowledged it.
    """

    def __init__(
        self,
        operator: OperatorPort,
        report: Callable[[str], None],
        on_released: Callable[[str], None],
        release_timeout_s: float = RELEASE_TIMEOUT_S,
    ) -> None:
        """report: is called with each error; on_released: with each released vehicle's id."""
        self._operator = operator
        self._release_timeout_s = release_timeout_s
        self._report = report
        self._on_released = on_released
        self._seen: frozenset[str] = frozenset()

    async def run(self) -> None:
        """Poll until cancelled."""
        while True:
            await asyncio.sleep(POLL_S)
            try:
                await self.poll()
            except (httpx.TransportError, OperatorError) as error:
                self._report(
                    f"the demo's operator could not read the incidents or release a vehicle: {error}"
                )

    async def _release(self, vehicle_id: str) -> None:
        try:
            async with asyncio.timeout(self._release_timeout_s):
                await self._operator.release(vehicle_id)
            self._on_released(vehicle_id)
        except TimeoutError:
            self._report(f"{vehicle_id} could not be released; look at the console")

    async def poll(self) -> None:
        """Release the vehicles whose incident was open at the last poll too.

        Raises OperatorError, httpx.TransportError.
        """
        stopped = {i["incident_id"]: i for i in await self._operator.incidents() if is_from_lateness(i)}
        for incident_id in sorted(self._seen & stopped.keys()):
            await self._release(stopped[incident_id]["vehicle_id"])
        self._seen = frozenset(stopped)


def is_from_lateness(incident: dict[str, Any]) -> bool:
    """An open, unacknowledged minimal-risk stop whose causes are all late or missing inputs."""
    causes = [cause for cause in str(incident["cause"]).split(", ") if cause != _CONSEQUENCE]
    is_late = bool(causes) and all(cause.endswith(_LATENESS) for cause in causes)
    is_unattended = incident["acknowledged_at"] is None and incident["closed_at"] is None
    return incident["kind"] == "minimal_risk_stop" and is_unattended and is_late

"""The operator of a demo: somebody has to let shuttles drive on that stopped because the machine was busy.

In real time on a laptop, starting a browser can starve the simulator for a few tenths of a second. To a
vehicle that is a by-wire module or a sensor gone silent: it stops and waits for an operator, as it must.
"""

import asyncio
from collections.abc import Callable
from typing import Any, Protocol

import httpx

from campusloop.clients.operator_client import OperatorError

LOOK_EVERY_S = 2.0
# One vehicle that cannot be released must not keep the others waiting.
RELEASE_WITHIN_S = 10.0
# The endings of faults that a starved machine causes: something came late or not at all.
_LATENESS = ("_lost", "_late", "_missing", "_stale", "_timeout")
# What a by-wire module without a life sign does next.
_FOLLOWS = "bywire_refuses_enable"


class OperatorPort(Protocol):
    """What of an operator's hands is needed here (`OperatorClient`)."""

    async def incidents(self) -> list[dict[str, Any]]: ...

    async def release(self, vehicle_id: str) -> None: ...


class DemoOperator:
    """Releases such a vehicle when its incident has been open for one look.

    An incident that somebody has acknowledged on the console is theirs.
    """

    def __init__(
        self,
        operator: OperatorPort,
        tell: Callable[[str], None],
        released: Callable[[str], None],
        release_within_s: float = RELEASE_WITHIN_S,
    ) -> None:
        """tell: what went wrong; released: a vehicle that was let drive on, each time."""
        self._operator = operator
        self._release_within_s = release_within_s
        self._tell = tell
        self._released = released
        self._seen: frozenset[str] = frozenset()

    async def run(self) -> None:
        """Until cancelled."""
        while True:
            await asyncio.sleep(LOOK_EVERY_S)
            try:
                await self.look()
            except (httpx.TransportError, OperatorError) as error:
                self._tell(f"the demo's operator could not help: {error}")

    async def _release(self, vehicle_id: str) -> None:
        try:
            async with asyncio.timeout(self._release_within_s):
                await self._operator.release(vehicle_id)
            self._released(vehicle_id)
        except TimeoutError:
            self._tell(f"{vehicle_id} could not be released; look at the console")

    async def look(self) -> None:
        """Raises OperatorError, httpx.TransportError."""
        stopped = {i["incident_id"]: i for i in await self._operator.incidents() if is_from_lateness(i)}
        for incident_id in sorted(self._seen & stopped.keys()):
            await self._release(stopped[incident_id]["vehicle_id"])
        self._seen = frozenset(stopped)


def is_from_lateness(incident: dict[str, Any]) -> bool:
    """A minimal-risk stop that nobody looks after, all of whose causes are things that came late."""
    causes = [cause for cause in str(incident["cause"]).split(", ") if cause != _FOLLOWS]
    is_late = bool(causes) and all(cause.endswith(_LATENESS) for cause in causes)
    is_ours = incident["acknowledged_at"] is None and incident["closed_at"] is None
    return incident["kind"] == "minimal_risk_stop" and is_ours and is_late

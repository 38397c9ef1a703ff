"""Simulated passengers. They book through the public API and follow their rides to the end.

The same coroutines run in real time and in virtual time. The simulator moves the riders to the stop and
through the doors, behind `RiderPort`.
"""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any, Literal, Protocol

import httpx

POLL_EVERY_S = 2.0
# A refused passenger books again after this time, at most so many times in all.
RETRY_S = 120.0
REQUESTS_MAX = 12
ENDED = frozenset({"completed", "refused", "cancelled", "no_show", "failed"})

BoardingMethod = Literal["code", "tap", "sensor"]
BOARDING_METHODS: tuple[BoardingMethod, ...] = ("code", "tap", "sensor")


class ApiError(Exception):
    """The server refused a request; the message is the problem's title and detail."""


@dataclass(frozen=True, slots=True)
class RideDemand:
    """A ride that a passenger books `after_s` seconds after the start.

    turns_up: whether the party comes to the stop
    """

    number: int
    after_s: float
    from_stop: str
    to_stop: str
    party: int
    how: BoardingMethod
    turns_up: bool = True


@dataclass(slots=True)
class Journey:
    """A passenger's ride so far. boards: the shuttle that the party would board now, "" for none.

    history: (moment, state) in order; a refused passenger has requested more than once.
    """

    demand: RideDemand
    ride_id: str = ""
    ride_code: str = ""
    state: str = ""
    reason: str = ""
    vehicle_id: str = ""
    boards: str = ""
    promise: dict[str, str] | None = None
    promise_broken: bool = False
    history: list[tuple[datetime, str]] = field(default_factory=list)

    def moment(self, state: str) -> datetime | None:
        return next((at for at, name in self.history if name == state), None)

    @property
    def wait_s(self) -> float | None:
        """From the request to sitting on board."""
        return _between(self.moment("requested"), self.moment("aboard"))

    @property
    def ride_s(self) -> float | None:
        return _between(self.moment("aboard"), self.moment("completed"))


def _between(begin: datetime | None, end: datetime | None) -> float | None:
    return (end - begin).total_seconds() if begin is not None and end is not None else None


class RiderPort(Protocol):
    """Adds a party of riders to the simulated world."""

    def add(self, ticket: dict[str, Any], demand: RideDemand) -> None: ...

    def assigned(self, ride_id: str, vehicle_id: str) -> None:
        """The phone now shows this vehicle to board, "" for none."""
        ...


JourneyListener = Callable[[Journey], None]
Now = Callable[[], datetime]


class Passengers:
    """All simulated passengers of a demo."""

    def __init__(
        self,
        client: httpx.AsyncClient,
        riders: RiderPort,
        now: Now,
        on_change: JourneyListener = lambda journey: None,
    ) -> None:
        """client: has the server's base URL; on_change: called at every change of a journey's state."""
        self._client = client
        self._riders = riders
        self._now = now
        self._on_change = on_change
        self._tokens: dict[str, str] = {}

    async def run_journey(self, journey: Journey) -> Journey:
        """Take one party from its demand to the end of its ride."""
        demand = journey.demand
        await asyncio.sleep(demand.after_s)
        ticket = await self._request(journey)
        for _ in range(REQUESTS_MAX - 1):
            if ticket["state"] != "refused":
                break
            await asyncio.sleep(RETRY_S)
            ticket = await self._request(journey)
        while journey.state not in ENDED:
            await asyncio.sleep(POLL_EVERY_S)
            ride = await self._ride(ticket["token"])
            if ride is not None:
                self._update(journey, ride)
        return journey

    async def tap(self, ride_id: str, kind: Literal["board", "alight"]) -> None:
        """The phone's button, pressed by the simulated passenger."""
        path = f"/api/v1/rides/{self._tokens[ride_id]}/{kind}"
        answer = await self._client.post(path)
        if answer.status_code != httpx.codes.CONFLICT:
            # A conflict is harmless: the seat sensor has reported the boarding before the button.
            _body(answer, path)

    async def cancel(self, ride_id: str) -> None:
        path = f"/api/v1/rides/{self._tokens[ride_id]}/cancel"
        _body(await self._client.post(path), path)

    async def call_help(self, ride_id: str, text: str) -> None:
        path = f"/api/v1/rides/{self._tokens[ride_id]}/help"
        _body(await self._client.post(path, json={"text": text}), path)

    async def _request(self, journey: Journey) -> dict[str, Any]:
        demand = journey.demand
        self._set_state(journey, "requested")
        ticket = await self._book(demand)
        journey.ride_id, journey.ride_code = ticket["ride_id"], ticket["ride_code"]
        journey.promise = ticket["promise"]
        self._tokens[journey.ride_id] = ticket["token"]
        if ticket["state"] != "refused" and demand.turns_up:
            self._riders.add(ticket, demand)
        self._update(journey, ticket)
        return ticket

    async def _book(self, demand: RideDemand) -> dict[str, Any]:
        request = {"from_stop": demand.from_stop, "to_stop": demand.to_stop, "party": demand.party}
        return _body(await self._client.post("/api/v1/rides", json=request), "booking")

    async def _ride(self, token: str) -> dict[str, Any] | None:
        """The ride as the phone shows it; None while the server cannot be reached."""
        try:
            return _body(await self._client.get(f"/api/v1/rides/{token}"), "ride")
        except httpx.TransportError:
            return None

    def _update(self, journey: Journey, ride: dict[str, Any]) -> None:
        journey.vehicle_id = ride["vehicle_id"] or ""
        boards = journey.vehicle_id if self._is_due(journey, ride["state"]) else ""
        if boards != journey.boards:
            journey.boards = boards
            self._riders.assigned(journey.ride_id, boards)
        journey.reason = ride["reason_detail"] or ride["reason"]
        journey.promise_broken = ride["promise_broken"]
        if ride["state"] != journey.state:
            self._set_state(journey, ride["state"])

    def _is_due(self, journey: Journey, state: str) -> bool:
        """The party boards when the shuttle is reported at the stop, or when the promised window begins."""
        if state == "boarding" or journey.promise is None:
            return state == "boarding"
        return self._now() >= datetime.fromisoformat(journey.promise["pickup_from"])

    def _set_state(self, journey: Journey, state: str) -> None:
        journey.state = state
        journey.history.append((self._now(), state))
        self._on_change(journey)


def _body(answer: httpx.Response, what: str) -> dict[str, Any]:
    body: dict[str, Any] = answer.json()
    if answer.is_error:
        raise ApiError(f"{what}: {body.get('title', answer.status_code)}: {body.get('detail', '')}")
    return body

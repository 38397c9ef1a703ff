"""Simulated passengers: they book through the public API like anybody, and tell how it went.

The same coroutines run in real time and in virtual time; how a body gets to the stop and through the doors
is the simulator's business, behind `RiderPort`.
"""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any, Literal, Protocol

import httpx

POLL_EVERY_S = 2.0
# Whom no shuttle can take now asks again after a while, so often at most.
ASK_AGAIN_S = 120.0
ASKS_MAX = 12
ENDED = frozenset({"completed", "refused", "cancelled", "no_show", "failed"})

How = Literal["code", "tap", "sensor"]
HOWS: tuple[How, ...] = ("code", "tap", "sensor")


class ApiError(Exception):
    """The server said no; the message is its problem's title and detail."""


@dataclass(frozen=True, slots=True)
class RideDemand:
    """A ride somebody wants, `after_s` seconds after the start. turns_up: at the stop, to ride it."""

    number: int
    after_s: float
    from_stop: str
    to_stop: str
    party: int
    how: How
    turns_up: bool = True


@dataclass(slots=True)
class Journey:
    """What became of a wish. boards: the shuttle they would get on now.

    history: (moment, state) in order; whoever is refused asks more than once.
    """

    wish: RideDemand
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
        """From asking to sitting."""
        return _between(self.moment("requested"), self.moment("aboard"))

    @property
    def ride_s(self) -> float | None:
        return _between(self.moment("aboard"), self.moment("completed"))


def _between(begin: datetime | None, end: datetime | None) -> float | None:
    return (end - begin).total_seconds() if begin is not None and end is not None else None


class RiderPort(Protocol):
    """Puts a party of flesh and blood into the world."""

    def add(self, ticket: dict[str, Any], wish: RideDemand) -> None: ...

    def assigned(self, ride_id: str, vehicle_id: str) -> None:
        """The phone now says to get on this vehicle, "" for none."""
        ...


Tell = Callable[[Journey], None]
Now = Callable[[], datetime]


class Passengers:
    """Lives of all simulated passengers of a demo."""

    def __init__(self, client: httpx.AsyncClient, riders: RiderPort, now: Now, tell: Tell) -> None:
        """client: base URL of the server; tell: called at every change of a journey."""
        self._client = client
        self._riders = riders
        self._now = now
        self._tell = tell
        self._tokens: dict[str, str] = {}

    async def live(self, journey: Journey) -> Journey:
        """One party from wish to end of ride."""
        wish = journey.wish
        await asyncio.sleep(wish.after_s)
        ticket = await self._ask(journey)
        for _ in range(ASKS_MAX - 1):
            if ticket["state"] != "refused":
                break
            await asyncio.sleep(ASK_AGAIN_S)
            ticket = await self._ask(journey)
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
            # A conflict is no news to a rider: the seat sensor was faster than the thumb.
            _body(answer, path)

    async def cancel(self, ride_id: str) -> None:
        path = f"/api/v1/rides/{self._tokens[ride_id]}/cancel"
        _body(await self._client.post(path), path)

    async def call_help(self, ride_id: str, text: str) -> None:
        path = f"/api/v1/rides/{self._tokens[ride_id]}/help"
        _body(await self._client.post(path, json={"text": text}), path)

    async def _ask(self, journey: Journey) -> dict[str, Any]:
        wish = journey.wish
        self._note(journey, "requested")
        ticket = await self._book(wish)
        journey.ride_id, journey.ride_code = ticket["ride_id"], ticket["ride_code"]
        journey.promise = ticket["promise"]
        self._tokens[journey.ride_id] = ticket["token"]
        if ticket["state"] != "refused" and wish.turns_up:
            self._riders.add(ticket, wish)
        self._update(journey, ticket)
        return ticket

    async def _book(self, wish: RideDemand) -> dict[str, Any]:
        request = {"from_stop": wish.from_stop, "to_stop": wish.to_stop, "party": wish.party}
        return _body(await self._client.post("/api/v1/rides", json=request), "booking")

    async def _ride(self, token: str) -> dict[str, Any] | None:
        """The ride as the phone sees it; None while the server cannot be reached: the phone asks again."""
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
            self._note(journey, ride["state"])

    def _is_due(self, journey: Journey, state: str) -> bool:
        """The phone says that the shuttle is here, or by the promise it may be: nobody gets on before."""
        if state == "boarding" or journey.promise is None:
            return state == "boarding"
        return self._now() >= datetime.fromisoformat(journey.promise["pickup_from"])

    def _note(self, journey: Journey, state: str) -> None:
        journey.state = state
        journey.history.append((self._now(), state))
        self._tell(journey)


def _body(answer: httpx.Response, what: str) -> dict[str, Any]:
    body: dict[str, Any] = answer.json()
    if answer.is_error:
        raise ApiError(f"{what}: {body.get('title', answer.status_code)}: {body.get('detail', '')}")
    return body

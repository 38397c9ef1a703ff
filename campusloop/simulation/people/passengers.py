"""Simulated passengers: they book, cancel, change their mind, and type their codes at a vehicle's doors."""

import asyncio
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import timedelta
from typing import Any

from campusloop.clients.ride_demand import StopPair
from campusloop.simulation.history.records import AcknowledgedBooking
from campusloop.simulation.people.requests import ServiceClient
from campusloop.simulation.schedule import Clock
from contract.wire.messages import RiderTask

PARTIES = (1, 1, 1, 1, 2, 2, 3)
NO_SHOW_RATIO = 0.05
CANCEL_RATIO = 0.1
REDIRECT_RATIO = 0.08
# The same booking again, with its key, though it was answered: an impatient phone.
REPEAT_RATIO = 0.15
AHEAD_RATIO = 0.2
AHEAD_S = (600.0, 3600.0)
SERIES_RATIO = 0.02
# Whose hands are full does not type at once, and some stay seated at their stop.
TYPES_RATIO = 0.7

Acknowledge = Callable[[AcknowledgedBooking], None]


@dataclass
class Passenger:
    """aboard: the vehicle that the party sits in, "" before and after; has_arrived: it has got off."""

    ride_id: str
    code: str
    shows_up: bool
    aboard: str = ""
    has_arrived: bool = False


@dataclass
class Passengers:
    """`run` books until `is_open` is False. The doors ask for `codes`."""

    client: ServiceClient
    clock: Clock
    stops: tuple[StopPair, ...]
    spacing_s: float
    rng: random.Random
    door_rng: random.Random
    acknowledge: Acknowledge
    now_s: Callable[[], float]
    is_open: bool = True
    booked: int = 0
    _known: dict[str, Passenger] = field(default_factory=dict)
    _tasks: set["asyncio.Task[None]"] = field(default_factory=set)

    def codes(
        self, vehicle_id: str, boarding: tuple[RiderTask, ...], alighting: tuple[RiderTask, ...]
    ) -> tuple[str, ...]:
        """The codes that those of these parties type who are there and want to: first those who get off."""
        leaving = [p for p in self._parties(alighting) if p.aboard == vehicle_id]
        found = [p for p in leaving if self._types()]
        for passenger in found:
            passenger.aboard, passenger.has_arrived = "", True
        if not leaving:
            found = [p for p in self._parties(boarding) if self._boards(p, vehicle_id)]
            for passenger in found:
                passenger.aboard = vehicle_id
        return tuple(passenger.code for passenger in found)

    def _parties(self, tasks: tuple[RiderTask, ...]) -> list[Passenger]:
        known = (self._known.get(task.ride_id) for task in tasks)
        return [passenger for passenger in known if passenger is not None]

    def _boards(self, passenger: Passenger, vehicle_id: str) -> bool:
        """A computer that has lost its memory of this party lets it type its code again."""
        is_here = passenger.shows_up and not passenger.has_arrived and passenger.aboard in ("", vehicle_id)
        return is_here and self._types()

    def _types(self) -> bool:
        return self.door_rng.random() < TYPES_RATIO

    async def run(self) -> None:
        while self.is_open:
            await asyncio.sleep(self.rng.expovariate(1.0 / self.spacing_s))
            if self.is_open:
                task = asyncio.get_running_loop().create_task(self._travel())
                self._tasks.add(task)
                task.add_done_callback(self._tasks.discard)

    async def _travel(self) -> None:
        rng = random.Random(self.rng.getrandbits(64))
        from_stop, to_stop = rng.choice(self.stops)
        body: dict[str, object] = {"from_stop": from_stop, "to_stop": to_stop, "party": rng.choice(PARTIES)}
        if rng.random() < SERIES_RATIO:
            await self._book_series(rng, body)
            return
        if rng.random() < AHEAD_RATIO:
            earliest = self.clock.now() + timedelta(seconds=rng.uniform(*AHEAD_S))
            body["earliest"] = earliest.isoformat()
        key = f"{rng.getrandbits(128):032x}"
        ticket = await self._book(body, key)
        if ticket is None:
            return
        if rng.random() < REPEAT_RATIO:
            await asyncio.sleep(rng.uniform(1.0, 120.0))
            await self._book(body, key)
        passenger = Passenger(ticket["ride_id"], ticket["boarding_code"], rng.random() >= NO_SHOW_RATIO)
        self._known[passenger.ride_id] = passenger
        if rng.random() < CANCEL_RATIO:
            await asyncio.sleep(rng.uniform(5.0, 600.0))
            await self.client.ask("POST", f"/rides/{ticket['token']}/cancel", key=self.client.new_key())
        elif rng.random() < REDIRECT_RATIO:
            await asyncio.sleep(rng.uniform(5.0, 600.0))
            other = {"to_stop": rng.choice(self.stops)[1]}
            path = f"/rides/{ticket['token']}/destination"
            await self.client.ask("POST", path, other, key=self.client.new_key())

    async def _book(self, body: dict[str, object], key: str) -> dict[str, Any] | None:
        """The ticket of a ride that was not refused; None for any other end."""
        answer = await self.client.ask("POST", "/rides", body, key=key)
        if answer is None or answer.status_code != 201:
            return None
        ticket: dict[str, Any] = answer.json()
        self.booked += 1
        self.acknowledge(AcknowledgedBooking(self.now_s(), key, ticket["ride_id"], ticket["party"]))
        return None if ticket["state"] == "refused" else ticket

    async def _book_series(self, rng: random.Random, body: dict[str, object]) -> None:
        """Every day at some time of today; cancelled after a while. Its party does not show up."""
        soon = self.clock.now() + timedelta(seconds=rng.uniform(1800.0, 7200.0))
        ends_on = (soon + timedelta(days=20)).date()
        request = {
            **body,
            "weekdays": list(range(7)),
            "leave": f"{soon:%H:%M}",
            "ends_on": ends_on.isoformat(),
        }
        answer = await self.client.ask("POST", "/series", request, key=self.client.new_key())
        if answer is None or answer.status_code != 201:
            return
        await asyncio.sleep(rng.uniform(600.0, 7200.0))
        await self.client.ask("POST", f"/series/{answer.json()['token']}/cancel", key=self.client.new_key())

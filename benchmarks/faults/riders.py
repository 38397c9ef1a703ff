"""Booking clients that remember what was acknowledged to them."""

import asyncio
import random
import time
import uuid
from dataclasses import dataclass, field

import httpx

from campusloop.simulation.history.records import AcknowledgedBooking
from campusloop.simulation.history.rides import doubled_bookings, lost_bookings


@dataclass
class Riders:
    """`run` books again and again; each booking is repeated with its key until it is answered.

    tokens      of acknowledged rides, by ride id
    answers_s   how long each answered request took
    failures    answers that say that the server has a defect (500), by text
    unanswered  requests whose connection ended first
    """

    origin: str
    stops: list[str]
    seed: int
    acknowledged: list[AcknowledgedBooking] = field(default_factory=list)
    tokens: dict[str, str] = field(default_factory=dict)
    answers_s: list[float] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    unanswered: int = 0
    begun_s: float = field(default_factory=time.monotonic)

    async def run(self, clients: int = 4) -> None:
        async with httpx.AsyncClient(base_url=f"{self.origin}/api/v1", trust_env=False, timeout=20.0) as http:
            await asyncio.gather(
                *(self._book_often(http, random.Random(self.seed + n)) for n in range(clients))
            )

    async def book(self, http: httpx.AsyncClient, rng: random.Random) -> str:
        """One booking, repeated until it is answered. Returns the ride's state."""
        from_stop, to_stop = rng.sample(self.stops, 2)
        key = str(uuid.UUID(int=rng.getrandbits(128)))
        request = {"from_stop": from_stop, "to_stop": to_stop, "party": 1}
        while True:
            begun = time.monotonic()
            try:
                answer = await http.post("/rides", json=request, headers={"Idempotency-Key": key})
            except httpx.TransportError:
                self.unanswered += 1
                await asyncio.sleep(0.5)
                continue
            self.answers_s.append(time.monotonic() - begun)
            if answer.status_code == 201:
                ride = answer.json()
                at_s = time.monotonic() - self.begun_s
                self.acknowledged.append(AcknowledgedBooking(at_s, key, ride["ride_id"]))
                self.tokens[ride["ride_id"]] = ride["token"]
                return str(ride["state"])
            if answer.status_code == 500:
                self.failures.append(answer.text[:200])
            await asyncio.sleep(0.5)

    async def _book_often(self, http: httpx.AsyncClient, rng: random.Random) -> None:
        while True:
            await self.book(http, rng)
            await asyncio.sleep(rng.uniform(0.1, 0.5))

    async def lost_and_doubled(self) -> tuple[int, int]:
        """How many acknowledged rides are not there any more, and how many keys were given two rides."""
        # Riders may go on meanwhile.
        acknowledged, tokens = list(self.acknowledged), dict(self.tokens)
        there = set()
        async with httpx.AsyncClient(base_url=f"{self.origin}/api/v1", trust_env=False, timeout=20.0) as http:
            for ride_id, token in tokens.items():
                if (await http.get(f"/rides/{token}")).status_code == 200:
                    there.add(ride_id)
        at_s = time.monotonic() - self.begun_s
        lost = lost_bookings(at_s, acknowledged, there)
        return len(lost), len(doubled_bookings(at_s, acknowledged))

"""Booking clients that remember what was acknowledged to them."""

import asyncio
import random
import time
import uuid
from dataclasses import dataclass, field

import httpx

from benchmarks.faults.installation import Installation


@dataclass(frozen=True, slots=True)
class Acknowledged:
    """A booking that the server answered with 201."""

    key: str
    ride_id: str
    token: str


@dataclass
class Riders:
    """`run` books again and again; each booking is repeated with its key until it is answered.

    answers_s  how long each answered request took
    failures   answers that say that the server has a defect (500), by text
    """

    installation: Installation
    stops: list[str]
    seed: int
    acknowledged: list[Acknowledged] = field(default_factory=list)
    answers_s: list[float] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    async def run(self, clients: int = 4) -> None:
        async with httpx.AsyncClient(
            base_url=f"{self.installation.origin}/api/v1", trust_env=False, timeout=20.0
        ) as http:
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
                await asyncio.sleep(0.5)
                continue
            self.answers_s.append(time.monotonic() - begun)
            if answer.status_code == 201:
                ride = answer.json()
                self.acknowledged.append(Acknowledged(key, ride["ride_id"], ride["token"]))
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
        lost = 0
        for ride in self.acknowledged:
            answer = await self.installation.http.get(f"/rides/{ride.token}")
            lost += answer.status_code != 200
        rides_of: dict[str, set[str]] = {}
        for ride in self.acknowledged:
            rides_of.setdefault(ride.key, set()).add(ride.ride_id)
        return lost, sum(len(rides) > 1 for rides in rides_of.values())

"""Simulated operators: they resume what stands, settle conflicts, and hold, recall and close roads."""

import asyncio
import random
from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass, field

from campusloop.simulation.people.requests import ServiceClient
from campusloop.virtual.campus import OPERATOR

WATCH_EVERY_S = 10.0
INCIDENTS_EVERY_S = 60.0
# Between two interventions of one campus, on average.
INTERVENE_EVERY_S = 240.0
CLOSED_S = (120.0, 900.0)
HELD_S = (15.0, 240.0)


@dataclass
class Operators:
    """`run` works until `is_open` is False; `watch` goes on: what stands is resumed to the end.

    held        vehicles that stand held and run, as the vehicles know it
    lanes       that may be closed
    credentials of the operator whom they all are: name and password
    """

    client: ServiceClient
    vehicles: Sequence[str]
    lanes: Sequence[str]
    rng: random.Random
    held: Callable[[], tuple[str, ...]]
    credentials: tuple[str, str] = OPERATOR
    is_open: bool = True
    interventions: int = 0
    _csrf: str = ""
    _on_purpose: set[str] = field(default_factory=set)
    _tasks: set["asyncio.Task[None]"] = field(default_factory=set)

    async def sign_in(self) -> None:
        name, password = self.credentials
        answer = await self.client.ask("POST", "/session", {"name": name, "password": password})
        self._csrf = "" if answer is None else answer.json()["csrf_token"]

    async def enrol(self, vehicle_id: str, public_key: str, seats: int, wheelchair_places: int) -> None:
        new = {
            "vehicle_id": vehicle_id,
            "name": vehicle_id,
            "seats": seats,
            "wheelchair_places": wheelchair_places,
        }
        answer = await self._post("/enrolments/codes", new)
        assert answer is not None
        code = {"code": answer["code"], "vehicle_id": vehicle_id, "public_key": public_key}
        await self._post("/enrolments", code)

    async def announce(self, vehicle_id: str, text: str) -> str:
        """The id of the command; "" if it was not taken."""
        answer = await self._post(f"/vehicles/{vehicle_id}/announce", {"text": text})
        return "" if answer is None else str(answer["command_id"])

    async def watch(self) -> None:
        """Resume what stands held and not on purpose; close incidents that only an operator can close."""
        turn = 0
        while True:
            await asyncio.sleep(WATCH_EVERY_S)
            for vehicle_id in self.held():
                if vehicle_id not in self._on_purpose:
                    self._spawn(self._resume(vehicle_id))
            turn += 1
            if turn % round(INCIDENTS_EVERY_S / WATCH_EVERY_S) == 0:
                await self._close_conflicts()

    async def intervene(self) -> None:
        """Now and then, something that an operator may do."""
        while self.is_open:
            await asyncio.sleep(self.rng.expovariate(1.0 / INTERVENE_EVERY_S))
            if self.is_open:
                self.interventions += 1
                actions = (self._hold, self._stop, self._recall, self._close_road, self._hold_for)
                self._spawn(self.rng.choice(actions)(self.rng.choice(self.vehicles)))

    def _spawn(self, work: Coroutine[object, None, None]) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _resume(self, vehicle_id: str) -> None:
        await self._post(f"/vehicles/{vehicle_id}/resume", None)

    async def _hold(self, vehicle_id: str) -> None:
        await self._stand(vehicle_id, "hold")

    async def _stop(self, vehicle_id: str) -> None:
        await self._stand(vehicle_id, "stop-now")

    async def _stand(self, vehicle_id: str, verb: str) -> None:
        self._on_purpose.add(vehicle_id)
        await self._post(f"/vehicles/{vehicle_id}/{verb}", None)
        await asyncio.sleep(self.rng.uniform(*HELD_S))
        self._on_purpose.discard(vehicle_id)

    async def _hold_for(self, vehicle_id: str) -> None:
        """The server resumes it."""
        self._on_purpose.add(vehicle_id)
        await self._post(f"/vehicles/{vehicle_id}/hold?for_s={self.rng.uniform(*HELD_S):.0f}", None)
        await asyncio.sleep(HELD_S[1] + 60.0)
        self._on_purpose.discard(vehicle_id)

    async def _recall(self, vehicle_id: str) -> None:
        await self._post(f"/vehicles/{vehicle_id}/recall", None)
        await asyncio.sleep(self.rng.uniform(*HELD_S))
        await self._post(f"/vehicles/{vehicle_id}/release", None)

    async def _close_road(self, _vehicle_id: str) -> None:
        lane_id = self.rng.choice(self.lanes)
        closed = await self._post("/closures", {"lane_ids": [lane_id], "reason": "a drill"})
        if closed is None:
            return
        await asyncio.sleep(self.rng.uniform(*CLOSED_S))
        await self.client.ask(
            "DELETE", f"/closures/{closed['closure_id']}", key=self.client.new_key(), csrf=self._csrf
        )

    async def _close_conflicts(self) -> None:
        answer = await self.client.ask("GET", "/incidents")
        for incident in answer.json() if answer is not None and answer.status_code == 200 else ():
            if incident["kind"] == "key_conflict" and incident["closed_at"] is None:
                await self._post(f"/incidents/{incident['incident_id']}/close", None)

    async def _post(self, path: str, body: dict[str, object] | None) -> dict[str, object] | None:
        """The answer, None for a refusal; signs in again when the session is over."""
        key = self.client.new_key()
        for _ in range(2):
            answer = await self.client.ask("POST", path, body, key=key, csrf=self._csrf)
            if answer is None:
                return None
            if answer.status_code == 401:
                await self.sign_in()
                continue
            found: dict[str, object] | None = answer.json() if answer.is_success else None
            return found
        return None

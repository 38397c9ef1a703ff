"""Requests to the service that are repeated until they are answered, as a careful client does."""

import asyncio
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import httpx

PATIENCE_S = 600.0
PAUSE_S = (1.0, 6.0)

Asked = Callable[[str, str, int], None]


@dataclass
class ServiceClient:
    """One actor's requests. `answered` is told the method, the path and the status of each answer."""

    http: httpx.AsyncClient
    rng: random.Random
    answered: Asked

    def new_key(self) -> str:
        return f"{self.rng.getrandbits(128):032x}"

    async def ask(
        self,
        method: str,
        path: str,
        body: Mapping[str, object] | None = None,
        *,
        key: str = "",
        csrf: str = "",
    ) -> httpx.Response | None:
        """The answer; None if there was none within PATIENCE_S. With a key, a repeat does nothing twice."""
        headers = {"Idempotency-Key": key} if key else {}
        if csrf:
            headers["X-CSRF-Token"] = csrf
        loop = asyncio.get_running_loop()
        ends = loop.time() + PATIENCE_S
        while loop.time() < ends:
            try:
                answer = await self.http.request(method, f"/api/v1{path}", json=body, headers=headers)
            except httpx.TransportError:
                await asyncio.sleep(self.rng.uniform(*PAUSE_S))
                continue
            self.answered(method, path, answer.status_code)
            if answer.status_code < 500 and answer.status_code != 429:
                return answer
            await asyncio.sleep(self.rng.uniform(*PAUSE_S))
        return None

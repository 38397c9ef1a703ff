"""A client of the simulated people that remembers how long each answer took."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field

import httpx

from campusloop.simulation.people.requests import ServiceClient


@dataclass
class TimedClient(ServiceClient):
    """answers_s: from the first attempt to the answer, the pauses between attempts included"""

    answers_s: list[float] = field(default_factory=list)

    async def ask(
        self,
        method: str,
        path: str,
        body: Mapping[str, object] | None = None,
        *,
        key: str = "",
        csrf: str = "",
    ) -> httpx.Response | None:
        begun_s = time.monotonic()
        answer = await super().ask(method, path, body, key=key, csrf=csrf)
        self.answers_s.append(time.monotonic() - begun_s)
        return answer

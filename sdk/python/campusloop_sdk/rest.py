"""Requests to /api/v1: repeated if the connection fails, refused with a typed error, listed page by page."""

import asyncio
import random
import uuid
from collections.abc import AsyncIterator, Mapping, Sequence
from typing import TypeVar
from urllib.parse import urljoin

import httpx
import msgspec

from campusloop_sdk.backoff import pauses
from campusloop_sdk.errors import (
    BY_STATUS,
    AnswerUnreadable,
    ConnectionLost,
    FieldProblem,
    RequestRefused,
    ServerFault,
    TooMany,
)

T = TypeVar("T")
Params = Mapping[str, str | int | float | bool | Sequence[str] | None]

ATTEMPTS = 5
# A proxy answers these while a server starts or is replaced.
REPEATABLE = frozenset({502, 503, 504})


class _Problem(msgspec.Struct, frozen=True):
    code: str
    detail: str
    rule: str = ""
    errors: list[dict[str, str]] = []


class Rest:
    """attempts: how often a request is sent at most; an idempotency key makes repeated commands harmless."""

    def __init__(self, http: httpx.AsyncClient, rng: random.Random, attempts: int = ATTEMPTS) -> None:
        self._http, self._rng, self._attempts = http, rng, attempts

    async def get(self, path: str, kind: type[T], params: Params | None = None) -> T:
        return _decoded(await self._send("GET", path, params), kind)

    async def listed(self, path: str, kind: type[T], params: Params | None = None) -> AsyncIterator[T]:
        """The items of all pages, each page read when it is needed."""
        answer = await self._send("GET", path, params)
        while True:
            for item in _decoded(answer, list[kind]):  # type: ignore[valid-type]
                yield item
            following = answer.links.get("next", {}).get("url")
            if following is None:
                return
            answer = await self._send("GET", urljoin(str(answer.url), following), None)

    async def command(
        self,
        method: str,
        path: str,
        kind: type[T],
        *,
        params: Params | None = None,
        body: object = None,
        key: str | None = None,
    ) -> T:
        """key: names the command across repeats, also by another run of the script; None: a new one."""
        headers = {"Idempotency-Key": key or str(uuid.uuid4())}
        content = b"" if body is None else msgspec.json.encode(body)
        if body is not None:
            headers["Content-Type"] = "application/json"
        answer = await self._send(method, path, params, headers, content)
        return _decoded(answer, kind)

    async def _send(
        self,
        method: str,
        path: str,
        params: Params | None,
        headers: Mapping[str, str] | None = None,
        content: bytes = b"",
    ) -> httpx.Response:
        waits = pauses(self._rng)
        given = {
            name: list(value) if isinstance(value, (list, tuple)) else value
            for name, value in (params or {}).items()
            if value is not None
        }
        for attempt in range(1, self._attempts + 1):
            is_last = attempt == self._attempts
            try:
                answer = await self._http.request(
                    method, path, params=given or None, headers=headers, content=content or None
                )
            except httpx.TransportError as error:
                if is_last:
                    raise ConnectionLost(f"no answer in {attempt} attempts: {error!r}") from error
            else:
                if answer.is_success:
                    return answer
                if is_last or answer.status_code not in REPEATABLE:
                    raise _refusal(answer)
            await asyncio.sleep(next(waits))
        raise ConnectionLost("no attempt was allowed")


def _decoded(answer: httpx.Response, kind: type[T]) -> T:
    if answer.status_code == 204:
        return None  # type: ignore[return-value]
    try:
        return msgspec.json.decode(answer.content, type=kind)
    except msgspec.DecodeError as error:
        raise AnswerUnreadable(f"{answer.request.method} {answer.request.url.path}: {error}") from error


def _refusal(answer: httpx.Response) -> RequestRefused | ServerFault:
    kind = BY_STATUS.get(answer.status_code)
    try:
        problem = msgspec.json.decode(answer.content, type=_Problem)
    except msgspec.DecodeError:
        return ServerFault(f"{answer.status_code} {answer.reason_phrase}")
    if kind is None:
        return ServerFault(f"{problem.detail} ({problem.code})")
    retry_after_s = float(answer.headers.get("Retry-After", 0.0)) if kind is TooMany else 0.0
    return kind(
        problem.code,
        problem.detail,
        status=answer.status_code,
        rule=problem.rule,
        fields=tuple(FieldProblem(one.get("where", ""), one.get("message", "")) for one in problem.errors),
        retry_after_s=retry_after_s,
    )

"""Requests made from the OpenAPI document, and messages from the methods of the developer socket.

Only an answer of 500 or more, or a socket that ends as failed, counts: what the server refuses is right.
"""

import asyncio
import json
import random
from collections.abc import Awaitable, Iterator
from typing import Any

import httpx
import schemathesis
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis.errors import Unsatisfiable
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from benchmarks.attacks.target import ROLES, Target, bearer
from server.api.routers import bare_app
from server.api.sockets.json_rpc import BATCH_MAX

AT_A_TIME = 50
SOCKET_SHARE = 10
INTERNAL_ERROR = 1011
ANSWERED_WITHIN_S = 40.0
PROGRESS_EVERY = 1_000
ODD: tuple[Any, ...] = ("", "x" * 300, -1, 1 << 70, 1e308, None, True, [], {}, "\x00", "shuttle-1", "NN7")


async def fuzz(target: Target, requests: int, seed_number: int) -> dict[str, int]:
    """How many were sent, and how many failed."""
    operations = [
        one.ok() for one in schemathesis.openapi.from_dict(bare_app().openapi()).get_all_operations()
    ]
    rng = random.Random(seed_number)
    session, secret = await target.session(*ROLES), (await target.token("read", "drive")).secret
    sent = errors = 0
    while sent < requests:
        operation = rng.choice(operations)
        if operation.path.endswith("/session") and operation.method.upper() == "DELETE":
            continue
        cases = list(_cases(operation, rng.getrandbits(32)))
        tried = [
            _in_time(_fails(target, case, rng.choice((session.headers, bearer(secret), {}))), operation.path)
            for case in cases
        ]
        errors += sum(await asyncio.gather(*tried))
        sent += len(cases)
        if sent // PROGRESS_EVERY > (sent - len(cases)) // PROGRESS_EVERY:
            print(f"{sent} requests, {errors} failed", flush=True)
    for _ in range(requests // SOCKET_SHARE):
        sent += 1
        errors += await _in_time(_socket_fails(target, rng, secret), "/ws/developer")
    return {"requests": sent, "server_errors": errors}


async def _in_time(tried: Awaitable[bool], path: str) -> bool:
    """Whether it fails; no answer in time is a failure as well."""
    try:
        async with asyncio.timeout(ANSWERED_WITHIN_S):
            return await tried
    except TimeoutError:
        print("no answer:", path, flush=True)
        return True


def _cases(operation: Any, number: int) -> Iterator[Any]:
    made: list[Any] = []

    @seed(number)
    @settings(
        max_examples=AT_A_TIME,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(case=operation.as_strategy())
    def collect(case: Any) -> None:
        made.append(case)

    try:
        collect()
    except Unsatisfiable:
        return
    yield from made


async def _fails(target: Target, case: Any, headers: dict[str, str]) -> bool:
    asked = case.as_transport_kwargs(base_url=target.settings.origin())
    own = ("host", "authorization", "cookie", "x-csrf-token")
    made = asked.get("headers") or {}
    wanted = {name: value for name, value in made.items() if name.lower() not in own} | headers
    content = asked.get("data")
    if asked.get("json") is not None:
        content = json.dumps(asked["json"]).encode("utf-8", "surrogatepass")
        wanted["Content-Type"] = "application/json"
    target.http.cookies.clear()
    try:
        answer = await target.http.request(
            asked["method"],
            asked["url"],
            params=asked.get("params"),
            headers={k: v for k, v in wanted.items() if str(v).isascii()},
            content=content,
        )
    except (UnicodeError, ValueError, httpx.LocalProtocolError, httpx.InvalidURL):
        # The client cannot even write it.
        return False
    if answer.status_code >= 500 and answer.json().get("code") == "server_fault":
        print("server error:", asked["method"], asked["url"], asked.get("params"), content, answer.text[:200])
        return True
    return False


async def _socket_fails(target: Target, rng: random.Random, secret: str) -> bool:
    methods = ("list_vehicles", "list_rides", "send_to_stop", "pause", "resume", "subscribe", "no_method")
    names = ("vehicle_id", "stop_id", "topics", "limit", "states", "dry_run", "idempotency_key", "x")
    params = {name: rng.choice(ODD) for name in rng.sample(names, rng.randint(0, 4))}
    request: Any = {"jsonrpc": "2.0", "id": rng.choice(ODD), "method": rng.choice(methods), "params": params}
    if rng.random() < 0.1:
        request = [request] * rng.randint(0, BATCH_MAX + 1)
    try:
        url = target.websocket("/ws/developer")
        async with connect(url, additional_headers=bearer(secret), proxy=None) as socket:
            await socket.send(json.dumps(request))
            await socket.send('{"jsonrpc":"2.0","id":1,"method":"list_stops"}')
            await socket.recv()
    except ConnectionClosed as closed:
        return closed.rcvd is not None and closed.rcvd.code == INTERNAL_ERROR
    return False

"""Requests made from the OpenAPI document.

Only an answer of 500 or more counts: what the server refuses is right.
"""

import asyncio
import json
import random
from collections.abc import Awaitable
from typing import Any

import httpx
import schemathesis

from benchmarks.attacks.generation import cases
from benchmarks.attacks.target import ROLES, Target, bearer
from server.api.routers import bare_app

AT_A_TIME = 50
ANSWERED_WITHIN_S = 40.0
PROGRESS_EVERY = 1_000


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
        made = cases(operation, rng.getrandbits(32), AT_A_TIME)
        tried = [
            _in_time(_fails(target, case, rng.choice((session.headers, bearer(secret), {}))), operation.path)
            for case in made
        ]
        errors += sum(await asyncio.gather(*tried))
        sent += len(made)
        if sent // PROGRESS_EVERY > (sent - len(made)) // PROGRESS_EVERY:
            print(f"{sent} requests, {errors} failed", flush=True)
    return {"requests": sent, "server_errors": errors}


async def _in_time(tried: Awaitable[bool], path: str) -> bool:
    """Whether it fails; no answer in time is a failure as well."""
    try:
        async with asyncio.timeout(ANSWERED_WITHIN_S):
            return await tried
    except TimeoutError:
        print("no answer:", path, flush=True)
        return True


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

"""Clients that take too much, ask oddly, or hold what was taken from them."""

import asyncio
import socket as sockets
import time

import httpx
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from benchmarks.faults.installation import PASSWORD
from benchmarks.faults.stage import Stage, require

REVOKED_WITHIN_S = 2.0
ANSWER_S_MAX = 5.0


async def endless_header(stage: Stage) -> None:
    """A request whose head never ends: it must be refused before 2 MiB are taken."""
    _, writer = await asyncio.open_connection("127.0.0.1", stage.installation.port)
    writer.write(b"GET / HTTP/1.1\r\nhost: campus\r\n")
    sent = 0
    try:
        while sent < 20_000_000:
            writer.write(b"x-pad: " + 60_000 * b"p" + b"\r\n")
            await writer.drain()
            sent += 60_000
            await asyncio.sleep(0.002)
    except ConnectionError:
        require(sent < 2_000_000, f"{sent} bytes of head were taken")
        return
    require(False, f"{sent} bytes of head were taken")


async def half_heads(stage: Stage) -> None:
    """200 raw sockets send half a head and wait: all must be closed within 30 s."""
    held = []
    for _ in range(200):
        raw = sockets.create_connection(("127.0.0.1", stage.installation.port))
        raw.sendall(b"GET / HTTP/1.1\r\nho")
        raw.setblocking(False)
        held.append(raw)
    await _answers_quickly(stage)

    async def all_closed() -> bool:
        return sum(_is_closed(raw) for raw in held) == len(held)

    try:
        await stage.until(all_closed, "200 half heads are closed", 30.0)
    finally:
        for raw in held:
            raw.close()


async def readers_of_the_map(stage: Stage) -> None:
    """16 clients read the campus map for 10 s without a pause."""

    async def read() -> None:
        async with httpx.AsyncClient(base_url=stage.installation.origin, trust_env=False) as http:
            while True:
                (await http.get("/api/v1/campus/map", timeout=30.0)).raise_for_status()

    readers = [asyncio.create_task(read()) for _ in range(16)]
    await asyncio.sleep(10.0)
    await _answers_quickly(stage)
    for reader in readers:
        reader.cancel()
    for result in await asyncio.gather(*readers, return_exceptions=True):
        require(isinstance(result, asyncio.CancelledError), f"the map was not answered: {result!r}")


async def wrong_logins(stage: Stage) -> None:
    """60 wrong passwords at once."""
    wrong = {"name": "operator", "password": "guess"}
    tries = [
        asyncio.create_task(stage.installation.http.post("/session", json=wrong, timeout=60.0))
        for _ in range(60)
    ]
    await asyncio.sleep(1.0)
    await _answers_quickly(stage)
    answers = await asyncio.gather(*tries)
    require({answer.status_code for answer in answers} <= {401, 429}, "a wrong password was let in")


async def odd_questions(stage: Stage) -> None:
    """Moments at the ends of the calendar, huge numbers, broken tokens: none may be a server error."""
    moments = ("0001-01-01T00:00:00+14:00", "9999-12-31T23:59:59-14:00", "2026-02-30T00:00:00Z", "x")
    paths = [f"/rides?before={moment}" for moment in moments]
    paths += [f"/travel-times?since={moment}" for moment in moments]
    paths += [
        "/rides?limit=99999999999999999999",
        "/rides/%00",
        "/rides/" + 5000 * "a",
        "/vehicles/%F0%9F%9A%8C",
    ]
    for path in paths:
        answer = await stage.installation.http.get(path)
        require(answer.status_code < 500, f"GET {path[:60]} answered {answer.status_code}")
    for body in (b"{", b"[]", b'{"party":1e400}', b'{"party":-1}', b"\xff\xfe", b"[" * 10_000):
        answer = await stage.installation.http.post(
            "/rides", content=body, headers={"Content-Type": "application/json"}
        )
        require(answer.status_code < 500, f"POST /rides {body[:20]!r} answered {answer.status_code}")


async def revoked_token(stage: Stage) -> None:
    """A developer's open socket must end within 2 s of the token's revocation."""
    made = await stage.installation.ask("POST", "/developer-tokens", {"name": "script", "scopes": ["read"]})
    headers = {"Authorization": f"Bearer {made['secret']}"}
    async with connect(stage.installation.websocket("/ws/developer"), additional_headers=headers) as opened:
        await opened.send('{"jsonrpc":"2.0","id":1,"method":"subscribe","params":{"topics":["vehicles"]}}')
        await opened.recv()
        await stage.installation.ask("DELETE", f"/developer-tokens/{made['token_id']}")
        await _ends_within(opened, REVOKED_WITHIN_S, "a revoked token's socket")


async def signed_out(stage: Stage) -> None:
    """An operator's live view must end within 2 s of signing out."""
    async with httpx.AsyncClient(base_url=f"{stage.installation.origin}/api/v1", trust_env=False) as http:
        answer = await http.post("/session", json={"name": "operator", "password": PASSWORD})
        cookie = f"campusloop_session={http.cookies['campusloop_session']}"
        async with connect(
            stage.installation.websocket("/ws/live"), additional_headers={"Cookie": cookie}
        ) as opened:
            await opened.send('{"type":"watch"}')
            await opened.recv()
            csrf = {"X-CSRF-Token": answer.json()["csrf_token"]}
            (await http.delete("/session", headers=csrf)).raise_for_status()
            await _ends_within(opened, REVOKED_WITHIN_S, "a signed-out operator's live view")


async def frozen_viewers(stage: Stage) -> None:
    """50 live views connect and never read; memory may grow by a fifth."""
    before = stage.installation.process.memory_info().rss
    cookie = f"campusloop_session={stage.installation.http.cookies['campusloop_session']}"
    opened = []
    for _ in range(50):
        view = await connect(
            stage.installation.websocket("/ws/live"), additional_headers={"Cookie": cookie}, max_queue=1
        )
        await view.send('{"type":"watch"}')
        view.transport.pause_reading()
        opened.append(view)
    await asyncio.sleep(15.0)
    await _answers_quickly(stage)
    after = stage.installation.process.memory_info().rss
    for view in opened:
        view.transport.abort()
    require(after < 1.2 * before, f"memory grew from {before >> 20} to {after >> 20} MiB")


async def _answers_quickly(stage: Stage) -> None:
    begun = time.monotonic()
    await stage.installation.http.get("/health")
    took_s = time.monotonic() - begun
    require(took_s < ANSWER_S_MAX, f"/health took {took_s:.1f} s")


async def _ends_within(opened: ClientConnection, seconds: float, what: str) -> None:
    try:
        async with asyncio.timeout(seconds):
            while True:
                await opened.recv()
    except ConnectionClosed:
        return
    except TimeoutError:
        require(False, f"{what} is open after {seconds:.0f} s")


def _is_closed(raw: sockets.socket) -> bool:
    try:
        while raw.recv(4096):
            pass
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True

"""The websockets under messages made from their AsyncAPI documents.

What the server refuses is right. An error is a close with 4500 or 1011, an answer that says "internal", an
error in the server's log, and a standing task that does not work afterwards. A client that still sends while
it is refused may lose the close frame to a TCP reset (1006). Such ends are counted apart: they are errors if
the log has one, and are to be explained if they are many.
"""

import asyncio
import json
import logging
import random
from collections.abc import AsyncIterator, Iterator, MutableMapping
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from typing import Any

import structlog
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from benchmarks.attacks.socket_messages import SocketMessages
from benchmarks.attacks.target import ROLES, STOPS, Target, bearer, hello
from contract.wire.close_reasons import close_reason
from contract.wire.codec import decode_from_server, encode
from contract.wire.messages import Challenge, Welcome

_AT_A_TIME = 8
_MESSAGES_OF_A_SESSION = 40
_PROGRESS_EVERY = 1_000
_CLOSED_WITHIN_S = 30.0
_SETTLED_WITHIN_S = 30.0
_SERVER_ERRORS = (close_reason("server_fault").number, 1011)
_INTERNAL_ERROR = -32603
_WITHOUT_CLOSE = 1006


@dataclass
class Errors:
    """What the server did wrong. logged: errors in its log"""

    found: list[str] = field(default_factory=list)
    logged: list[str] = field(default_factory=list)

    def note(self, text: str) -> None:
        print("server error:", text[:400], flush=True)
        self.found.append(text)


@dataclass
class _Fuzz:
    target: Target
    messages: SocketMessages
    rng: random.Random
    errors: Errors
    vehicles: list[str]
    rides: list[dict[str, Any]]
    headers: dict[str, list[dict[str, str]]]
    sent: int = 0
    told: int = 0
    ended_without_close: int = 0


async def fuzz_sockets(target: Target, count: int, seed_number: int) -> dict[str, int]:
    """How many messages were sent, what the server did wrong, and how many ends had no close frame."""
    rng = random.Random(f"sockets {seed_number}")
    errors = Errors()
    operator, viewer = await target.session(*ROLES), await target.session("viewer")
    scripts = bearer((await target.token("read", "drive")).secret)
    camera = bearer((await target.token("infrastructure")).secret)
    fuzz = _Fuzz(
        target,
        SocketMessages(rng),
        rng,
        errors,
        [await target.enrol() for _ in range(_AT_A_TIME)],
        [await target.book() for _ in range(3)],
        {
            "/ws/vehicle": [{}],
            "/ws/live": [operator.cookie, viewer.cookie, {}],
            "/ws/developer": [scripts, scripts, {}],
            "/ws/infrastructure": [camera, camera, scripts],
        },
    )
    with _logged(errors):
        await asyncio.gather(*(_sessions(fuzz, vehicle_id, count) for vehicle_id in fuzz.vehicles))
        await _until_settled(target, errors)
    return {
        "messages": fuzz.sent,
        "server_errors": len(errors.found) + len(errors.logged),
        "ended_without_close": fuzz.ended_without_close,
    }


async def _sessions(fuzz: _Fuzz, vehicle_id: str, count: int) -> None:
    """One after the other, each of a socket drawn. vehicle_id: the one that this series speaks for"""
    while fuzz.sent < count:
        address = fuzz.rng.choice(("/ws/vehicle", "/ws/vehicle", *fuzz.messages.addresses))
        headers = fuzz.rng.choice(fuzz.headers[address])
        try:
            async with _opened(fuzz, address, headers) as socket:
                await _speak(fuzz, socket, address, vehicle_id)
        except (TimeoutError, OSError) as error:
            fuzz.errors.note(f"{address}: {type(error).__name__} {error}")
        if fuzz.sent >= fuzz.told + _PROGRESS_EVERY:
            fuzz.told = fuzz.sent
            print(f"{fuzz.sent} messages, {len(fuzz.errors.found)} errors", flush=True)


@asynccontextmanager
async def _opened(fuzz: _Fuzz, address: str, headers: dict[str, str]) -> AsyncIterator[ClientConnection]:
    """Its close code is judged at the end."""
    url = fuzz.target.websocket(address)
    async with connect(url, additional_headers=headers, proxy=None, max_size=None) as socket:
        yield socket
    fuzz.ended_without_close += socket.close_code == _WITHOUT_CLOSE
    if socket.close_code in _SERVER_ERRORS:
        fuzz.errors.note(f"{address}: closed with {socket.close_code} {socket.close_reason}")


async def _speak(fuzz: _Fuzz, socket: ClientConnection, address: str, vehicle_id: str) -> None:
    session: dict[str, Any] = {"vehicle_id": vehicle_id, "epoch": 0, "next": 0, "nonce": ""}
    reading = asyncio.create_task(_read(fuzz, socket, address, session))
    try:
        if address == "/ws/vehicle" and fuzz.rng.random() < 0.8:
            await _greet(fuzz, socket, session)
        for _ in range(fuzz.rng.randint(1, _MESSAGES_OF_A_SESSION)):
            data = fuzz.messages.next(address, lambda name, value: _filled(fuzz, session, name, value))
            # Text frames are UTF-8 by RFC 6455; other bytes go as a binary frame.
            await socket.send(data, text=_is_text(data))
            fuzz.sent += 1
            await asyncio.sleep(0)
        await asyncio.sleep(fuzz.rng.uniform(0.0, 0.05))
    except ConnectionClosed:
        return
    finally:
        async with asyncio.timeout(_CLOSED_WITHIN_S):
            await socket.close()
            await reading


async def _greet(fuzz: _Fuzz, socket: ClientConnection, session: dict[str, Any]) -> None:
    """A right hello, as a vehicle with its own key says it."""
    while not session["nonce"]:
        await asyncio.sleep(0.002)
        if socket.close_code is not None:
            return
    vehicle_id = session["vehicle_id"]
    await socket.send(encode(hello(vehicle_id, fuzz.target.keys[vehicle_id], session["nonce"])).decode())
    for _ in range(2_000):
        if session["epoch"] or socket.close_code is not None:
            return
        await asyncio.sleep(0.005)


async def _read(fuzz: _Fuzz, socket: ClientConnection, address: str, session: dict[str, Any]) -> None:
    try:
        async for data in socket:
            if address == "/ws/vehicle":
                _note_session(session, data)
            elif address == "/ws/developer":
                _check_answers(fuzz, json.loads(data))
    except ConnectionClosed:
        return


def _note_session(session: dict[str, Any], data: str | bytes) -> None:
    message = decode_from_server(data)
    if isinstance(message, Challenge):
        session["nonce"] = message.nonce
    elif isinstance(message, Welcome):
        stored = {log.boot_id: log.first_unacknowledged for log in message.acknowledged}
        session["next"] = stored.get("boot-1", 0)
        session["epoch"] = message.epoch


def _check_answers(fuzz: _Fuzz, answers: Any) -> None:
    for answer in answers if isinstance(answers, list) else [answers]:
        if isinstance(answer, dict) and (answer.get("error") or {}).get("code") == _INTERNAL_ERROR:
            fuzz.errors.note(f"/ws/developer: {answer}")


def _filled(fuzz: _Fuzz, session: dict[str, Any], name: str, value: Any) -> Any:
    """Most messages have what gets them past the first check, so that what is behind it is reached."""
    rng = fuzz.rng
    if not isinstance(value, dict) or rng.random() < 0.1:
        return value
    ride = rng.choice(fuzz.rides)
    known: dict[str, Any] = {
        "type": value.get("type", name),
        "epoch": session["epoch"],
        "boot_id": "boot-1",
        "vehicle_id": rng.choice(fuzz.vehicles),
        "stop_id": rng.choice(STOPS),
        "nonce": session["nonce"],
        "ride_id": ride["ride_id"],
        "ride_token": rng.choice(("", ride["token"])),
        "jsonrpc": "2.0",
    }
    filled = _with_known(value, known)
    if name == "event":
        filled["sequence"] = session["next"] + rng.choice((0, 0, 0, -1, 1))
        session["next"] = max(session["next"], filled["sequence"] + 1)
    return filled


def _with_known(value: Any, known: dict[str, Any]) -> Any:
    if isinstance(value, dict):
        return {
            key: known[key] if key in known and isinstance(one, str | int) else _with_known(one, known)
            for key, one in value.items()
        }
    if isinstance(value, list):
        return [_with_known(one, known) for one in value]
    return value


def _is_text(data: bytes) -> bool:
    try:
        data.decode()
    except UnicodeDecodeError:
        return False
    return True


async def _until_settled(target: Target, errors: Errors) -> None:
    """Every standing task must work, and a booking be answered."""
    answer, tries = None, int(_SETTLED_WITHIN_S)
    for _ in range(tries):
        answer = await target.ask("GET", "/ready")
        if all(task["state"] == "good" for task in answer.json()["tasks"]):
            break
        await asyncio.sleep(1.0)
    else:
        assert answer is not None
        errors.note(f"standing tasks do not work: {answer.text}")
    booked = await target.book()
    if "ride_id" not in booked:
        errors.note(f"a booking failed: {booked}")


class _Handler(logging.Handler):
    def __init__(self, errors: Errors) -> None:
        super().__init__(logging.ERROR)
        self._errors = errors

    def emit(self, record: logging.LogRecord) -> None:
        _note_logged(self._errors, f"{record.name}: {record.getMessage()} {record.exc_info}")


def _note_logged(errors: Errors, text: str) -> None:
    print("logged error:", text[:600], flush=True)
    errors.logged.append(text)


@contextmanager
def _logged(errors: Errors) -> Iterator[None]:
    """Collect the errors that the server, which runs in this process, writes to its log."""

    def collect(_logger: Any, _method: str, event: MutableMapping[str, Any]) -> Any:
        _note_logged(errors, repr(dict(event)))
        raise structlog.DropEvent

    before = structlog.get_config()
    structlog.configure(
        processors=[collect],
        wrapper_class=structlog.make_filtering_bound_logger(logging.ERROR),
        cache_logger_on_first_use=False,
    )
    handler = _Handler(errors)
    logging.getLogger().addHandler(handler)
    try:
        yield
    finally:
        logging.getLogger().removeHandler(handler)
        structlog.configure(**before)

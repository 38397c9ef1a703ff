"""Attacks by vehicles and by those who pose as one."""

import base64
import hashlib
import json
from dataclasses import replace
from typing import Any

import msgspec
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from benchmarks.attacks.attack import allows, allows_async, attack
from benchmarks.attacks.target import MAP, Target, bearer, hello, public
from contract.roads.load import load_map
from contract.wire.codec import decode_from_server, encode
from contract.wire.messages import Challenge, CommandDone, EventReport, Hello, Welcome
from server.api.runs import segments
from server.fleet import hello as hellos
from server.fleet import link, session
from server.store.record.identity import SqlIdentityRepository
from server.usecases.fleet import vehicles


def _modules_with(name: str) -> tuple[Any, ...]:
    return tuple(module for module in (hellos, link, session) if hasattr(module, name))


_ANY_SIGNATURE = tuple((module, "verify_signature", allows) for module in _modules_with("verify_signature"))
_ANY_NONCE = tuple((module, "check_hello", allows) for module in _modules_with("check_hello"))


async def _challenge(socket: ClientConnection) -> str:
    message = decode_from_server(await socket.recv())
    assert isinstance(message, Challenge)
    return message.nonce


async def _is_greeted(target: Target, greeting: Any) -> bool:
    """greeting: makes the hello of a nonce."""
    async with connect(target.websocket("/ws/vehicle"), proxy=None) as socket:
        made: Hello = greeting(await _challenge(socket))
        await socket.send(encode(made).decode())
        try:
            return isinstance(decode_from_server(await socket.recv()), Welcome)
        except ConnectionClosed:
            return False


@attack("the signature of a hello", *_ANY_SIGNATURE)
async def a_stranger_poses_as_a_vehicle(target: Target) -> bool:
    vehicle_id, key = await target.enrol(), Ed25519PrivateKey.generate()
    return await _is_greeted(target, lambda nonce: hello(vehicle_id, key, nonce))


@attack("the signature of a hello", *_ANY_SIGNATURE)
async def a_vehicle_poses_as_another(target: Target) -> bool:
    mine, theirs = await target.enrol(), await target.enrol()
    return await _is_greeted(target, lambda nonce: hello(theirs, target.keys[mine], nonce))


@attack("the signature covers the vehicle", *_ANY_SIGNATURE)
async def a_signed_hello_is_renamed(target: Target) -> bool:
    mine, theirs = await target.enrol(), await target.enrol()

    def renamed(nonce: str) -> Hello:
        return msgspec.structs.replace(hello(mine, target.keys[mine], nonce), vehicle_id=theirs)

    return await _is_greeted(target, renamed)


@attack("the nonce of a connection", *_ANY_NONCE)
async def a_hello_is_replayed(target: Target) -> bool:
    vehicle_id = await target.enrol()
    recorded: list[Hello] = []

    def record(nonce: str) -> Hello:
        recorded.append(hello(vehicle_id, target.keys[vehicle_id], nonce))
        return recorded[0]

    assert await _is_greeted(target, record)
    return await _is_greeted(target, lambda _: recorded[0])


@attack("the nonce of a connection", *_ANY_NONCE)
async def the_nonce_of_another_connection_is_signed(target: Target) -> bool:
    vehicle_id = await target.enrol()
    async with connect(target.websocket("/ws/vehicle"), proxy=None) as other:
        stolen = await _challenge(other)
        return await _is_greeted(target, lambda _: hello(vehicle_id, target.keys[vehicle_id], stolen))


@attack("a revoked key opens nothing", (vehicles, "_key", lambda uow, vehicle_id: _any_key(uow, vehicle_id)))
async def a_revoked_key_says_hello(target: Target) -> bool:
    vehicle_id = await target.enrol()
    await target.do(lambda uow: vehicles.revoke_key(uow, vehicle_id, "attacks"))
    return await _is_greeted(target, lambda nonce: hello(vehicle_id, target.keys[vehicle_id], nonce))


def _any_key(uow: Any, vehicle_id: str) -> Any:
    return uow.identity.vehicle_key(vehicle_id)


async def _enrols(target: Target, code: str, vehicle_id: str) -> bool:
    body = {"code": code, "vehicle_id": vehicle_id, "public_key": public(Ed25519PrivateKey.generate())}
    return (await target.ask("POST", "/enrolments", json=body)).status_code == 201


async def _code(target: Target, vehicle_id: str) -> str:
    session_of_admin = await target.session("admin")
    body = {"vehicle_id": vehicle_id, "name": vehicle_id}
    made = await target.ask("POST", "/enrolments/codes", session_of_admin.headers, json=body)
    code: str = made.json()["code"]
    return code


def _keep_unused(self: SqlIdentityRepository, code: Any) -> None:
    _SAVE_CODE(self, replace(code, used_at=None))


_SAVE_CODE = SqlIdentityRepository.save_enrolment_code


@attack("an enrolment code works once", (SqlIdentityRepository, "save_enrolment_code", _keep_unused))
async def an_enrolment_code_is_used_twice(target: Target) -> bool:
    vehicle_id = target.fresh("vehicle")
    code = await _code(target, vehicle_id)
    await _enrols(target, code, vehicle_id)
    return await _enrols(target, code, vehicle_id)


@attack("an enrolment code is for one vehicle")
async def a_code_enrols_another_vehicle(target: Target) -> bool:
    code = await _code(target, target.fresh("vehicle"))
    return await _enrols(target, code, await target.enrol())


@attack("enrolment codes are secrets")
async def a_guessed_code_enrols_a_key(target: Target) -> bool:
    return await _enrols(target, "A" * 32, await target.enrol())


async def _uploads(target: Target, vehicle_id: str, key: Ed25519PrivateKey) -> bool:
    """The upload is taken for the vehicle's: its bytes are then found to be no run segment."""
    data = b"no segment"
    sha256 = hashlib.sha256(data).hexdigest()
    text = f"campusloop-segment\n{vehicle_id}\n{sha256}".encode()
    headers = {
        "Vehicle-Id": vehicle_id,
        "Vehicle-Signature": base64.b64encode(key.sign(text)).decode(),
        "Segment-Signature": base64.b64encode(key.sign(text)).decode(),
        segments.SIGNATURE_HEADER: base64.b64encode(key.sign(text)).decode(),
        "Content-Type": "application/octet-stream",
    }
    answer = await target.ask("PUT", f"/runs/segments/{sha256}", headers, content=data)
    return bool(answer.json().get("code") == "segment_unreadable")


_ANY_UPLOAD = (segments, "_check_signature", allows_async)


@attack("uploads are signed", _ANY_UPLOAD)
async def a_vehicle_uploads_for_another(target: Target) -> bool:
    mine, theirs = await target.enrol(), await target.enrol()
    return await _uploads(target, theirs, target.keys[mine])


@attack("uploads are signed", _ANY_UPLOAD)
async def a_stranger_uploads_for_a_vehicle(target: Target) -> bool:
    return await _uploads(target, await target.enrol(), Ed25519PrivateKey.generate())


@attack("a vehicle answers its own commands only")
async def a_vehicle_answers_a_command_to_another(target: Target) -> bool:
    mine, theirs = await target.enrol(), await target.enrol()
    secret = (await target.token("read", "drive")).secret
    made = await target.ask("POST", f"/vehicles/{theirs}/hold", bearer(secret))
    command_id: str = made.json()["command_id"]
    version = load_map(MAP).map_version
    async with connect(target.websocket("/ws/vehicle"), proxy=None) as socket:
        greeting = hello(mine, target.keys[mine], await _challenge(socket), version)
        await socket.send(encode(greeting).decode())
        welcome = decode_from_server(await socket.recv())
        assert isinstance(welcome, Welcome)
        forged = EventReport(welcome.epoch, "boot-1", 0, 1, CommandDone(command_id, True, ""))
        await socket.send(encode(forged).decode())
        await _until_acknowledged(socket)
    command = await target.transactions.read(lambda uow: uow.vehicles.command(command_id))
    return command is not None and command.state != "pending"


async def _until_acknowledged(socket: ClientConnection) -> None:
    for _ in range(20):
        if "acknowledged" in str(await socket.recv()):
            return


@attack("scope infrastructure on /ws/infrastructure")
async def a_reading_token_reports_presence(target: Target) -> bool:
    secret = (await target.token("read", "drive")).secret
    try:
        async with connect(
            target.websocket("/ws/infrastructure"), additional_headers=bearer(secret), proxy=None
        ) as socket:
            message = json.loads(await socket.recv())
            return message.get("code") != "scope_missing"
    except ConnectionClosed:
        return False


@attack("malformed frames end the connection")
async def garbage_is_taken_for_a_hello(target: Target) -> bool:
    async with connect(target.websocket("/ws/vehicle"), proxy=None) as socket:
        await _challenge(socket)
        await socket.send(b"\xff\xfe" * 1000)
        try:
            return isinstance(decode_from_server(await socket.recv()), Welcome)
        except ConnectionClosed:
            return False

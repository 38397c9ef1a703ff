"""Attacks with developer tokens and idempotency keys, and on the links of riders."""

import asyncio
import json
from dataclasses import replace
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from benchmarks.attacks.attack import attack, yes
from benchmarks.attacks.target import Target, bearer
from server.api import commands
from server.api.security.access_watch import AccessWatch
from server.api.sockets.developer_methods import DeveloperMethods
from server.api.sockets.json_rpc import Method
from server.domain.record.answers import KeyedRequest
from server.domain.record.identity import DeveloperToken
from server.domain.rides.ticket_keys import TicketKeys
from server.usecases.record import identity

ENDS_WITHIN_S = 3.0


def _any_scope(uow: Any, secret: str, _: str) -> DeveloperToken:
    token: DeveloperToken = uow.identity.developer_token(identity.sha256_of(secret))
    return token


async def _forever(*_: object) -> None:
    await asyncio.Event().wait()


_ANY_SCOPE = (identity, "developer_of", _any_scope)
_ALWAYS_VALID = (DeveloperToken, "is_valid", yes)
_UNWATCHED = (AccessWatch, "until_refused", _forever)
_ONE_ACCOUNT = (commands, "KeyedRequest", lambda _, key, request: KeyedRequest("all", key, request))


async def _opens(target: Target, secret: str, method: str, path: str) -> bool:
    return (await target.ask(method, path, bearer(secret))).status_code in (200, 202)


async def _holds(target: Target, secret: str) -> bool:
    return await _opens(target, secret, "POST", f"/vehicles/{await target.enrol()}/hold")


@attack("scope drive", _ANY_SCOPE)
async def a_reading_token_holds_a_vehicle(target: Target) -> bool:
    return await _holds(target, (await target.token("read")).secret)


@attack("scope read", _ANY_SCOPE)
async def a_driving_token_reads_rides(target: Target) -> bool:
    return await _opens(target, (await target.token("drive")).secret, "GET", "/rides")


@attack("scope infrastructure opens nothing else", _ANY_SCOPE)
async def a_camera_reads_vehicles(target: Target) -> bool:
    return await _opens(target, (await target.token("infrastructure")).secret, "GET", "/vehicles")


@attack("scope infrastructure opens nothing else", _ANY_SCOPE)
async def a_camera_holds_a_vehicle(target: Target) -> bool:
    return await _holds(target, (await target.token("infrastructure")).secret)


@attack("revocation", _ALWAYS_VALID)
async def a_revoked_token_reads(target: Target) -> bool:
    return await _opens(target, await target.revoked("read"), "GET", "/vehicles")


@attack("revocation", _ALWAYS_VALID)
async def a_revoked_token_holds_a_vehicle(target: Target) -> bool:
    return await _holds(target, await target.revoked("drive"))


@attack("expiry", _ALWAYS_VALID)
async def an_expired_token_reads(target: Target) -> bool:
    return await _opens(target, await target.expired("read"), "GET", "/vehicles")


@attack("only the hash is stored", (identity, "sha256_of", lambda secret: secret))
async def the_stored_hash_is_used_as_a_token(target: Target) -> bool:
    stored = _stored_hash or (await target.token("read")).token.token_sha256
    return await _opens(target, stored, "GET", "/vehicles")


_stored_hash = ""


@attack("tokens do not reach what stays with operators")
async def a_token_of_all_scopes_makes_another_token(target: Target) -> bool:
    secret = (await target.token("read", "drive", "infrastructure")).secret
    body = {"name": "x", "scopes": ["drive"]}
    answer = await target.ask("POST", "/developer-tokens", bearer(secret), json=body)
    return answer.status_code == 201


@attack("tokens do not reach what stays with operators")
async def a_token_of_all_scopes_reads_the_audit_log(target: Target) -> bool:
    secret = (await target.token("read", "drive", "infrastructure")).secret
    return await _opens(target, secret, "GET", "/audit")


@attack("a wrong token is refused, even beside a session")
async def a_wrong_token_falls_back_to_the_session(target: Target) -> bool:
    session = await target.session("viewer")
    answer = await target.ask("GET", "/vehicles", session.cookie | bearer("x" * 32))
    return answer.status_code == 200


@attack("idempotency keys belong to an account", _ONE_ACCOUNT)
async def the_answer_to_another_actors_key_is_read(target: Target) -> bool:
    vehicle_id = await target.enrol()
    path, key = f"/vehicles/{vehicle_id}/hold", {"Idempotency-Key": target.fresh("a-shared-key")}
    first, second = (await target.token("drive")).secret, (await target.token("drive")).secret
    mine = await target.ask("POST", path, bearer(first) | key)
    theirs = await target.ask("POST", path, bearer(second) | key)
    return bool(mine.json()["command_id"] == theirs.json()["command_id"])


# ---------------------------------------------------------------- sockets


async def _answer(socket: ClientConnection, method: str, **params: object) -> dict[str, Any]:
    await socket.send(json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}))
    while True:
        message: dict[str, Any] = json.loads(await socket.recv())
        if message.get("id") == 1:
            return message


async def _calls(target: Target, secret: str, method: str, **params: object) -> bool:
    url = target.websocket("/ws/developer")
    try:
        async with connect(url, additional_headers=bearer(secret), proxy=None) as socket:
            return "result" in await _answer(socket, method, **params)
    except ConnectionClosed:
        return False


_TABLE = DeveloperMethods.table


def _every_method(self: DeveloperMethods) -> dict[str, Method]:
    return {name: replace(method, scope="read") for name, method in _TABLE(self).items()}


@attack("scope drive, on the socket", (DeveloperMethods, "table", _every_method))
async def a_reading_token_pauses_by_socket(target: Target) -> bool:
    secret, vehicle_id = (await target.token("read")).secret, await target.enrol()
    return await _calls(target, secret, "pause", vehicle_id=vehicle_id)


@attack("tokens of /ws/developer")
async def a_stranger_opens_the_developer_socket(target: Target) -> bool:
    return await _calls(target, "x" * 32, "list_vehicles")


@attack("revocation, on the socket", _ALWAYS_VALID)
async def a_revoked_token_opens_the_developer_socket(target: Target) -> bool:
    return await _calls(target, await target.revoked("read"), "list_vehicles")


@attack("open sockets end with their token", _UNWATCHED)
async def a_revoked_token_keeps_listening(target: Target) -> bool:
    made = await target.token("read")
    url = target.websocket("/ws/developer")
    async with connect(url, additional_headers=bearer(made.secret), proxy=None) as socket:
        await _answer(socket, "subscribe", topics=["vehicles"])
        token_id = made.token.token_id
        await target.do(lambda uow: identity.revoke_developer_token(uow, token_id, "attacks"))
        return await _stays_open(socket)


@attack("open sockets end with their session", _UNWATCHED)
async def a_signed_out_browser_keeps_watching(target: Target) -> bool:
    session = await target.session("viewer")
    url = target.websocket("/ws/live")
    async with connect(url, additional_headers=session.cookie, proxy=None) as socket:
        await socket.send('{"type":"watch"}')
        await socket.recv()
        await target.ask("DELETE", "/session", session.headers)
        return await _stays_open(socket)


async def _stays_open(socket: ClientConnection) -> bool:
    try:
        async with asyncio.timeout(ENDS_WITHIN_S):
            while True:
                await socket.recv()
    except ConnectionClosed:
        return False
    except TimeoutError:
        return True


@attack("a batch has a limit")
async def a_batch_of_ten_thousand_is_answered(target: Target) -> bool:
    secret = (await target.token("read")).secret
    url = target.websocket("/ws/developer")
    one = {"jsonrpc": "2.0", "id": 1, "method": "list_vehicles"}
    try:
        async with connect(url, additional_headers=bearer(secret), proxy=None, max_size=None) as socket:
            await socket.send(json.dumps([one] * 10_000))
            return isinstance(json.loads(await socket.recv()), list)
    except ConnectionClosed:
        return False


@attack("frames have a limit")
async def a_frame_of_32_mib_is_taken(target: Target) -> bool:
    secret = (await target.token("read")).secret
    url = target.websocket("/ws/developer")
    try:
        async with connect(url, additional_headers=bearer(secret), proxy=None) as socket:
            await socket.send("x" * (32 << 20))
            return "parse error" in str(await socket.recv())
    except (ConnectionClosed, OSError):
        return False


# ---------------------------------------------------------------- links of riders

_ANY_PROOF = (TicketKeys, "proves_ride", yes)
_PROOF_CHARACTERS = 24


@attack("the proof in a link", _ANY_PROOF)
async def the_link_of_a_ride_opens_another(target: Target) -> bool:
    mine, theirs = await target.book(), await target.book()
    forged = mine["token"][:_PROOF_CHARACTERS] + theirs["token"][_PROOF_CHARACTERS:]
    return (await target.ask("GET", f"/rides/{forged}")).status_code == 200


@attack("the proof in a link", _ANY_PROOF)
async def a_ride_id_and_a_guess_cancel_a_ride(target: Target) -> bool:
    ride = await target.book()
    forged = "A" * _PROOF_CHARACTERS + ride["token"][_PROOF_CHARACTERS:]
    # This campus has no shuttle under way, so the ride itself has ended.
    return (await target.ask("POST", f"/rides/{forged}/cancel")).json().get("code") != "ride_unknown"


@attack("the proof in a link", _ANY_PROOF)
async def a_forged_link_calls_for_help(target: Target) -> bool:
    ride = await target.book()
    forged = "A" * _PROOF_CHARACTERS + ride["token"][_PROOF_CHARACTERS:]
    answer = await target.ask("POST", f"/rides/{forged}/help", json={})
    return answer.json().get("code") != "ride_unknown" and answer.status_code != 422


@attack("the proof in a link, for live views", _ANY_PROOF)
async def a_forged_link_watches_live(target: Target) -> bool:
    ride = await target.book()
    forged = "A" * _PROOF_CHARACTERS + ride["token"][_PROOF_CHARACTERS:]
    async with connect(target.websocket("/ws/live"), proxy=None) as socket:
        await socket.send(json.dumps({"type": "watch", "ride_token": forged}))
        return '"ride_unknown"' not in str(await socket.recv())


@attack("a ride's code allows nothing")
async def a_ride_code_gives_the_link_or_the_boarding_code(target: Target) -> bool:
    ride = await target.book()
    found = await target.ask("GET", f"/rides/lookup?code={ride['ride_code']}")
    return ride["token"] in found.text or f'"{ride["boarding_code"]}"' in found.text


@attack("links and codes are derived from a key outside the database")
async def a_stolen_database_has_links(target: Target) -> bool:
    ride = await target.book()
    files = target.settings.var_dir.glob("campusloop.db*")
    return any(ride["token"].encode() in file.read_bytes() for file in files)


@attack("reading rides needs an operator or a token")
async def a_rider_lists_all_rides(target: Target) -> bool:
    ride = await target.book()
    return await _opens(target, ride["token"], "GET", "/rides")


@attack("erasure is for admins")
async def a_rider_erases_another_ride(target: Target) -> bool:
    ride_id = (await target.book())["token"][_PROOF_CHARACTERS:]
    return await _opens(target, "x" * 32, "POST", f"/rides/id/{ride_id}/erase")


async def prepare(target: Target) -> None:
    """What cannot be made while its control is taken away."""
    global _stored_hash
    _stored_hash = (await target.token("read")).token.token_sha256

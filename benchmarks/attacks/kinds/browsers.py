"""Attacks by way of an operator's browser: cookies, CSRF, rebinding, framing."""

import asyncio
from types import SimpleNamespace
from typing import Any

from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from benchmarks.attacks.attack import allows, attack, yes
from benchmarks.attacks.target import OWN_PASSWORD, PASSWORD, Session, Target
from server.adapters import RandomIds
from server.api.security import access
from server.api.security.headers import SecurityHeaders
from server.api.security.host_check import HostCheck
from server.api.sessions import routes as sessions
from server.api.sockets import live
from server.domain.record.identity import Operator
from server.store.record.identity import SqlIdentityRepository
from server.usecases.record import identity

_ANY_CSRF = (access, "hmac", SimpleNamespace(compare_digest=yes))
_ALL_HOSTS = (HostCheck, "_allows", yes)


async def _holds(target: Target, headers: dict[str, str], **options: Any) -> bool:
    vehicle_id = await target.enrol()
    answer = await target.ask("POST", f"/vehicles/{vehicle_id}/hold", headers, **options)
    return answer.status_code == 202


async def _reads(target: Target, headers: dict[str, str]) -> bool:
    return (await target.ask("GET", "/vehicles", headers)).status_code == 200


@attack("CSRF token", _ANY_CSRF)
async def a_foreign_page_holds_a_vehicle_with_the_cookie(target: Target) -> bool:
    return await _holds(target, (await target.session("safety")).cookie)


@attack("CSRF token", _ANY_CSRF)
async def a_foreign_page_guesses_the_csrf_token(target: Target) -> bool:
    session = await target.session("safety")
    return await _holds(target, session.cookie | {"X-CSRF-Token": "0" * 64})


@attack("CSRF token of the session itself", _ANY_CSRF)
async def the_csrf_token_of_another_session_is_used(target: Target) -> bool:
    mine, theirs = await target.session("viewer"), await target.session("safety")
    return await _holds(target, theirs.cookie | mine.csrf)


@attack("CSRF token", _ANY_CSRF)
async def a_foreign_form_signs_an_operator_out(target: Target) -> bool:
    session = await target.session("viewer")
    form = session.cookie | {"Content-Type": "application/x-www-form-urlencoded"}
    await target.ask("DELETE", "/session", form)
    return not await _reads(target, session.cookie)


@attack("CSRF token", _ANY_CSRF)
async def a_foreign_page_makes_a_token_as_plain_text(target: Target) -> bool:
    session = await target.session("admin")
    headers = session.cookie | {"Content-Type": "application/json"}
    body = b'{"name":"x","scopes":["drive"]}'
    return (await target.ask("POST", "/developer-tokens", headers, content=body)).status_code == 201


@attack(
    "unpredictable session tokens, made at sign-in", (RandomIds, "token", lambda _: "chosen-by-the-thief")
)
async def a_session_is_fixed_before_the_sign_in(target: Target) -> bool:
    chosen = Session("chosen-by-the-thief")
    name = await target.operator("viewer")
    credentials = {"name": name, "password": OWN_PASSWORD}
    await target.ask("POST", "/session", chosen.cookie, json=credentials)
    return await _reads(target, chosen.cookie)


@attack("sign-out ends the session on the server", (identity, "logout", allows))
async def a_stolen_cookie_is_used_after_sign_out(target: Target) -> bool:
    session = await target.session("viewer")
    await target.ask("DELETE", "/session", session.headers)
    return await _reads(target, session.cookie)


@attack("a new password ends the other sessions", (SqlIdentityRepository, "remove_other_sessions", allows))
async def a_stolen_cookie_is_used_after_a_new_password(target: Target) -> bool:
    name = await target.operator("viewer")
    stolen, own = await target.session_of(name), await target.session_of(name)
    change = {"password": OWN_PASSWORD, "new_password": "another long password"}
    await target.ask("POST", "/session/password", own.headers, json=change)
    return await _reads(target, stolen.cookie)


@attack(
    "disabling ends the sessions, and is asked at each request",
    (SqlIdentityRepository, "remove_sessions_of", allows),
    (identity, "operator_of", lambda uow, token: _unchecked(uow, token)),
)
async def a_disabled_operator_goes_on(target: Target) -> bool:
    name, admin = await target.operator("viewer"), await target.session("admin")
    session = await target.session_of(name)
    change = {"roles": [], "disabled": True}
    await target.ask("PUT", f"/operators/{name}", admin.headers, json=change)
    return await _reads(target, session.cookie)


@attack("sessions expire", (identity, "operator_of", lambda uow, token: _unchecked(uow, token)))
async def an_expired_session_goes_on(target: Target) -> bool:
    session = await target.session("viewer")
    sha256 = identity.sha256_of(session.token)
    target.change_rows(
        f"UPDATE operator_sessions SET expires_at = '2020-01-01 00:00:00.000000' "
        f"WHERE token_sha256 = '{sha256}'"
    )
    return await _reads(target, session.cookie)


def _unchecked(uow: Any, token: str) -> tuple[Operator, Any]:
    session = uow.identity.operator_session(identity.sha256_of(token))
    return uow.identity.operator(session.operator_id), session


@attack("only the cookie's header counts")
async def the_session_token_is_given_as_bearer(target: Target) -> bool:
    session = await target.session("viewer")
    return await _reads(target, {"Authorization": f"Bearer {session.token}"})


@attack("only the cookie's header counts")
async def the_session_token_is_given_in_the_url(target: Target) -> bool:
    session = await target.session("viewer")
    return (await target.ask("GET", f"/vehicles?campusloop_session={session.token}")).status_code == 200


def _plain_cookie(response: Any, _: object, name: str, value: str, path: str, __: object) -> None:
    response.set_cookie(name, value, path=path)


@attack("HttpOnly and SameSite=Strict", (sessions, "_set_cookie", _plain_cookie))
async def a_script_or_a_foreign_site_gets_the_cookie(target: Target) -> bool:
    name = await target.operator("viewer")
    answer = await target.ask("POST", "/session", json={"name": name, "password": OWN_PASSWORD})
    cookies = answer.headers.get_list("set-cookie")
    return not all("HttpOnly" in one and "samesite=strict" in one.lower() for one in cookies)


@attack("allowed host names", _ALL_HOSTS)
async def a_rebound_name_reads_the_stops(target: Target) -> bool:
    answer = await target.ask("GET", "/stops", {"Host": "evil.example"})
    return answer.status_code == 200


@attack("allowed host names", _ALL_HOSTS)
async def a_rebound_name_signs_in(target: Target) -> bool:
    credentials = {"name": "operator", "password": PASSWORD}
    answer = await target.ask("POST", "/session", {"Host": "evil.example"}, json=credentials)
    return answer.status_code == 200


async def _watches(target: Target, headers: dict[str, str]) -> bool:
    try:
        async with connect(target.websocket("/ws/live"), additional_headers=headers, proxy=None) as socket:
            await socket.send('{"type":"watch"}')
            return '"snapshot"' in str(await socket.recv())[:200]
    except (ConnectionClosed, InvalidStatus):
        return False


@attack("allowed host names, for websockets too", _ALL_HOSTS)
async def a_rebound_name_watches_live(target: Target) -> bool:
    session = await target.session("viewer")
    reader, writer = await asyncio.open_connection("127.0.0.1", target.settings.port)
    writer.write(
        b"GET /ws/live HTTP/1.1\r\nHost: evil.example\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        + f"Cookie: campusloop_session={session.token}\r\n\r\n".encode()
    )
    status = await reader.readline()
    writer.close()
    return b"101" in status


class _AnyOrigin:
    """Instead of the parsed origin: equal to every host."""

    class _Equal(str):
        __slots__ = ()

        def __eq__(self, _: object) -> bool:
            return True

        __hash__ = str.__hash__

    netloc = _Equal()


@attack("same origin for /ws/live", (live, "urlsplit", lambda _: _AnyOrigin))
async def a_foreign_page_watches_live_with_the_cookie(target: Target) -> bool:
    session = await target.session("viewer")
    return await _watches(target, session.cookie | {"Origin": "https://evil.example"})


@attack("no cross-origin answers")
async def a_foreign_page_reads_answers(target: Target) -> bool:
    answer = await target.ask("GET", "/stops", {"Origin": "https://evil.example"})
    return "access-control-allow-origin" in answer.headers


@attack("no cross-origin answers")
async def a_preflight_allows_foreign_changes(target: Target) -> bool:
    asking = {"Origin": "https://evil.example", "Access-Control-Request-Method": "POST"}
    answer = await target.ask("OPTIONS", "/rides", asking)
    return "access-control-allow-origin" in answer.headers


async def _no_headers(self: Any, scope: Any, receive: Any, send: Any) -> None:
    await self._app(scope, receive, send)


_NO_HEADERS = (SecurityHeaders, "__call__", _no_headers)


@attack("X-Frame-Options and frame-ancestors", _NO_HEADERS)
async def the_console_is_framed(target: Target) -> bool:
    answer = await target.http.get("/console")
    policy = answer.headers.get("content-security-policy", "")
    return answer.headers.get("x-frame-options") != "DENY" and "frame-ancestors" not in policy


@attack("content security policy", _NO_HEADERS)
async def a_written_script_runs_in_the_page(target: Target) -> bool:
    policy = (await target.http.get("/console")).headers.get("content-security-policy", "")
    rules = {rule.split()[0]: rule for rule in policy.split(";") if rule.strip()}
    scripts = rules.get("script-src", rules.get("default-src", "anything 'unsafe-inline'"))
    return "unsafe-inline" in scripts


@attack("referrer policy", _NO_HEADERS)
async def a_link_leaves_by_the_referrer(target: Target) -> bool:
    return (await target.http.get("/")).headers.get("referrer-policy") != "no-referrer"


@attack("nosniff", _NO_HEADERS)
async def an_answer_is_read_as_a_script(target: Target) -> bool:
    return (await target.ask("GET", "/stops")).headers.get("x-content-type-options") != "nosniff"

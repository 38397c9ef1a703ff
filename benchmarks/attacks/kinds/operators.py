"""Attacks by operators who want more than their roles, and by one who has a password or a session."""

from datetime import datetime

import pyotp

from benchmarks.attacks.attack import allows, allows_async, attack
from benchmarks.attacks.target import OWN_PASSWORD, PASSWORD, Session, Target
from server.api.security import access
from server.api.security.client_address import ClientAddresses
from server.api.security.rate_limit import RateLimit
from server.api.sessions import second_factor
from server.domain.record.second_factors import SecondFactor
from server.store.record.second_factors import SqlSecondFactorRepository
from server.usecases.record.identity import PasswordCheck
from server.usecases.record.operators import second_factors

_ANY_ROLE = (access, "_require_role", allows)
_NO_STEP_UP = (access, "require_second_factor", allows_async)
_NO_BUDGETS = (RateLimit, "take", allows)


async def _is_done(target: Target, session: Session, method: str, path: str, body: object = None) -> bool:
    answer = await target.ask(method, path, session.headers, json=body)
    return answer.status_code in (200, 201, 202, 204)


@attack("role safety", _ANY_ROLE)
async def a_viewer_resumes_a_vehicle(target: Target) -> bool:
    vehicle_id = await target.enrol()
    return await _is_done(target, await target.session("viewer"), "POST", f"/vehicles/{vehicle_id}/resume")


@attack("role safety", _ANY_ROLE)
async def a_dispatcher_resumes_a_vehicle(target: Target) -> bool:
    vehicle_id = await target.enrol()
    session = await target.session("dispatcher")
    return await _is_done(target, session, "POST", f"/vehicles/{vehicle_id}/resume")


@attack("role safety", _ANY_ROLE)
async def an_admin_without_the_role_recalls_a_vehicle(target: Target) -> bool:
    vehicle_id = await target.enrol()
    return await _is_done(target, await target.session("admin"), "POST", f"/vehicles/{vehicle_id}/recall")


@attack("role dispatcher", _ANY_ROLE)
async def a_viewer_changes_the_calendar(target: Target) -> bool:
    body = {"kind": "closed", "name": "a day off"}
    session = await target.session("viewer")
    answer = await target.ask("PUT", "/service/exceptions/2030-01-01", session.headers, json=body)
    return answer.status_code not in (401, 403)


@attack("role dispatcher", _ANY_ROLE)
async def a_safety_operator_speaks_to_riders(target: Target) -> bool:
    vehicle_id = await target.enrol()
    path = f"/vehicles/{vehicle_id}/announce"
    return await _is_done(target, await target.session("safety"), "POST", path, {"text": "get off"})


@attack("role admin", _ANY_ROLE)
async def a_viewer_makes_itself_admin(target: Target) -> bool:
    name = await target.operator("viewer")
    body = {"roles": ["admin"]}
    return await _is_done(target, await target.session_of(name), "PUT", f"/operators/{name}", body)


@attack("role admin", _ANY_ROLE)
async def a_dispatcher_makes_an_operator(target: Target) -> bool:
    body = {"name": target.fresh("friend"), "roles": ["admin"]}
    return await _is_done(target, await target.session("dispatcher"), "POST", "/operators", body)


@attack("role admin", _ANY_ROLE)
async def a_dispatcher_resets_the_password_of_an_admin(target: Target) -> bool:
    victim = await target.operator("admin")
    session = await target.session("dispatcher")
    return await _is_done(target, session, "POST", f"/operators/{victim}/password")


@attack("role admin", _ANY_ROLE)
async def a_viewer_makes_a_driving_token(target: Target) -> bool:
    body = {"name": "x", "scopes": ["drive"]}
    return await _is_done(target, await target.session("viewer"), "POST", "/developer-tokens", body)


@attack("role admin", _ANY_ROLE)
async def a_viewer_makes_an_enrolment_code(target: Target) -> bool:
    body = {"vehicle_id": target.fresh("ghost"), "name": "ghost"}
    return await _is_done(target, await target.session("viewer"), "POST", "/enrolments/codes", body)


@attack("role admin", _ANY_ROLE)
async def a_safety_operator_revokes_a_key(target: Target) -> bool:
    vehicle_id = await target.enrol()
    return await _is_done(target, await target.session("safety"), "DELETE", f"/vehicles/{vehicle_id}/key")


@attack("role admin", _ANY_ROLE)
async def a_viewer_reads_the_audit_log(target: Target) -> bool:
    return await _is_done(target, await target.session("viewer"), "GET", "/audit")


@attack("initial passwords open nothing", _ANY_ROLE)
async def an_initial_password_is_used_without_changing_it(target: Target) -> bool:
    return await _is_done(target, await target.session("admin", initial=True), "GET", "/operators")


class _Authenticator:
    """An operator with a second factor, and a session in which it was not checked."""

    def __init__(self, name: str, totp: pyotp.TOTP, recovery: list[str], session: Session) -> None:
        self.name, self.totp, self.recovery, self.session = name, totp, recovery, session


async def _with_second_factor(target: Target) -> _Authenticator:
    name = await target.operator("safety", "admin")
    first = await target.session_of(name)
    made = await target.ask("POST", "/session/second-factor", first.headers, json={"password": OWN_PASSWORD})
    totp = pyotp.TOTP(made.json()["secret"])
    code = {"code": totp.at(target.live.ports.clock.now())}
    confirmed = await target.ask("POST", "/session/second-factor/confirmation", first.headers, json=code)
    return _Authenticator(name, totp, confirmed.json()["recovery_codes"], await target.session_of(name))


async def _checked(target: Target, session: Session, code: str) -> bool:
    body = {"code": code}
    return await _is_done(target, session, "POST", "/session/second-factor/checks", body)


@attack("second factor where a vehicle is set in motion", _NO_STEP_UP)
async def a_thief_of_the_cookie_resumes_a_vehicle(target: Target) -> bool:
    victim, vehicle_id = await _with_second_factor(target), await target.enrol()
    return await _is_done(target, victim.session, "POST", f"/vehicles/{vehicle_id}/resume")


@attack("second factor where access is given", _NO_STEP_UP)
async def a_thief_of_the_cookie_makes_a_driving_token(target: Target) -> bool:
    victim = await _with_second_factor(target)
    body = {"name": "x", "scopes": ["drive"]}
    return await _is_done(target, victim.session, "POST", "/developer-tokens", body)


@attack("second factor where access is given", _NO_STEP_UP)
async def a_thief_of_the_cookie_makes_an_operator(target: Target) -> bool:
    victim = await _with_second_factor(target)
    body = {"name": target.fresh("friend"), "roles": ["safety"]}
    return await _is_done(target, victim.session, "POST", "/operators", body)


@attack("second factor where access is given", _NO_STEP_UP)
async def a_thief_of_the_cookie_resets_the_second_factor(target: Target) -> bool:
    victim = await _with_second_factor(target)
    path = f"/operators/{victim.name}/second-factor"
    return await _is_done(target, victim.session, "DELETE", path)


@attack("only a checked session removes it", (second_factor, "require_second_factor", allows_async))
async def a_thief_of_the_cookie_removes_the_second_factor(target: Target) -> bool:
    victim = await _with_second_factor(target)
    return await _is_done(target, victim.session, "DELETE", "/session/second-factor")


@attack("only a checked session replaces it", (second_factor, "require_second_factor", allows_async))
async def a_thief_with_the_password_replaces_the_second_factor(target: Target) -> bool:
    victim = await _with_second_factor(target)
    body = {"password": OWN_PASSWORD}
    return await _is_done(target, victim.session, "POST", "/session/second-factor", body)


@attack(
    "the password, asked again",
    (PasswordCheck, "passed", lambda self, _: self.operator),
)
async def a_thief_of_the_cookie_sets_up_a_second_factor(target: Target) -> bool:
    session = await target.session("safety")
    return await _is_done(target, session, "POST", "/session/second-factor", {"password": "a guess"})


@attack("a code works once", (SecondFactor, "last_step", property(lambda _: 0, lambda _, __: None)))
async def a_code_is_replayed(target: Target) -> bool:
    victim = await _with_second_factor(target)
    # The code that confirmed the factor: a person who saw the screen has it.
    return await _checked(target, victim.session, victim.totp.at(target.live.ports.clock.now()))


def _two_hours(now: datetime) -> range:
    step = int(now.timestamp()) // 30
    return range(step - 240, step + 2)


_OLD_STEPS = (SecondFactor, "last_step", property(lambda _: 0, lambda _, __: None))


@attack("codes are over after a minute", (second_factors, "steps_around", _two_hours), _OLD_STEPS)
async def a_code_of_an_hour_ago_is_used(target: Target) -> bool:
    victim = await _with_second_factor(target)
    hour_ago = int(target.live.ports.clock.now().timestamp()) - 3600
    return await _checked(target, victim.session, victim.totp.at(hour_ago))


@attack("recovery codes work once", (SqlSecondFactorRepository, "save", allows))
async def a_recovery_code_is_replayed(target: Target) -> bool:
    victim = _prepared.pop() if _prepared else await _with_second_factor(target)
    await _checked(target, victim.session, victim.recovery[0])
    return await _checked(target, victim.session, victim.recovery[0])


_prepared: list[_Authenticator] = []


async def prepare(target: Target) -> None:
    """What cannot be made while its control is taken away."""
    _prepared.extend([await _with_second_factor(target), await _with_second_factor(target)])


@attack(
    "budget of codes, and a lock after 20 wrong ones",
    _NO_BUDGETS,
    (SecondFactor, "is_locked", False),
    budgets=True,
)
async def codes_are_guessed(target: Target) -> bool:
    victim = await _with_second_factor(target)
    real = victim.totp.at(target.live.ports.clock.now())
    guess = {"code": f"{(int(real) + 7) % 1_000_000:06d}"}
    path = "/session/second-factor/checks"
    tried = [await target.ask("POST", path, victim.session.headers, json=guess) for _ in range(25)]
    return all(answer.json()["code"] == "wrong_code" for answer in tried)


@attack("budget of the client's network and of the account", _NO_BUDGETS, budgets=True)
async def a_password_is_guessed(target: Target) -> bool:
    name = await target.operator("admin")
    guesses = [*(f"guess number {number}" for number in range(8)), OWN_PASSWORD]
    answers = [await target.ask("POST", "/session", json={"name": name, "password": one}) for one in guesses]
    return answers[-1].status_code == 200


def _believing(self: ClientAddresses, scope: dict) -> list[str]:  # type: ignore[type-arg]
    return [value.decode() for key, value in scope["headers"] if key == b"x-forwarded-for"]


async def _forwarded(self, scope, receive, send) -> None:  # type: ignore[no-untyped-def]
    if scope["type"] in ("http", "websocket"):
        hops = _believing(self, scope)
        scope = {**scope, "client": (hops[0], 1)} if hops else scope
    await self._app(scope, receive, send)


@attack(
    "forwarded addresses count from named proxies only",
    (ClientAddresses, "__call__", _forwarded),
    budgets=True,
)
async def ride_codes_are_guessed_from_invented_addresses(target: Target) -> bool:
    answers = [
        await target.ask("GET", "/rides/lookup?code=ABC234", {"X-Forwarded-For": f"198.51.100.{number}"})
        for number in range(40)
    ]
    return all(answer.status_code != 429 for answer in answers)


@attack("budget of codes tried", _NO_BUDGETS, budgets=True)
async def ride_codes_are_guessed(target: Target) -> bool:
    answers = [await target.ask("GET", "/rides/lookup?code=ABC234") for _ in range(40)]
    return all(answer.status_code != 429 for answer in answers)


@attack("one answer for wrong names and wrong passwords")
async def names_of_operators_are_found_out(target: Target) -> bool:
    known = await target.ask("POST", "/session", json={"name": "operator", "password": "wrong"})
    unknown = await target.ask("POST", "/session", json={"name": "nobody-here", "password": "wrong"})
    # Every answer has an id of its own.
    known_body, unknown_body = ({**answer.json(), "request_id": ""} for answer in (known, unknown))
    return (known.status_code, known_body) != (unknown.status_code, unknown_body)


@attack("the settings' password is not changed by the API")
async def a_thief_locks_the_first_operator_out(target: Target) -> bool:
    session = await target.session_of("operator")
    body = {"password": PASSWORD, "new_password": "the thief's long password"}
    return await _is_done(target, session, "POST", "/session/password", body)

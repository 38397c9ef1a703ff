"""Attacks on the record: the audit log by one who writes the database, and what must not be in it."""

from benchmarks.attacks.attack import attack
from benchmarks.attacks.target import Target
from server.domain.record import audit as chain
from server.usecases.record import audit

_UNCHECKED = (chain, "_what_is_wrong", lambda _, __: "")


async def _noticed(target: Target, statement: str, undo: str) -> bool:
    """Tried on a log of some entries; mended afterwards, so that the next attack meets a whole log."""
    target.change_rows(statement)
    verdict = await audit.verify(target.transactions)
    target.change_rows(undo)
    return verdict.broken is not None


async def _number(target: Target) -> int:
    """Of an entry that has others before and after it."""
    session, vehicle_id = await target.session("safety"), await target.enrol()
    for _ in range(3):
        await target.ask("POST", f"/vehicles/{vehicle_id}/hold", session.headers)
    return (await target.transactions.read(lambda uow: uow.audit.head())).number - 1


async def _changed(target: Target, column: str, value: str) -> bool:
    number = await _number(target)
    entry = (await target.transactions.read(lambda uow: uow.audit.following(number - 1, 1)))[0]
    before = {
        "made_by": entry.by,
        "outcome": entry.action.outcome,
        "subject": entry.action.subject,
        "address": entry.address,
    }[column]
    change = "UPDATE audit_entries SET {} = '{}' WHERE number = {}"
    return not await _noticed(
        target, change.format(column, value, number), change.format(column, before, number)
    )


@attack("the chain of hashes", _UNCHECKED)
async def an_entry_is_put_on_somebody_else(target: Target) -> bool:
    return await _changed(target, "made_by", "somebody-else")


@attack("the chain of hashes", _UNCHECKED)
async def a_refusal_is_turned_into_a_success(target: Target) -> bool:
    return await _changed(target, "outcome", "role_missing")


@attack("the chain of hashes", _UNCHECKED)
async def an_entry_is_put_on_another_vehicle(target: Target) -> bool:
    return await _changed(target, "subject", "another")


@attack("the hash of the address", _UNCHECKED)
async def an_address_is_forged(target: Target) -> bool:
    return await _changed(target, "address", "198.51.100.1")


@attack("the chain of hashes", _UNCHECKED)
async def an_entry_is_deleted(target: Target) -> bool:
    number = await _number(target)
    away = f"UPDATE audit_entries SET campus_id = 'away' WHERE number = {number}"
    campus = target.live.ports.campus_id
    back = f"UPDATE audit_entries SET campus_id = '{campus}' WHERE campus_id = 'away'"
    return not await _noticed(target, away, back)


@attack("the head that was noted elsewhere")
async def the_end_of_the_log_is_cut_off(target: Target) -> bool:
    number = await _number(target)
    noted = (await target.transactions.read(lambda uow: uow.audit.head())).sha256
    campus = target.live.ports.campus_id
    target.change_rows(f"UPDATE audit_entries SET campus_id = 'away' WHERE number > {number}")
    verdict = await audit.verify(target.transactions)
    target.change_rows(f"UPDATE audit_entries SET campus_id = '{campus}' WHERE campus_id = 'away'")
    return verdict.head.sha256 == noted


@attack("the API has no way to change the log")
async def an_admin_deletes_an_entry_by_the_api(target: Target) -> bool:
    session = await target.session("admin", "safety", "dispatcher")
    methods = ("DELETE", "PUT", "PATCH", "POST")
    answers = [await target.ask(method, "/audit/1", session.headers) for method in methods]
    return any(answer.status_code < 400 for answer in answers)


@attack("what riders are told is not entered")
async def the_log_names_a_rider(target: Target) -> bool:
    session, vehicle_id = await target.session("dispatcher"), await target.enrol()
    body = {"text": "Ms Li, please call us"}
    await target.ask("POST", f"/vehicles/{vehicle_id}/announce", session.headers, json=body)
    newest = await target.transactions.read(lambda uow: uow.audit.newest(5))
    return "Li" in str(newest)


@attack("names without an account are not entered")
async def a_password_typed_as_a_name_is_kept(target: Target) -> bool:
    await target.ask("POST", "/session", json={"name": "hunter2-hunter2", "password": "x"})
    newest = await target.transactions.read(lambda uow: uow.audit.newest(5))
    return "hunter2" in str(newest)

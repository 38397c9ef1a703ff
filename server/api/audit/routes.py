"""The audit log, for admins."""

from typing import Annotated

from fastapi import APIRouter, Depends, Path, Query

from server.api.audit.schemas import (
    AuditEntryView,
    ChainView,
    FollowedEntryView,
    chain_view,
    entry_view,
    followed_view,
)
from server.api.paging import LIMIT_MAX, Page, paged
from server.api.problems import problems
from server.api.security.access import LOOKING_REFUSALS, Actor, looking, now_ns
from server.api.security.permissions import ADMINISTER
from server.api.services import InjectedServices
from server.domain.errors import AuditEntryUnknown
from server.usecases.record import audit

router = APIRouter(prefix="/audit", tags=["audit"])

Admin = Annotated[Actor, Depends(looking(ADMINISTER))]
Filter = Annotated[str | None, Query(max_length=200, pattern=r"^[^\x00-\x1f]*$")]
Number = Annotated[int, Path(ge=1, le=1 << 53, examples=[4711])]


@router.get("", operation_id="list_audit_entries", responses=paged(*LOOKING_REFUSALS))
async def list_audit_entries(
    services: InjectedServices,
    _: Admin,
    page: Page,
    by: Filter = None,
    action: Filter = None,
    subject: Filter = None,
    limit: Annotated[int, Query(ge=1, le=LIMIT_MAX)] = 100,
) -> list[AuditEntryView]:
    """Newest first."""
    ended = page.after(int)
    before = None if ended is None else int(ended[0])
    found = await services.transactions.read(
        lambda uow: uow.audit.newest(limit + 1, before, by, action, subject)
    )
    return [entry_view(one) for one in page.first(found, limit, lambda one: (one.number,))]


@router.get("/verify", operation_id="verify_audit_log", responses=problems(*LOOKING_REFUSALS))
async def verify_audit_log(services: InjectedServices, admin: Admin) -> ChainView:
    """Follow the whole chain. `campusloop audit verify` does the same without the server."""
    services.limits.commands.take(admin.account, now_ns(services))
    return chain_view(await audit.verify(services.transactions))


@router.get(
    "/{number}", operation_id="follow_audit_entry", responses=problems(AuditEntryUnknown, *LOOKING_REFUSALS)
)
async def follow_audit_entry(number: Number, services: InjectedServices, _: Admin) -> FollowedEntryView:
    """An entry, and how the command ended that it made: by the vehicle's answer to the run log."""
    return followed_view(await services.transactions.read(lambda uow: audit.follow(uow, number)))

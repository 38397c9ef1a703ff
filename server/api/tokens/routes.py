"""Tokens for scripts on /ws/developer and for cameras on /ws/infrastructure."""

from typing import Annotated

from fastapi import APIRouter, Depends

from server.api.commands import AccessCommand, AdminCommand
from server.api.formats import TokenId
from server.api.paging import ListLimit, Page, microseconds_of, paged
from server.api.problems import TokenUnknown, problems
from server.api.security.access import (
    LOOKING_REFUSALS,
    OPERATOR_REFUSALS,
    SECOND_FACTOR_REFUSALS,
    Actor,
    looking,
)
from server.api.security.permissions import ADMINISTER
from server.api.services import InjectedServices
from server.api.tokens.schemas import CreatedTokenView, TokenRequest, TokenView
from server.domain.errors import TokenInvalid
from server.domain.record.identity import DeveloperToken
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import identity

router = APIRouter(prefix="/developer-tokens", tags=["developer tokens"])


@router.get("", operation_id="list_tokens", responses=paged(*LOOKING_REFUSALS))
async def list_tokens(
    services: InjectedServices,
    _: Annotated[Actor, Depends(looking(ADMINISTER))],
    page: Page,
    limit: ListLimit = None,
) -> list[TokenView]:
    """Newest first, revoked and expired ones included."""
    tokens = await services.transactions.read(lambda uow: uow.identity.developer_tokens())
    shown = page.cut(tokens, limit, lambda token: (-microseconds_of(token.created_at), token.token_id))
    return [_view(token) for token in shown]


@router.post(
    "",
    operation_id="make_token",
    status_code=201,
    responses=problems(*OPERATOR_REFUSALS, *SECOND_FACTOR_REFUSALS),
)
async def make_token(request: TokenRequest, command: AccessCommand) -> CreatedTokenView:
    """A token that may drive sets vehicles in motion, so this asks for the second factor as well."""
    scopes = sorted(request.scopes)

    def work(uow: UnitOfWork) -> CreatedTokenView:
        valid_s = request.valid_days * 86400.0
        made = identity.create_developer_token(uow, request.name, scopes, valid_s, command.by)
        return CreatedTokenView(**_view(made.token).model_dump(), secret=made.secret)

    about = command.about(request.name, f"scopes {' '.join(scopes)} for {request.valid_days:g} days")
    return await about.transact(CreatedTokenView, work)


@router.delete(
    "/{token_id}",
    operation_id="revoke_token",
    responses=problems(TokenUnknown, *OPERATOR_REFUSALS),
)
async def revoke_token(token_id: TokenId, command: AdminCommand) -> TokenView:
    """Scripts that use it are disconnected."""

    def work(uow: UnitOfWork) -> TokenView:
        return _view(identity.revoke_developer_token(uow, token_id, command.by))

    try:
        return await command.transact(TokenView, work)
    except TokenInvalid as error:
        # 401 would tell the operator's page that its own session is over.
        raise TokenUnknown(f"there is no developer token {token_id}; see GET /developer-tokens") from error


def _view(token: DeveloperToken) -> TokenView:
    return TokenView(
        token_id=token.token_id,
        name=token.name,
        scopes=sorted(token.scopes),
        made_by=token.made_by,
        created_at=token.created_at,
        expires_at=token.expires_at,
        revoked_at=token.revoked_at,
    )

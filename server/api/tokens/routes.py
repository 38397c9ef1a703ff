"""Tokens for scripts on /ws/developer and for cameras on /ws/infrastructure."""

from fastapi import APIRouter

from server.api.formats import TokenId
from server.api.paging import ListLimit, Page, microseconds_of, paged
from server.api.problems import CsrfMissing, TokenUnknown, problems
from server.api.security.access import ChangingOperator, ReadingOperator
from server.api.services import InjectedServices
from server.api.tokens.schemas import CreatedTokenView, TokenRequest, TokenView
from server.domain.errors import SessionExpired, TokenInvalid
from server.domain.record.identity import DeveloperToken
from server.usecases.record import identity

router = APIRouter(prefix="/developer-tokens", tags=["developer tokens"])


@router.get("", operation_id="list_tokens", responses=paged(SessionExpired))
async def list_tokens(
    services: InjectedServices, _: ReadingOperator, page: Page, limit: ListLimit = None
) -> list[TokenView]:
    """Newest first, revoked and expired ones included."""
    tokens = await services.transactions.read(lambda uow: uow.identity.developer_tokens())
    shown = page.cut(tokens, limit, lambda token: (-microseconds_of(token.created_at), token.token_id))
    return [_view(token) for token in shown]


@router.post("", operation_id="make_token", status_code=201, responses=problems(SessionExpired, CsrfMissing))
async def make_token(
    request: TokenRequest, services: InjectedServices, operator: ChangingOperator
) -> CreatedTokenView:
    made = await services.transactions.run(
        lambda uow: identity.create_developer_token(
            uow, request.name, sorted(request.scopes), request.valid_days * 86400.0, operator.name
        )
    )
    return CreatedTokenView(**_view(made.token).model_dump(), secret=made.secret)


@router.delete(
    "/{token_id}",
    operation_id="revoke_token",
    responses=problems(TokenUnknown, SessionExpired, CsrfMissing),
)
async def revoke_token(
    token_id: TokenId, services: InjectedServices, operator: ChangingOperator
) -> TokenView:
    """Scripts that use it are disconnected."""
    try:
        revoked = await services.transactions.run(
            lambda uow: identity.revoke_developer_token(uow, token_id, operator.name)
        )
    except TokenInvalid as error:
        # 401 would tell the operator's page that its own session is over.
        raise TokenUnknown(f"there is no developer token {token_id}; see GET /developer-tokens") from error
    return _view(revoked)


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

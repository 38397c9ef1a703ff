"""Tokens: what a script may do on /ws/developer, or an infrastructure camera on /ws/infrastructure."""

from datetime import datetime
from typing import Annotated

from fastapi import APIRouter
from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from server.api.access import ChangingOperator, ReadingOperator
from server.api.formats import Name, TokenId
from server.api.problems import CsrfMissing, TokenUnknown, problems
from server.api.services import Given
from server.domain.errors import SessionExpired, TokenInvalid
from server.domain.identity import DeveloperToken, Scope
from server.usecases import identity

router = APIRouter(prefix="/developer-tokens", tags=["developer tokens"])

TOKEN_EXAMPLE: JsonDict = {
    "token_id": "token-3",
    "name": "night-tests",
    "scopes": ["drive", "read"],
    "made_by": "operator",
    "created_at": "2026-09-01T08:14:31Z",
    "expires_at": "2026-10-01T08:14:31Z",
    "revoked_at": None,
}


class TokenRequest(BaseModel):
    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"example": {"name": "night-tests", "scopes": ["read", "drive"], "valid_days": 30}},
    )

    name: Name
    scopes: Annotated[set[Scope], Field(min_length=1)]
    valid_days: float = Field(30.0, gt=0, le=366)


class TokenView(BaseModel):
    """A token without its secret."""

    model_config = ConfigDict(json_schema_extra={"example": TOKEN_EXAMPLE})

    token_id: str
    name: str
    scopes: list[Scope]
    made_by: str
    created_at: datetime
    expires_at: datetime
    revoked_at: datetime | None


class MadeTokenView(TokenView):
    """A new token. The secret is shown this once."""

    model_config = ConfigDict(
        json_schema_extra={"example": TOKEN_EXAMPLE | {"secret": "Zk3v7bX0aY5wQ9eR2tU6pA"}}
    )

    secret: str


@router.get("", operation_id="list_tokens", responses=problems(SessionExpired))
async def list_tokens(services: Given, _: ReadingOperator) -> list[TokenView]:
    """Newest first, revoked and expired ones included."""
    return [_view(token) for token in await services.transactions.read(identity.developer_tokens)]


@router.post("", operation_id="make_token", status_code=201, responses=problems(SessionExpired, CsrfMissing))
async def make_token(request: TokenRequest, services: Given, operator: ChangingOperator) -> MadeTokenView:
    made = await services.transactions.run(
        lambda uow: identity.create_developer_token(
            uow, request.name, sorted(request.scopes), request.valid_days * 86400.0, operator.name
        )
    )
    return MadeTokenView(**_view(made.token).model_dump(), secret=made.secret)


@router.delete(
    "/{token_id}",
    operation_id="revoke_token",
    responses=problems(TokenUnknown, SessionExpired, CsrfMissing),
)
async def revoke_token(token_id: TokenId, services: Given, operator: ChangingOperator) -> TokenView:
    """Scripts that use it are disconnected at their next request."""
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

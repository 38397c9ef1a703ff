"""Tokens as operators make and see them."""

from datetime import datetime
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from server.api.formats import Name
from server.domain.record.identity import Scope

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


class CreatedTokenView(TokenView):
    """A new token. The secret is shown this once."""

    model_config = ConfigDict(
        json_schema_extra={"example": TOKEN_EXAMPLE | {"secret": "Zk3v7bX0aY5wQ9eR2tU6pA"}}
    )

    secret: str

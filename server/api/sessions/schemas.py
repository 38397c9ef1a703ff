"""Operators signing in."""

from datetime import datetime

from pydantic import BaseModel, ConfigDict, Field


class Credentials(BaseModel):
    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"example": {"name": "operator", "password": "correct horse battery"}},
    )

    name: str = Field(min_length=1, max_length=64, pattern=r"^[^\x00-\x1f]+$")
    password: str = Field(min_length=1, max_length=256)


class SessionView(BaseModel):
    """The signed-in operator. Send csrf_token in the header X-CSRF-Token with every change."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "name": "operator",
                "csrf_token": "3HqkW9dYx0m2u7aT",
                "expires_at": "2026-09-01T20:14:31Z",
            }
        }
    )

    name: str
    csrf_token: str
    expires_at: datetime

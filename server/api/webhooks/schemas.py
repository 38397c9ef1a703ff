"""Webhooks as developers and operators make and see them."""

from datetime import datetime
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, StringConstraints
from pydantic.config import JsonDict

from server.domain.record.webhooks import URL_CHARACTERS_MAX

WEBHOOK_EXAMPLE: JsonDict = {
    "webhook_id": "webhook-4",
    "url": "https://hooks.example.org/campus",
    "event_types": ["incident.opened", "ride.*"],
    "made_by": "developer:night-tests",
    "created_at": "2026-09-01T08:14:31Z",
    "secret_version": 1,
    "last_success_at": "2026-09-01T09:02:10Z",
    "last_failure_at": None,
    "last_failure": "",
    "failures": 0,
    "failing_since": None,
    "next_attempt_at": None,
    "disabled_at": None,
    "disabled_reason": "",
}
EventType = Annotated[
    str, StringConstraints(min_length=1, max_length=64, pattern=r"^[a-z]+\.(\*|[a-z][a-z_]*)$")
]


class WebhookRequest(BaseModel):
    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {
                "url": "https://hooks.example.org/campus",
                "event_types": ["ride.*", "incident.opened"],
            }
        },
    )

    url: str = Field(min_length=1, max_length=URL_CHARACTERS_MAX, description="https, on a public address.")
    event_types: Annotated[list[EventType], Field(min_length=1, max_length=50)] = Field(
        description="`noun.verb`, or `noun.*` for all events of one noun."
    )


class WebhookView(BaseModel):
    """A webhook without its secret."""

    model_config = ConfigDict(json_schema_extra={"example": WEBHOOK_EXAMPLE})

    webhook_id: str
    url: str
    event_types: list[str]
    made_by: str
    created_at: datetime
    secret_version: int = Field(description="Grows with each new secret.")
    last_success_at: datetime | None
    last_failure_at: datetime | None
    last_failure: str
    failures: int = Field(description="Failed attempts in a row.")
    failing_since: datetime | None
    next_attempt_at: datetime | None
    disabled_at: datetime | None
    disabled_reason: str


class WebhookSecretView(WebhookView):
    """A webhook with a new secret, which is shown this once."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": WEBHOOK_EXAMPLE | {"secret": "whsec_0TuoLr2vNCkYLPl0mMJQ9cTbqvRPJDGXwrJJXhJZ6nY="}
        }
    )

    secret: str


class WebhookTestView(BaseModel):
    """How the address answered to a test message. status 0: it did not answer."""

    model_config = ConfigDict(
        json_schema_extra={"example": {"delivered": True, "status": 204, "failure": ""}}
    )

    delivered: bool
    status: int
    failure: str

"""Notices to browsers about a ride: wanted by the holder of its link, for that browser alone."""

from typing import Annotated

from fastapi import APIRouter, Path
from pydantic import BaseModel, ConfigDict, Field

from server.api.commands import PassengerCommand
from server.api.formats import RideToken
from server.api.problems import problems
from server.api.security.rate_limit import TooManyTries
from server.api.services import InjectedServices
from server.domain.errors import (
    IdempotencyMismatch,
    NoticesUnavailable,
    PushSubscriptionInvalid,
    RideEnded,
    RideUnknown,
)
from server.domain.record.webhooks import URL_CHARACTERS_MAX
from server.domain.rides.notices import Language
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.rides import notices
from server.usecases.rides.tickets import ride_by_token

router = APIRouter(tags=["rides"])

ENDPOINT = "https://push.example/send/f1N8c2"
SUBSCRIPTION_ID = notices.subscription_id_of(ENDPOINT)
SubscriptionId = Annotated[str, Path(pattern=r"^[0-9a-f]{32}$", examples=[SUBSCRIPTION_ID])]


class NoticeKeyView(BaseModel):
    """What a page needs before it asks its browser for a subscription."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "public_key": "BP4z9KsN6nGRTbVYI_c7VJSPQTBtkgcy27mlmlMoZIIg"
                "Dll6e3vCYLocInmYWAmS6TlzAC8wEqKK6PBru3jl7A8"
            }
        }
    )

    public_key: str = Field(
        description="`applicationServerKey`, a point of P-256 in base64url; empty: this server sends none."
    )


class SubscriptionRequest(BaseModel):
    """A browser's push subscription (W3C Push API), with the language of its notices."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {
                "endpoint": ENDPOINT,
                "p256dh": "BCVxsr7N_eNgVRqvHtD0zTZsEc6-VV-JvLexhqUzORcx"
                "aOzi6-AYWXvTBHm4bjyPjs7Vd8pZGH6SRpkNtoIAiw4",
                "auth": "BTBZMqHH6r4Tts7J_aSIgg",
                "language": "en",
            }
        },
    )

    endpoint: str = Field(min_length=1, max_length=URL_CHARACTERS_MAX)
    p256dh: str = Field(pattern=r"^[A-Za-z0-9_-]{87}=?$", description="The browser's key, in base64url.")
    auth: str = Field(pattern=r"^[A-Za-z0-9_-]{22}(==)?$", description="The browser's secret, in base64url.")
    language: Language


class SubscriptionView(BaseModel):
    model_config = ConfigDict(json_schema_extra={"example": {"subscription_id": SUBSCRIPTION_ID}})

    subscription_id: str


@router.get("/campus/notices", operation_id="get_notice_key")
async def get_notice_key(services: InjectedServices) -> NoticeKeyView:
    """The key that browsers subscribe to notices with."""
    sender = services.push_sender
    return NoticeKeyView(public_key="" if sender is None else sender.public_key)


@router.put(
    "/rides/{token}/notices",
    operation_id="ask_for_notices",
    responses=problems(
        RideUnknown,
        RideEnded,
        NoticesUnavailable,
        PushSubscriptionInvalid,
        IdempotencyMismatch,
        TooManyTries,
    ),
)
async def ask_for_notices(
    token: RideToken, request: SubscriptionRequest, command: PassengerCommand, services: InjectedServices
) -> SubscriptionView:
    """Tell this browser when the shuttle is near and when it is there, and if the ride changes or is
    cancelled: each once. The subscription is dropped when the ride has ended."""
    if services.push_sender is None:
        raise NoticesUnavailable("this server sends nothing to browsers")
    may_be_plain = bool(services.settings.webhook_networks())

    def work(uow: UnitOfWork) -> SubscriptionView:
        made = notices.subscribe(
            uow,
            ride_by_token(uow, token),
            request.endpoint,
            request.p256dh,
            request.auth,
            request.language,
            may_be_plain=may_be_plain,
        )
        return SubscriptionView(subscription_id=made.subscription_id)

    return await command.transact(SubscriptionView, work)


@router.delete(
    "/rides/{token}/notices/{subscription_id}",
    operation_id="stop_notices",
    status_code=204,
    responses=problems(RideUnknown, IdempotencyMismatch, TooManyTries),
)
async def stop_notices(token: RideToken, subscription_id: SubscriptionId, command: PassengerCommand) -> None:
    """Send this browser nothing more of the ride."""
    await command.transact(
        type(None), lambda uow: notices.unsubscribe(uow, ride_by_token(uow, token), subscription_id)
    )

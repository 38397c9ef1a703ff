"""Webhooks: recorded events sent to addresses of developers, signed and repeated."""

from fastapi import APIRouter

from server.api.commands import Command, WebhookCommand
from server.api.formats import WebhookId
from server.api.paging import ListLimit, Page, microseconds_of, paged
from server.api.problems import problems
from server.api.security.access import DRIVER_REFUSALS, READER_REFUSALS, Actor, Reader
from server.api.services import InjectedServices
from server.api.webhooks.schemas import WebhookRequest, WebhookSecretView, WebhookTestView, WebhookView
from server.domain.errors import TooManyWebhooks, WebhookDisabled, WebhookInvalid, WebhookUnknown
from server.domain.record.webhooks import Webhook, checked_url
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.webhooks import deliveries, registration
from server.usecases.record.webhooks.deliveries import KEY_GONE, DueDelivery
from server.usecases.record.webhooks.registration import WebhookWithSecret

router = APIRouter(prefix="/webhooks", tags=["webhooks"])


@router.get("", operation_id="list_webhooks", responses=paged(*READER_REFUSALS))
async def list_webhooks(
    services: InjectedServices, actor: Reader, page: Page, limit: ListLimit = None
) -> list[WebhookView]:
    """Oldest first. A developer sees those that were made with the same token, an operator all."""
    account = _account(actor)
    found = await services.transactions.read(lambda uow: registration.listed(uow, account))
    shown = page.cut(found, limit, lambda one: (microseconds_of(one.created_at), one.webhook_id))
    return [_view(webhook) for webhook in shown]


@router.post(
    "",
    operation_id="make_webhook",
    status_code=201,
    responses=problems(WebhookInvalid, TooManyWebhooks, *DRIVER_REFUSALS),
)
async def make_webhook(
    request: WebhookRequest, services: InjectedServices, command: WebhookCommand
) -> WebhookSecretView:
    """It gets the events from now on. Check their signatures with the secret."""
    url = checked_url(request.url, may_be_plain=bool(services.settings.webhook_networks()))
    types = tuple(request.event_types)
    return await command.transact(
        WebhookSecretView,
        lambda uow: _secret_view(registration.create(uow, url, types, command.account, command.by)),
    )


@router.post(
    "/{webhook_id}/rotate",
    operation_id="rotate_webhook",
    responses=problems(WebhookUnknown, *DRIVER_REFUSALS),
)
async def rotate_webhook(webhook_id: WebhookId, command: WebhookCommand) -> WebhookSecretView:
    """A new secret. For a day messages have a signature by the old one as well."""
    own = _account(command)
    return await command.transact(
        WebhookSecretView, lambda uow: _secret_view(registration.rotate(uow, webhook_id, own, command.by))
    )


@router.post(
    "/{webhook_id}/enable",
    operation_id="enable_webhook",
    responses=problems(WebhookUnknown, *DRIVER_REFUSALS),
)
async def enable_webhook(webhook_id: WebhookId, command: WebhookCommand) -> WebhookView:
    """Deliver again, at once and from where it stopped, also before the next attempt is due."""
    own = _account(command)
    return await command.transact(
        WebhookView, lambda uow: _view(registration.enable(uow, webhook_id, own, command.by))
    )


@router.post(
    "/{webhook_id}/test",
    operation_id="test_webhook",
    responses=problems(WebhookUnknown, WebhookDisabled, *DRIVER_REFUSALS),
)
async def test_webhook(
    webhook_id: WebhookId, services: InjectedServices, command: WebhookCommand
) -> WebhookTestView:
    """Send one message of the type `webhook.test` now, and say how it was answered. It is not repeated."""
    own, sender = _account(command), services.webhook_sender

    def made(uow: UnitOfWork) -> DueDelivery:
        return deliveries.test_delivery(uow, registration.seen(uow, webhook_id, own))

    delivery = await services.transactions.read(made)
    if sender is None:
        raise WebhookDisabled("this server sends nothing to other networks")
    if not delivery.keys:
        return WebhookTestView(delivered=False, status=0, failure=KEY_GONE)
    (message,) = delivery.messages
    headers = delivery.headers(message, services.clock.now())
    answer = await sender.send(delivery.webhook.url, headers, message.body)
    return WebhookTestView(delivered=not answer.failure, status=answer.status, failure=answer.failure)


@router.delete(
    "/{webhook_id}",
    operation_id="delete_webhook",
    status_code=204,
    responses=problems(WebhookUnknown, *DRIVER_REFUSALS),
)
async def delete_webhook(webhook_id: WebhookId, command: WebhookCommand) -> None:
    """Send nothing more. What has not been delivered is not sent."""
    own = _account(command)
    await command.transact(type(None), lambda uow: registration.delete(uow, webhook_id, own, command.by))


def _account(actor: Actor | Command) -> str | None:
    """Whose webhooks may be seen; None: all."""
    return actor.account if actor.kind == "developer" else None


def _view(webhook: Webhook) -> WebhookView:
    return WebhookView(
        webhook_id=webhook.webhook_id,
        url=webhook.url,
        event_types=list(webhook.event_types),
        made_by=webhook.made_by,
        created_at=webhook.created_at,
        secret_version=webhook.key.version,
        last_success_at=webhook.last_success_at,
        last_failure_at=webhook.last_failure_at,
        last_failure=webhook.last_failure,
        failures=webhook.failures,
        failing_since=webhook.failing_since,
        next_attempt_at=webhook.next_attempt_at,
        disabled_at=webhook.disabled_at,
        disabled_reason=webhook.disabled_reason,
    )


def _secret_view(made: WebhookWithSecret) -> WebhookSecretView:
    return WebhookSecretView(**_view(made.webhook).model_dump(), secret=made.secret)

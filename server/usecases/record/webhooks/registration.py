"""Developers and operators register webhooks, give them new secrets, enable and delete them."""

from dataclasses import dataclass, field

from server.domain.errors import TooManyWebhooks, WebhookUnknown
from server.domain.record.incidents import IncidentKind
from server.domain.record.webhooks import (
    SigningKey,
    Webhook,
    checked_types,
    enabled,
    rotated,
    secret_text,
)
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.incidents import clear_incident
from server.usecases.record.server_events import record_event

WEBHOOKS_MAX = 100


@dataclass(frozen=True, slots=True)
class WebhookWithSecret:
    """secret: what its messages are signed with; shown once."""

    webhook: Webhook
    secret: str = field(repr=False)


def create(
    uow: UnitOfWork, url: str, event_types: tuple[str, ...], account: str, by: str
) -> WebhookWithSecret:
    """A webhook that gets the events from now on.

    url: checked. Raises WebhookInvalid, TooManyWebhooks, TicketKeyMissing.
    """
    types = checked_types(event_types)
    if len(uow.webhooks.all()) >= WEBHOOKS_MAX:
        raise TooManyWebhooks(f"the campus has {WEBHOOKS_MAX} webhooks already")
    webhook = Webhook(
        campus_id=uow.campus_id,
        webhook_id=uow.ids.new_id("webhook"),
        url=url,
        event_types=types,
        account=account,
        made_by=by,
        created_at=uow.now,
        key=SigningKey(uow.tickets.newest_id, 1),
        cursor=uow.webhooks.last_event_number(),
    )
    uow.webhooks.save(webhook)
    record_event(uow, "webhook.made", webhook.webhook_id, by, ", ".join(types))
    return _with_secret(uow, webhook)


def listed(uow: UnitOfWork, account: str | None) -> tuple[Webhook, ...]:
    """Oldest first; account: only those that it has made, None for all."""
    return tuple(one for one in uow.webhooks.all() if account in (None, one.account))


def seen(uow: UnitOfWork, webhook_id: str, account: str | None) -> Webhook:
    """Raises WebhookUnknown, also for one that another account has made."""
    webhook = uow.webhooks.get(webhook_id)
    if webhook is None or account not in (None, webhook.account):
        raise WebhookUnknown(f"there is no webhook {webhook_id}; see GET /webhooks")
    return webhook


def rotate(uow: UnitOfWork, webhook_id: str, account: str | None, by: str) -> WebhookWithSecret:
    """A new secret. For a day messages are signed with the old one as well. Raises WebhookUnknown."""
    webhook = rotated(seen(uow, webhook_id, account), uow.tickets.newest_id, uow.now)
    uow.webhooks.save(webhook)
    record_event(uow, "webhook.rotated", webhook_id, by)
    return _with_secret(uow, webhook)


def enable(uow: UnitOfWork, webhook_id: str, account: str | None, by: str) -> Webhook:
    """Deliver again, at once and from where it stopped. Raises WebhookUnknown."""
    webhook = enabled(seen(uow, webhook_id, account))
    uow.webhooks.save(webhook)
    clear_incident(uow, IncidentKind.WEBHOOK_DISABLED, webhook_id)
    record_event(uow, "webhook.enabled", webhook_id, by)
    return webhook


def delete(uow: UnitOfWork, webhook_id: str, account: str | None, by: str) -> None:
    """Raises WebhookUnknown."""
    seen(uow, webhook_id, account)
    uow.webhooks.remove(webhook_id)
    clear_incident(uow, IncidentKind.WEBHOOK_DISABLED, webhook_id)
    record_event(uow, "webhook.deleted", webhook_id, by)


def _with_secret(uow: UnitOfWork, webhook: Webhook) -> WebhookWithSecret:
    key = uow.tickets.webhook_key(webhook.key.ticket_key_id, webhook.webhook_id, webhook.key.version)
    assert key is not None, "the newest ticket key is there"
    return WebhookWithSecret(webhook, secret_text(key))

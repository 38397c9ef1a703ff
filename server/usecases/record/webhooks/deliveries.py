"""Which messages webhooks are to get now, and what became of them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta

import msgspec

from server.domain.record.events import ServerEvent
from server.domain.record.incidents import IncidentKind
from server.domain.record.webhooks import (
    TEST_EVENT,
    Webhook,
    after_delivery,
    after_failure,
    disabled,
    signed_headers,
)
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.incidents import open_incident
from server.usecases.record.server_events import THE_SERVER, record_event

# Messages of one webhook that are sent before the result is stored.
BATCH = 20
# Events of other types that a cursor may be behind before it is moved without a message.
PASSED_MAX = 1_000
KEY_GONE = "the ticket key of its secret is gone: give it a new secret"


@dataclass(frozen=True, slots=True)
class WebhookMessage:
    """number: of the event. The same event has the same id and body in every attempt."""

    message_id: str
    number: int
    body: bytes


@dataclass(frozen=True, slots=True)
class DueDelivery:
    """Messages for one webhook, in order, and the keys to sign them with. Its repr shows no key."""

    webhook: Webhook
    messages: tuple[WebhookMessage, ...]
    keys: tuple[bytes, ...] = field(repr=False)
    passed_to: int = 0

    def headers(self, message: WebhookMessage, at: datetime) -> dict[str, str]:
        return signed_headers(self.keys, message.message_id, at, message.body)


@dataclass(frozen=True, slots=True)
class DeliveryResult:
    """delivered_to  number of the last event that arrived or was passed over, None if none did
    failure       why the next one did not arrive; empty if it was not tried
    is_gone       the address says that it will never take messages again
    """

    webhook_id: str
    delivered_to: int | None = None
    failure: str = ""
    is_gone: bool = False


class _Data(msgspec.Struct, frozen=True):
    campus_id: str
    number: int
    subject: str


class _Payload(msgspec.Struct, frozen=True):
    type: str
    timestamp: str
    data: _Data


def due(uow: UnitOfWork) -> tuple[DueDelivery, ...]:
    """What is to be sent now. It only reads."""
    webhooks = [one for one in uow.webhooks.all() if one.is_due(uow.now)]
    last = uow.webhooks.last_event_number() if webhooks else 0
    found = []
    for webhook in webhooks:
        if last <= webhook.cursor:
            continue
        events = uow.webhooks.events_after(webhook.cursor, webhook.event_types, BATCH)
        if events:
            messages = tuple(_message(webhook, number, event) for number, event in events)
            found.append(DueDelivery(webhook, messages, keys_of(uow, webhook)))
        elif last - webhook.cursor > PASSED_MAX:
            found.append(DueDelivery(webhook, (), (), passed_to=last))
    return tuple(found)


def test_delivery(uow: UnitOfWork, webhook: Webhook) -> DueDelivery:
    """One message of the type `webhook.test`, about the webhook itself."""
    event = ServerEvent(uow.campus_id, uow.now, TEST_EVENT, webhook.webhook_id)
    message_id = uow.ids.new_id("test")
    return DueDelivery(webhook, (WebhookMessage(message_id, 0, _body(0, event)),), keys_of(uow, webhook))


def record_results(uow: UnitOfWork, results: Sequence[DeliveryResult], chance: float) -> None:
    """Move the cursors, note failures, and disable what has failed for too long.

    chance  in [0, 1), spreads the next attempts
    """
    for result in results:
        webhook = uow.webhooks.get(result.webhook_id)
        if webhook is None or webhook.disabled_at is not None:
            continue
        if result.delivered_to is not None:
            webhook = after_delivery(webhook, result.delivered_to, uow.now)
        if result.failure:
            webhook = after_failure(webhook, result.failure, uow.now, chance)
        reason = _reason_to_disable(uow, webhook, result)
        if reason:
            webhook = disabled(webhook, reason, uow.now)
            cause = f"webhook {webhook.webhook_id} of {webhook.made_by} is disabled: {reason}"
            open_incident(uow, IncidentKind.WEBHOOK_DISABLED, webhook.webhook_id, cause)
            record_event(uow, "webhook.disabled", webhook.webhook_id, THE_SERVER, reason)
        uow.webhooks.save(webhook)


def disable_of_account(uow: UnitOfWork, account: str, reason: str) -> None:
    """The developer token that made them has been revoked: send nothing more."""
    for webhook in uow.webhooks.all():
        if webhook.account == account and webhook.disabled_at is None:
            uow.webhooks.save(disabled(webhook, reason, uow.now))
            record_event(uow, "webhook.disabled", webhook.webhook_id, THE_SERVER, reason)


def keys_of(uow: UnitOfWork, webhook: Webhook) -> tuple[bytes, ...]:
    """Newest first; empty if the ticket keys are gone."""
    found = (
        uow.tickets.webhook_key(key.ticket_key_id, webhook.webhook_id, key.version)
        for key in webhook.keys_at(uow.now)
    )
    return tuple(key for key in found if key is not None)


def _reason_to_disable(uow: UnitOfWork, webhook: Webhook, result: DeliveryResult) -> str:
    if result.is_gone:
        return "its address answers 410 Gone"
    since = webhook.failing_since
    days = uow.rules.webhook_failure_days
    if since is not None and uow.now - since >= timedelta(days=days):
        return f"it has failed for {days:g} days: {webhook.last_failure}"[:200]
    return ""


def _message(webhook: Webhook, number: int, event: ServerEvent) -> WebhookMessage:
    return WebhookMessage(f"{webhook.webhook_id}-{number}", number, _body(number, event))


def _body(number: int, event: ServerEvent) -> bytes:
    """Without author and details: they may name people. The receiver reads the subject with its token."""
    moment = event.happened_at.isoformat().replace("+00:00", "Z")
    return msgspec.json.encode(_Payload(event.name, moment, _Data(event.campus_id, number, event.subject)))

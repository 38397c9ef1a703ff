"""Webhooks as rows, and the recorded events that they are to get."""

from collections.abc import Sequence

from sqlalchemy import func, or_, select

from server.domain.record.events import ServerEvent
from server.domain.record.webhooks import SigningKey, Webhook
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.record.events import server_event_from_row
from server.store.repository import AnyRow, Repository

_webhook = tables.webhooks.c
_event = tables.server_events.c


class SqlWebhookRepository(Repository):
    def get(self, webhook_id: str) -> Webhook | None:
        row = self._find(tables.webhooks, webhook_id=webhook_id)
        return None if row is None else _from_row(row)

    def all(self) -> tuple[Webhook, ...]:
        ordered = self._select(tables.webhooks).order_by(_webhook.created_at, _webhook.webhook_id)
        return tuple(_from_row(row) for row in self._many(ordered))

    def save(self, webhook: Webhook) -> None:
        self._put(tables.webhooks, _to_row(webhook))

    def remove(self, webhook_id: str) -> None:
        self._delete(tables.webhooks, _webhook.webhook_id == webhook_id)

    def last_event_number(self) -> int:
        highest = select(func.max(_event.number)).where(_event.campus_id == self._campus_id)
        return int(self._connection.execute(highest).scalar_one() or 0)

    def events_after(
        self, number: int, event_types: Sequence[str], limit: int
    ) -> tuple[tuple[int, ServerEvent], ...]:
        exact = [name for name in event_types if not name.endswith(".*")]
        nouns = [name.removesuffix("*") for name in event_types if name.endswith(".*")]
        wanted = or_(
            _event.name.in_(exact), *(_event.name.startswith(noun, autoescape=True) for noun in nouns)
        )
        statement = self._select(tables.server_events, _event.number > number, wanted)
        rows = self._many(statement.order_by(_event.number).limit(limit))
        return tuple((int(row.number), server_event_from_row(row)) for row in rows)


def _from_row(row: AnyRow) -> Webhook:
    old = SigningKey(row.old_ticket_key_id, row.old_version) if row.old_ticket_key_id else None
    return Webhook(
        campus_id=row.campus_id,
        webhook_id=row.webhook_id,
        url=row.url,
        event_types=from_json(row.event_types, tuple[str, ...]),
        account=row.account,
        made_by=row.made_by,
        created_at=row.created_at,
        key=SigningKey(row.ticket_key_id, row.version),
        cursor=row.cursor,
        old_key=old,
        old_key_until=row.old_key_until,
        last_success_at=row.last_success_at,
        last_failure_at=row.last_failure_at,
        last_failure=row.last_failure,
        failures=row.failures,
        failing_since=row.failing_since,
        next_attempt_at=row.next_attempt_at,
        disabled_at=row.disabled_at,
        disabled_reason=row.disabled_reason,
    )


def _to_row(webhook: Webhook) -> dict[str, object]:
    old = webhook.old_key or SigningKey("", 0)
    return {
        "webhook_id": webhook.webhook_id,
        "url": webhook.url,
        "event_types": to_json(webhook.event_types),
        "account": webhook.account,
        "made_by": webhook.made_by,
        "created_at": webhook.created_at,
        "ticket_key_id": webhook.key.ticket_key_id,
        "version": webhook.key.version,
        "old_ticket_key_id": old.ticket_key_id,
        "old_version": old.version,
        "old_key_until": webhook.old_key_until,
        "cursor": webhook.cursor,
        "last_success_at": webhook.last_success_at,
        "last_failure_at": webhook.last_failure_at,
        "last_failure": webhook.last_failure,
        "failures": webhook.failures,
        "failing_since": webhook.failing_since,
        "next_attempt_at": webhook.next_attempt_at,
        "disabled_at": webhook.disabled_at,
        "disabled_reason": webhook.disabled_reason,
    }

"""Browsers that want to hear of a ride, as rows."""

from collections.abc import Sequence

from server.domain.rides.notices import PushSubscription
from server.store import tables
from server.store.columns import from_json, to_json
from server.store.repository import AnyRow, Repository

_subscription = tables.push_subscriptions.c


class SqlPushSubscriptionRepository(Repository):
    def get(self, ride_id: str, subscription_id: str) -> PushSubscription | None:
        row = self._find(tables.push_subscriptions, ride_id=ride_id, subscription_id=subscription_id)
        return None if row is None else _from_row(row)

    def of_ride(self, ride_id: str) -> tuple[PushSubscription, ...]:
        found = self._select(tables.push_subscriptions, _subscription.ride_id == ride_id)
        ordered = found.order_by(_subscription.made_at, _subscription.subscription_id)
        return tuple(_from_row(row) for row in self._many(ordered))

    def all(self) -> tuple[PushSubscription, ...]:
        found = self._select(tables.push_subscriptions)
        ordered = found.order_by(_subscription.made_at, _subscription.ride_id, _subscription.subscription_id)
        return tuple(_from_row(row) for row in self._many(ordered))

    def save(self, subscription: PushSubscription) -> None:
        self._put(tables.push_subscriptions, _to_row(subscription))

    def remove(self, subscription: PushSubscription) -> None:
        named = {"ride_id": subscription.ride_id, "subscription_id": subscription.subscription_id}
        self._remove_all(tables.push_subscriptions, [named])

    def remove_of_rides(self, ride_ids: Sequence[str]) -> None:
        self._delete(tables.push_subscriptions, _subscription.ride_id.in_(ride_ids))


def _from_row(row: AnyRow) -> PushSubscription:
    return PushSubscription(
        campus_id=row.campus_id,
        ride_id=row.ride_id,
        subscription_id=row.subscription_id,
        endpoint=row.endpoint,
        p256dh=row.p256dh,
        auth=row.auth,
        language=row.language,
        made_at=row.made_at,
        told=from_json(row.told, tuple[str, ...]),
        failures=row.failures,
        next_attempt_at=row.next_attempt_at,
    )


def _to_row(subscription: PushSubscription) -> dict[str, object]:
    return {
        "ride_id": subscription.ride_id,
        "subscription_id": subscription.subscription_id,
        "endpoint": subscription.endpoint,
        "p256dh": subscription.p256dh,
        "auth": subscription.auth,
        "language": subscription.language,
        "made_at": subscription.made_at,
        "told": to_json(subscription.told),
        "failures": subscription.failures,
        "next_attempt_at": subscription.next_attempt_at,
    }

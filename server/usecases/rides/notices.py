"""Notices to browsers about one ride: who wants them, which are due, and what became of them.

A notice is claimed in a transaction before it is sent, so that it is sent once. If it did not arrive, the
claim is taken back and it is tried again.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from zoneinfo import ZoneInfo

import msgspec

from server.domain.errors import PushSubscriptionInvalid, RideEnded, WebhookInvalid
from server.domain.planning.eta_ranges import ExpectedRange
from server.domain.record.webhooks import checked_url
from server.domain.rides.notices import (
    Language,
    Notice,
    NoticeKind,
    PushSubscription,
    after_claim,
    after_failure,
    after_success,
    changed_key,
    is_over,
    notices_of,
)
from server.domain.rides.rides import Ride
from server.usecases.planning.outlooks import outlook_of, outlooks_of
from server.usecases.ports.push import PushAnswer, PushMessage
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.rides.notice_texts import TEXTS, NoticeFacts
from server.usecases.rides.tickets import secrets_of

# A family's phones; of more, the oldest is forgotten.
SUBSCRIPTIONS_PER_RIDE_MAX = 5
# Of one cycle and push service: the others do not wait long for one that is slow.
PER_SERVICE_MAX = 8
_ID_CHARACTERS = 32
# How long a push service keeps a notice for a phone that is out of reach.
_TTL_S: dict[NoticeKind, int] = {
    "near": 180,
    "here": 180,
    "changed": 1_800,
    "cancelled": 3_600,
    "no_show": 3_600,
    "failed": 3_600,
}


@dataclass(frozen=True, slots=True)
class DueNotice:
    subscription: PushSubscription
    notice: Notice


@dataclass(frozen=True, slots=True)
class ClaimedNotice:
    """due: as it is stored now, with the notice among those that were told."""

    due: DueNotice
    message: PushMessage


class _Content(msgspec.Struct, frozen=True):
    """What the service worker shows. tag: a notice in place of an earlier one about the same ride.

    address  of the ticket, below the page's own
    """

    title: str
    body: str
    tag: str
    language: Language
    address: str


def subscribe(
    uow: UnitOfWork,
    ride: Ride,
    endpoint: str,
    p256dh: str,
    auth: str,
    language: Language,
    *,
    may_be_plain: bool = False,
) -> PushSubscription:
    """Tell this browser of the ride from now on. A repeat takes over keys and language.

    may_be_plain  http is allowed as well, into networks that the settings name

    Raises RideEnded, PushSubscriptionInvalid.
    """
    if ride.has_ended:
        raise RideEnded(f"ride {ride.ride_code} is {ride.state} already")
    try:
        checked_url(endpoint, may_be_plain)
    except WebhookInvalid as error:
        raise PushSubscriptionInvalid(error.detail) from error
    of_ride = uow.push_subscriptions.of_ride(ride.ride_id)
    subscription_id = subscription_id_of(endpoint)
    known = next((one for one in of_ride if one.subscription_id == subscription_id), None)
    if known is not None:
        wanted = replace(known, p256dh=p256dh, auth=auth, language=language, failures=0, next_attempt_at=None)
    else:
        wanted = PushSubscription(
            uow.campus_id,
            ride.ride_id,
            subscription_id,
            endpoint,
            p256dh,
            auth,
            language,
            uow.now,
            # The page shows the present times.
            told=(changed_key(ride),),
        )
        for old in of_ride[: max(0, len(of_ride) + 1 - SUBSCRIPTIONS_PER_RIDE_MAX)]:
            uow.push_subscriptions.remove(old)
    uow.push_subscriptions.save(wanted)
    return wanted


def unsubscribe(uow: UnitOfWork, ride: Ride, subscription_id: str) -> None:
    """Send this browser nothing more of the ride. A repeat changes nothing."""
    for known in uow.push_subscriptions.of_ride(ride.ride_id):
        if known.subscription_id == subscription_id:
            uow.push_subscriptions.remove(known)


def subscription_id_of(endpoint: str) -> str:
    return hashlib.sha256(endpoint.encode()).hexdigest()[:_ID_CHARACTERS]


def due(uow: UnitOfWork) -> tuple[tuple[DueNotice, ...], tuple[PushSubscription, ...]]:
    """One notice for each browser that has something to hear now, and the subscriptions that are over."""
    subscriptions = uow.push_subscriptions.all()
    rides = _rides(uow, subscriptions)
    outlooks = outlooks_of(uow, [ride for ride in rides.values() if not ride.has_ended])
    found, over = [], []
    for subscription in subscriptions:
        ride = rides.get(subscription.ride_id)
        if ride is None or is_over(ride, subscription.told, uow.now):
            over.append(subscription)
            continue
        outlook = outlooks.get(ride.ride_id)
        notice = _next(uow, subscription, ride, None if outlook is None else outlook.pickup)
        if notice is not None and subscription.is_due(uow.now):
            found.append(DueNotice(subscription, notice))
    return tuple(found), tuple(over)


def claim(
    uow: UnitOfWork, found: Sequence[DueNotice], over: Sequence[PushSubscription]
) -> list[ClaimedNotice]:
    """Those that are still due and that no other server has claimed; what is over is forgotten."""
    for subscription in over:
        uow.push_subscriptions.remove(subscription)
    claimed = []
    for one in found:
        known = one.subscription
        stored = uow.push_subscriptions.get(known.ride_id, known.subscription_id)
        ride = uow.rides.get(known.ride_id)
        if stored is None or ride is None or not stored.is_due(uow.now):
            continue
        outlook = outlook_of(uow, ride)
        notice = _next(uow, stored, ride, outlook.pickup)
        if notice is None or notice != one.notice:
            continue
        told = after_claim(stored, notice)
        uow.push_subscriptions.save(told)
        claimed.append(
            ClaimedNotice(
                DueNotice(told, notice),
                _message(uow, ride, told, notice, outlook.pickup, outlook.vehicle_name),
            )
        )
    return claimed


def record_answers(uow: UnitOfWork, answers: Sequence[tuple[DueNotice, PushAnswer]]) -> None:
    """Forget browsers that are gone, and take back what did not arrive."""
    for sent, answer in answers:
        known = sent.subscription
        subscription = uow.push_subscriptions.get(known.ride_id, known.subscription_id)
        if subscription is None:
            continue
        if answer.is_gone:
            uow.push_subscriptions.remove(subscription)
        elif answer.failure:
            uow.push_subscriptions.save(after_failure(subscription, sent.notice, uow.now))
        elif subscription.failures:
            uow.push_subscriptions.save(after_success(subscription))


def _rides(uow: UnitOfWork, subscriptions: Sequence[PushSubscription]) -> dict[str, Ride]:
    ride_ids = dict.fromkeys(subscription.ride_id for subscription in subscriptions)
    found = ((ride_id, uow.rides.get(ride_id)) for ride_id in ride_ids)
    return {ride_id: ride for ride_id, ride in found if ride is not None}


def _next(
    uow: UnitOfWork, subscription: PushSubscription, ride: Ride, pickup: ExpectedRange | None
) -> Notice | None:
    said = notices_of(ride, pickup, uow.now)
    return next((notice for notice in said if notice.key not in subscription.told), None)


def _message(
    uow: UnitOfWork,
    ride: Ride,
    subscription: PushSubscription,
    notice: Notice,
    pickup: ExpectedRange | None,
    vehicle_name: str,
) -> PushMessage:
    language = subscription.language
    title, body = TEXTS[language](notice.kind, _facts(uow, ride, language, pickup, vehicle_name))
    topic = hashlib.sha256(ride.ride_id.encode()).hexdigest()[:_ID_CHARACTERS]
    address = f"/#ride={secrets_of(uow, ride).token}"
    content = msgspec.json.encode(_Content(title, body, topic, language, address))
    return PushMessage(content, _TTL_S[notice.kind], topic)


def _facts(
    uow: UnitOfWork, ride: Ride, language: Language, pickup: ExpectedRange | None, vehicle_name: str
) -> NoticeFacts:
    network, promise = uow.network(), ride.promise
    stop = next((stop for stop in network.road_map.stops if stop.stop_id == ride.from_stop), None)
    names = ("", "") if stop is None else (stop.name_en, stop.name)
    zone = ZoneInfo(network.road_map.timezone)

    def clock(moment: datetime) -> str:
        return moment.astimezone(zone).strftime("%H:%M")

    window = None if promise is None else (promise.pickup_from, promise.pickup_to)
    if pickup is not None:
        window = (pickup.earliest, pickup.latest)
    ahead_s = 0.0 if ride.pickup_eta is None else (ride.pickup_eta - uow.now).total_seconds()
    return NoticeFacts(
        vehicle=vehicle_name,
        stop=(names[0] or names[1] if language == "en" else names[1] or names[0]) or ride.from_stop,
        between=None if window is None else (clock(window[0]), clock(window[1])),
        minutes=max(1, round(ahead_s / 60.0)),
        by_operator=ride.reason == "cancelled_by_operator",
    )

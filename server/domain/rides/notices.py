"""What passengers who asked for it are told of their ride while its page is closed, and when."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta
from typing import Literal

from server.domain.planning.eta_ranges import ExpectedRange
from server.domain.rides.rides import Ride, RideState

Language = Literal["en", "zh"]
NoticeKind = Literal["near", "here", "changed", "cancelled", "no_show", "failed"]

# The shuttle is near when its pickup is expected within this time.
NEAR_S = 180.0
# After the first attempt that failed, the second one, and so on; the last one repeats.
PAUSES_S = (5.0, 15.0, 60.0, 300.0)
# The end of a ride is told for so long if the push service does not answer.
ENDED_FOR_S = 3_600.0

_ENDS: dict[RideState, NoticeKind] = {
    RideState.CANCELLED: "cancelled",
    RideState.NO_SHOW: "no_show",
    RideState.FAILED: "failed",
}
_WITH_PICKUP = frozenset({RideState.REQUESTED, RideState.ASSIGNED, RideState.BOARDING})
# Not told: the passenger cancelled the ride.
_BY_PASSENGER = "cancelled_by_passenger"


@dataclass(frozen=True, slots=True)
class PushSubscription:
    """A browser that wants to hear of one ride. Its repr shows no address and no key.

    subscription_id  SHA-256 of the address, shortened
    endpoint  address at the browser's push service; who has it can send messages to the browser
    p256dh, auth  the browser's keys in base64url
    told      notices that were sent, by their keys
    failures  attempts in a row that failed
    """

    campus_id: str
    ride_id: str
    subscription_id: str
    endpoint: str = field(repr=False)
    p256dh: str = field(repr=False)
    auth: str = field(repr=False)
    language: Language
    made_at: datetime
    told: tuple[str, ...] = ()
    failures: int = 0
    next_attempt_at: datetime | None = None

    def is_due(self, now: datetime) -> bool:
        return self.next_attempt_at is None or self.next_attempt_at <= now


@dataclass(frozen=True, slots=True)
class Notice:
    """key  what it tells: a subscription gets each one once"""

    kind: NoticeKind
    key: str


def notices_of(ride: Ride, pickup: ExpectedRange | None, now: datetime) -> tuple[Notice, ...]:
    """What can be said of the ride now, the most urgent first.

    pickup  its range, None while no time can be promised
    """
    if ride.has_ended:
        kind = _ENDS.get(ride.state)
        is_news = kind is not None and ride.reason != _BY_PASSENGER
        return (Notice(kind, kind),) if kind is not None and is_news else ()
    if ride.state not in _WITH_PICKUP:
        return ()
    found = [Notice("changed", changed_key(ride))]
    if ride.state is RideState.BOARDING:
        found.append(Notice("here", f"here {ride.vehicle_id}"))
    elif pickup is not None and _is_within(ride.pickup_eta, now, NEAR_S):
        found.append(Notice("near", f"near {ride.vehicle_id}"))
    return tuple(found)


def _is_within(moment: datetime | None, now: datetime, ahead_s: float) -> bool:
    return moment is not None and moment - now <= timedelta(seconds=ahead_s)


def changed_key(ride: Ride) -> str:
    """Where and when the party was promised to be picked up."""
    promise = ride.promise
    when = "" if promise is None else f"{promise.pickup_from.isoformat()} {promise.pickup_to.isoformat()}"
    return f"changed {ride.from_stop} {when}".rstrip()


def is_over(ride: Ride, told: Sequence[str], now: datetime) -> bool:
    """Nothing more will be told of it."""
    if not ride.has_ended:
        return False
    if ride.ended_at is not None and now - ride.ended_at >= timedelta(seconds=ENDED_FOR_S):
        return True
    return all(notice.key in told for notice in notices_of(ride, None, now))


def after_claim(subscription: PushSubscription, notice: Notice) -> PushSubscription:
    """It counts as told before it is sent: two servers do not both send it."""
    return replace(subscription, told=(*subscription.told, notice.key))


def after_success(subscription: PushSubscription) -> PushSubscription:
    return replace(subscription, failures=0, next_attempt_at=None)


def after_failure(subscription: PushSubscription, notice: Notice, now: datetime) -> PushSubscription:
    """It was not told after all, and is tried again after a pause if it is still true then."""
    failures = subscription.failures + 1
    pause_s = PAUSES_S[min(failures, len(PAUSES_S)) - 1]
    return replace(
        subscription,
        told=tuple(key for key in subscription.told if key != notice.key),
        failures=failures,
        next_attempt_at=now + timedelta(seconds=pause_s),
    )

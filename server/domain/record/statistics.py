"""What a stretch of time says about demand, service and driving. Times in seconds, speeds in m/s."""

from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import datetime
from zoneinfo import ZoneInfo

import msgspec

from server.domain.rides.rides import Ride, RideState

HOURS = 24
PAIRS_MAX = 10
BIN_KMH = 1.0


class HourOfDay(msgspec.Struct, frozen=True):
    """Rides that were wanted in this hour of the campus's day, and what became of them.

    under_way: not over yet; passengers: of completed rides
    """

    hour: int
    completed: int = 0
    refused: int = 0
    cancelled: int = 0
    no_show: int = 0
    failed: int = 0
    under_way: int = 0
    passengers: int = 0


class StopPair(msgspec.Struct, frozen=True):
    from_stop: str
    to_stop: str
    rides: int


class Quantiles(msgspec.Struct, frozen=True):
    """Of `count` values; 0 where there are none."""

    count: int
    p50: float
    p90: float
    p99: float


class ServiceFigures(msgspec.Struct, frozen=True):
    """Rides wanted in [from_ms, to_ms).

    waiting_s     from when it was wanted (or requested, if that was later) until the party boarded
    late_s        how much later than the promised window the party boarded; 0 inside it
    kept_ratio    share of boarded rides that were picked up within their promised window; 0 without any
    is_cut        there were more rides than were looked at
    """

    from_ms: int
    to_ms: int
    hours: list[HourOfDay]
    pairs: list[StopPair]
    waiting_s: Quantiles
    late_s: Quantiles
    kept_ratio: float
    is_cut: bool


class SpeedBin(msgspec.Struct, frozen=True):
    """Of all positions stored: how many were at [from_kmh, from_kmh + 1)."""

    from_kmh: int
    positions: int


class DrivingFigures(msgspec.Struct, frozen=True):
    """Of stored positions, two a second for each vehicle that reports.

    distance_m  the speeds of the positions times the half second between them: about what was driven
    is_cut      there were more events than were looked at: brakings, takeovers and stops are at least so many
    """

    from_ms: int
    to_ms: int
    speeds: list[SpeedBin]
    distance_m: float
    brakings: int
    takeovers: int
    minimal_risk_stops: int
    is_cut: bool


def service_figures(
    rides: Sequence[Ride], from_ms: int, to_ms: int, timezone: str, is_cut: bool
) -> ServiceFigures:
    zone = ZoneInfo(timezone)
    boarded = [ride for ride in rides if ride.boarded_at is not None]
    late = [late_s for ride in boarded if (late_s := _late_s(ride)) is not None]
    pairs = Counter((ride.from_stop, ride.to_stop) for ride in rides)
    busiest = sorted(pairs.items(), key=lambda item: (-item[1], item[0]))[:PAIRS_MAX]
    return ServiceFigures(
        from_ms=from_ms,
        to_ms=to_ms,
        hours=_hours(rides, zone),
        pairs=[StopPair(start, end, count) for (start, end), count in busiest],
        waiting_s=_quantiles([_waiting_s(ride) for ride in boarded]),
        late_s=_quantiles(late),
        kept_ratio=sum(value == 0.0 for value in late) / len(late) if late else 0.0,
        is_cut=is_cut,
    )


def _hours(rides: Iterable[Ride], zone: ZoneInfo) -> list[HourOfDay]:
    counts: dict[int, Counter[str]] = {hour: Counter() for hour in range(HOURS)}
    for ride in rides:
        of_hour = counts[_wanted_at(ride).astimezone(zone).hour]
        of_hour[_outcome(ride)] += 1
        if ride.state is RideState.COMPLETED:
            of_hour["passengers"] += ride.party
    return [HourOfDay(hour, **of_hour) for hour, of_hour in counts.items()]


def _outcome(ride: Ride) -> str:
    over = (
        RideState.COMPLETED,
        RideState.REFUSED,
        RideState.CANCELLED,
        RideState.NO_SHOW,
        RideState.FAILED,
    )
    return str(ride.state) if ride.state in over else "under_way"


def _wanted_at(ride: Ride) -> datetime:
    return max(ride.earliest, ride.requested_at)


def _waiting_s(ride: Ride) -> float:
    assert ride.boarded_at is not None
    return max(0.0, (ride.boarded_at - _wanted_at(ride)).total_seconds())


def _late_s(ride: Ride) -> float | None:
    """None without a promise."""
    if ride.boarded_at is None or ride.promise is None:
        return None
    return max(0.0, (ride.boarded_at - ride.promise.pickup_to).total_seconds())


def _quantiles(values: Sequence[float]) -> Quantiles:
    if not values:
        return Quantiles(0, 0.0, 0.0, 0.0)
    ordered = sorted(values)
    p50, p90, p99 = (ordered[int(share * (len(ordered) - 1))] for share in (0.5, 0.9, 0.99))
    return Quantiles(len(ordered), p50, p90, p99)

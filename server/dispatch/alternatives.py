"""What can be offered instead: a later time, a stop near by, or two rides. Nothing is reserved."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

from server.dispatch.decide import earliest_quotes, offers_for, take
from server.dispatch.problem import Request, Walk
from server.dispatch.schedule.schedule import Schedule

Kind = Literal["later", "other_stops", "split_party"]
OFFERED_MAX = 3
# A party in two shuttles counts as much as so long a wait.
_SPLIT_PENALTY_S = 300.0
# A second on foot counts more than a second of waiting.
_WALK_PENALTY = 1.5


@dataclass(frozen=True, slots=True)
class Alternative:
    """One or two rides that would be accepted now.

    parties     people in each ride, with those in wheelchairs in the first
    pickup, dropoff  places; walk_s  from or to the requested stops
    pickup_s, arrival_s  of each ride as it would be planned
    penalty_s   how far it is from the request, in seconds of waiting
    """

    kind: Kind
    parties: tuple[int, ...]
    pickup: int
    dropoff: int
    walk_s: float
    pickup_s: tuple[float, ...]
    arrival_s: tuple[float, ...]
    penalty_s: float


@dataclass(frozen=True, slots=True)
class _Attempt:
    """The request from this stop to that one, with its window ending so much later."""

    kind: Kind
    up: Walk
    down: Walk
    later_s: float


def alternatives(
    schedule: Schedule,
    request: Request,
    pickups: tuple[Walk, ...],
    dropoffs: tuple[Walk, ...],
    later_s_max: float,
) -> list[Alternative]:
    """The few nearest to the request, the nearest first. The schedule stays unchanged.

    request   that no vehicle can carry; it need not be in the schedule
    pickups, dropoffs  stops within walking distance
    later_s_max  how much later the pickup window may end
    """
    plain = replace(request, request_id=f"{request.request_id}/instead", pickup_walks=(), dropoff_walks=())
    later = _Attempt("later", Walk(request.pickup, 0.0), Walk(request.dropoff, 0.0), later_s_max)
    near_by = _near_by(request, pickups, dropoffs)
    found = [*_quoted(schedule, plain, [later, *near_by]), *_split(schedule, plain)]
    if len(found) < OFFERED_MAX:
        found += _quoted(schedule, plain, [replace(near, later_s=later_s_max) for near in near_by])
    found.sort(key=lambda alternative: alternative.penalty_s)
    distinct: dict[object, Alternative] = {}
    for alternative in found:
        distinct.setdefault((alternative.parties, alternative.pickup, alternative.dropoff), alternative)
    return list(distinct.values())[:OFFERED_MAX]


def _near_by(request: Request, pickups: tuple[Walk, ...], dropoffs: tuple[Walk, ...]) -> list[_Attempt]:
    """Every pair of stops except the requested one and those whose walk passes the other end."""
    return [
        _Attempt("other_stops", up, down, 0.0)
        for up in (Walk(request.pickup, 0.0), *pickups)
        for down in (Walk(request.dropoff, 0.0), *dropoffs)
        if up.place not in (down.place, request.dropoff)
        and down.place != request.pickup
        and up.walk_s + down.walk_s > 0.0
    ]


def _quoted(schedule: Schedule, request: Request, attempts: list[_Attempt]) -> list[Alternative]:
    """Those that some vehicle can carry, each as early as possible."""
    quotes = earliest_quotes(
        schedule,
        request,
        [
            (
                one.up.place,
                one.down.place,
                request.pickup_from_s + one.up.walk_s,
                request.pickup_to_s + one.up.walk_s + one.later_s,
                request.arrive_by_s - one.down.walk_s + one.later_s,
            )
            for one in attempts
        ],
    )
    found = []
    for one, (pickup_s, arrival_s) in zip(attempts, quotes, strict=True):
        walk_s = one.up.walk_s + one.down.walk_s
        late_s = max(0.0, pickup_s - request.pickup_from_s - one.up.walk_s)
        if math.isfinite(pickup_s):
            found.append(
                Alternative(
                    one.kind,
                    (request.party,),
                    one.up.place,
                    one.down.place,
                    walk_s,
                    (pickup_s,),
                    (arrival_s,),
                    late_s + _WALK_PENALTY * walk_s,
                )
            )
    return found


def _split(schedule: Schedule, request: Request) -> Iterator[Alternative]:
    """The party in two rides, in any vehicles."""
    if request.party < 2:
        return
    first = max(request.wheelchairs, (request.party + 1) // 2)
    second = request.party - first
    if second == 0:
        return
    halves = (
        replace(request, request_id=f"{request.request_id}/1", party=first),
        replace(request, request_id=f"{request.request_id}/2", party=second, wheelchairs=0),
    )
    times = []
    for half in halves:
        schedule.add(half)
        offer = offers_for(schedule, half.request_id).best
        if offer is not None:
            take(schedule, offer)
            planned = schedule.planned(half.request_id)
            times.append((planned.pickup_s, planned.arrival_s))
    for half in reversed(halves):
        schedule.remove(half.request_id)
    if len(times) == 2:
        pickups_s, arrivals_s = zip(*times, strict=True)
        late_s = max(0.0, max(pickups_s) - request.pickup_from_s)
        yield Alternative(
            "split_party",
            (first, second),
            request.pickup,
            request.dropoff,
            0.0,
            pickups_s,
            arrivals_s,
            late_s + _SPLIT_PENALTY_S,
        )

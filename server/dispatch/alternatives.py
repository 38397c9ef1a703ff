"""What could be offered instead: later, from or to a stop near by, or in two parties. Nothing is reserved."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

from server.dispatch.board import Board
from server.dispatch.decide import offers_for, take
from server.dispatch.problem import Request, Walk

Kind = Literal["later", "other_stops", "split_party"]
OFFERED_MAX = 3
# A party that rides in two shuttles minds it about as much as waiting so long.
_SPLIT_PENALTY_S = 300.0
# Walking is minded more than waiting.
_WALK_PENALTY = 1.5


@dataclass(frozen=True, slots=True)
class Alternative:
    """One or two rides that would be accepted now.

    parties     people in each ride, with those in wheelchairs in the first
    pickup, dropoff  places; walk_s  from or to the stops that were asked for
    pickup_s, arrival_s  of each ride as it would be planned
    penalty_s   how far it is from what was asked for, in seconds of waiting
    """

    kind: Kind
    parties: tuple[int, ...]
    pickup: int
    dropoff: int
    walk_s: float
    pickup_s: tuple[float, ...]
    arrival_s: tuple[float, ...]
    penalty_s: float


def alternatives(
    board: Board,
    wish: Request,
    pickups: tuple[Walk, ...],
    dropoffs: tuple[Walk, ...],
    later_s_max: float,
) -> list[Alternative]:
    """The nearest few to what was asked for, the nearest first. The board stays as it is.

    wish      a request that nobody can carry; it need not be on the board
    pickups, dropoffs  stops within walking distance
    later_s_max  how much later the pickup window may end
    """
    plain = replace(wish, request_id=f"{wish.request_id}/instead", pickup_walks=(), dropoff_walks=())
    wider = replace(
        plain, pickup_to_s=plain.pickup_to_s + later_s_max, arrive_by_s=plain.arrive_by_s + later_s_max
    )
    found = [
        *_tried(board, "later", wider, 0.0),
        *_near_by(board, plain, pickups, dropoffs),
        *_split(board, plain),
    ]
    if len(found) < OFFERED_MAX:
        found += _near_by(board, wider, pickups, dropoffs)
    found.sort(key=lambda alternative: alternative.penalty_s)
    distinct: dict[object, Alternative] = {}
    for alternative in found:
        distinct.setdefault((alternative.parties, alternative.pickup, alternative.dropoff), alternative)
    return list(distinct.values())[:OFFERED_MAX]


def _near_by(
    board: Board, wish: Request, pickups: tuple[Walk, ...], dropoffs: tuple[Walk, ...]
) -> Iterator[Alternative]:
    for up in (Walk(wish.pickup, 0.0), *pickups):
        for down in (Walk(wish.dropoff, 0.0), *dropoffs):
            walk_s = up.walk_s + down.walk_s
            there_and_back = up.place == wish.dropoff or down.place == wish.pickup
            if up.place == down.place or walk_s == 0.0 or there_and_back:
                continue
            there = replace(
                wish,
                pickup=up.place,
                dropoff=down.place,
                pickup_from_s=wish.pickup_from_s + up.walk_s,
                pickup_to_s=wish.pickup_to_s + up.walk_s,
                arrive_by_s=wish.arrive_by_s - down.walk_s,
            )
            yield from _tried(board, "other_stops", there, walk_s)


def _tried(board: Board, kind: Kind, request: Request, walk_s: float) -> Iterator[Alternative]:
    """The request as early as somebody can take it."""
    board.add(request)
    offer = _earliest(board, request)
    if offer is not None:
        pickup_s, arrival_s = offer
        late_s = max(0.0, pickup_s - request.pickup_from_s)
        yield Alternative(
            kind,
            (request.party,),
            request.pickup,
            request.dropoff,
            walk_s,
            (pickup_s,),
            (arrival_s,),
            late_s + _WALK_PENALTY * walk_s,
        )
    board.remove(request.request_id)


def _split(board: Board, wish: Request) -> Iterator[Alternative]:
    """The party in two rides, either of which anybody may carry."""
    if wish.party < 2:
        return
    first = max(wish.wheelchairs, (wish.party + 1) // 2)
    second = wish.party - first
    if second == 0:
        return
    halves = (
        replace(wish, request_id=f"{wish.request_id}/1", party=first),
        replace(wish, request_id=f"{wish.request_id}/2", party=second, wheelchairs=0),
    )
    times = []
    for half in halves:
        board.add(half)
        offer = offers_for(board, half.request_id).best
        if offer is not None:
            take(board, offer)
            planned = board.planned(half.request_id)
            times.append((planned.pickup_s, planned.arrival_s))
    for half in reversed(halves):
        board.remove(half.request_id)
    if len(times) == 2:
        pickups_s, arrivals_s = zip(*times, strict=True)
        late_s = max(0.0, max(pickups_s) - wish.pickup_from_s)
        yield Alternative(
            "split_party",
            (first, second),
            wish.pickup,
            wish.dropoff,
            0.0,
            pickups_s,
            arrivals_s,
            late_s + _SPLIT_PENALTY_S,
        )


def _earliest(board: Board, request: Request) -> tuple[float, float] | None:
    """Pickup and arrival where the pickup counts above everything else."""
    r = board.rows[request.request_id]
    board.task.delay_cost[2 * r] *= _URGENT
    offer = offers_for(board, request.request_id).best
    if offer is None:
        return None
    take(board, offer)
    planned = board.planned(request.request_id)
    board.take_out(request.request_id)
    return planned.pickup_s, planned.arrival_s


_URGENT = 1000.0

"""Answers bookings one after the other: which vehicle comes and when, or why no vehicle can come."""

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace

from server.dispatch.alternatives import Alternative, alternatives
from server.dispatch.decide import Offer, offers_for, quoted_times, take
from server.dispatch.problem import Request, Walk
from server.dispatch.refusal import binding_rule
from server.dispatch.schedule.schedule import Schedule


@dataclass(frozen=True, slots=True)
class PromiseRules:
    """What a promise leaves room for, and what may be offered instead.

    pickup_early_s, pickup_slack_s  the promised pickup window around the planned pickup
    pickup_slack_ratio, uncertain_s_max  it ends later by this share of the time until then, which counts up
                 to so many seconds
    arrival_slack_s, arrival_slack_ratio  the promised latest arrival after the planned one, the second as a
                 share of the planned time on board
    later_s_max  how much later than requested an alternative may be
    walks        for each place the others within walking distance
    """

    pickup_early_s: float = 0.0
    pickup_slack_s: float = 0.0
    arrival_slack_s: float = 0.0
    arrival_slack_ratio: float = 0.0
    later_s_max: float = 0.0
    walks: tuple[tuple[Walk, ...], ...] = ()
    pickup_slack_ratio: float = 0.0
    uncertain_s_max: float = 0.0

    def pickup_to_s(self, pickup_s: float, now_s: float) -> float:
        """The latest pickup that is promised now with this one planned."""
        return pickup_s + self.pickup_slack_s + self._uncertain_s(pickup_s, now_s)

    def arrive_by_s(self, pickup_s: float, arrival_s: float, now_s: float) -> float:
        """The latest arrival that is promised for these planned times."""
        slack_s = self.arrival_slack_s + self.arrival_slack_ratio * max(0.0, arrival_s - pickup_s)
        return arrival_s + slack_s + self._uncertain_s(pickup_s, now_s)

    def _uncertain_s(self, pickup_s: float, now_s: float) -> float:
        return self.pickup_slack_ratio * min(max(0.0, pickup_s - now_s), self.uncertain_s_max)


@dataclass(frozen=True, slots=True)
class Quote:
    """A ride as one vehicle would make it; extra_cost in weighted seconds of the whole fleet's plan."""

    vehicle_id: str
    extra_cost: float
    pickup_s: float
    arrival_s: float


@dataclass(frozen=True, slots=True)
class Answer:
    """best     what the request got, None for a refusal; runner_up: the best that any other vehicle offered
    windows     promised from now on: pickup from, pickup to, arrival by
    rule        that binds, "" for a request that got a vehicle; alternatives: the nearest that would be
                accepted now
    """

    request_id: str
    best: Quote | None = None
    runner_up: Quote | None = None
    windows: tuple[float, float, float] | None = None
    rule: str = ""
    alternatives: tuple[Alternative, ...] = ()


def answer_all(
    schedule: Schedule, request_ids: Sequence[str], terms: PromiseRules, promised: Set[str] = frozenset()
) -> tuple[Answer, ...]:
    """Answer in this order, each with the earlier ones in place. Refused requests leave the schedule.

    The requests are in the schedule and in no route. The windows of those in `promised` stay unchanged.
    """
    return tuple(_answer(schedule, request_id, terms, request_id in promised) for request_id in request_ids)


def _answer(schedule: Schedule, request_id: str, terms: PromiseRules, promised: bool) -> Answer:
    request = schedule.requests[schedule.rows[request_id]]
    offers = offers_for(schedule, request_id)
    if offers.best is None:
        rule = binding_rule(schedule, request_id)
        schedule.remove(request_id)
        return Answer(request_id, rule=rule, alternatives=_alternatives_for(schedule, request, terms))
    runner_up = None if offers.runner_up is None else _quote_of_offer(schedule, offers.runner_up)
    take(schedule, offers.best)
    best = _quote(schedule, offers.best)
    windows = (request.pickup_from_s, request.pickup_to_s, request.arrive_by_s)
    if not promised:
        windows = _promised(offers.best.request, best, terms, schedule.origin_s)
        schedule.narrow(
            replace(
                offers.best.request, pickup_from_s=windows[0], pickup_to_s=windows[1], arrive_by_s=windows[2]
            )
        )
    return Answer(request_id, best, runner_up, windows)


def _promised(
    request: Request, quote: Quote, terms: PromiseRules, now_s: float
) -> tuple[float, float, float]:
    """Windows around the planned times, with room for later riders and for delays on the road."""
    opens_s = max(request.pickup_from_s, quote.pickup_s - terms.pickup_early_s)
    closes_s = terms.pickup_to_s(quote.pickup_s, now_s)
    by_s = terms.arrive_by_s(quote.pickup_s, quote.arrival_s, now_s)
    return opens_s, closes_s, min(by_s, request.arrive_by_s)


def _quote(schedule: Schedule, offer: Offer) -> Quote:
    planned = schedule.planned(offer.request.request_id)
    return Quote(schedule.vehicle_ids[offer.vehicle], offer.cost, planned.pickup_s, planned.arrival_s)


def _quote_of_offer(schedule: Schedule, offer: Offer) -> Quote:
    """The ride that was not taken."""
    pickup_s, arrival_s = quoted_times(schedule, offer)
    return Quote(schedule.vehicle_ids[offer.vehicle], offer.cost, pickup_s, arrival_s)


def _alternatives_for(schedule: Schedule, request: Request, terms: PromiseRules) -> tuple[Alternative, ...]:
    if terms.later_s_max <= 0.0:
        return ()
    near = terms.walks or ((),) * len(schedule.problem.times)
    return tuple(
        alternatives(schedule, request, near[request.pickup], near[request.dropoff], terms.later_s_max)
    )

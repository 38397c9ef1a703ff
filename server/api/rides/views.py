"""What the API makes of rides: commands of requests, and answers of what the domain has."""

from collections.abc import Sequence

from server.api.rides.schemas import (
    AlternativeView,
    DecisionView,
    FeedbackView,
    OfferView,
    PromiseView,
    QuoteView,
    RideDelayView,
    RideEventView,
    RideRecord,
    RideRequest,
    RideTicket,
    RideView,
    TapView,
)
from server.domain.planning.decisions import Alternative, Quote, RideDecision
from server.domain.planning.outlooks import RideOutlook
from server.domain.record.events import ServerEvent
from server.domain.rides.feedback import Feedback
from server.domain.rides.rides import (
    BookRide,
    Promise,
    Ride,
    RideSource,
    Tap,
)
from server.domain.rides.ticket_keys import RideSecrets
from server.usecases.rides.delays import RideDelay
from server.usecases.rides.offers import RideOffer


def booking(request: RideRequest, idempotency_key: str | None, source: RideSource) -> BookRide:
    return BookRide(
        from_stop=request.from_stop,
        to_stop=request.to_stop,
        party=request.party,
        wheelchairs=request.wheelchairs,
        earliest=request.earliest,
        idempotency_key=idempotency_key,
        may_walk=request.may_walk,
        source=source,
    )


def ride_view(ride: Ride, outlook: RideOutlook) -> RideView:
    return RideView.model_validate(_fields(ride, outlook))


def ride_ticket(
    ride: Ride,
    secrets: RideSecrets,
    outlook: RideOutlook,
    alternatives: Sequence[Alternative] = (),
    feedback: Feedback | None = None,
) -> RideTicket:
    more = {
        "feedback": None if feedback is None else feedback_view(feedback),
        "token": secrets.token,
        "boarding_code": secrets.boarding_code,
        "alternatives": [alternative_view(one) for one in alternatives],
    }
    return RideTicket.model_validate(_fields(ride, outlook) | more)


def offer_view(offer: RideOffer) -> OfferView:
    return OfferView(
        is_free=offer.is_free, rule=offer.rule, pickup_at=offer.pickup_at, arrival_at=offer.arrival_at
    )


def alternative_view(alternative: Alternative) -> AlternativeView:
    return AlternativeView(
        kind=alternative.kind,
        from_stop=alternative.from_stop,
        to_stop=alternative.to_stop,
        parties=list(alternative.parties),
        walk_s=round(alternative.walk_s),
        pickup_at=list(alternative.pickup_at),
        arrival_at=list(alternative.arrival_at),
    )


def decision_view(decision: RideDecision) -> DecisionView:
    return DecisionView(
        made_at=decision.made_at,
        rule=decision.rule,
        best=_quote(decision.best),
        runner_up=_quote(decision.runner_up),
        alternatives=[alternative_view(one) for one in decision.alternatives],
        vehicles=decision.vehicles,
    )


def _quote(quote: Quote | None) -> QuoteView | None:
    if quote is None:
        return None
    return QuoteView(
        vehicle_id=quote.vehicle_id,
        extra_cost_s=quote.extra_cost_s,
        pickup_at=quote.pickup_at,
        arrival_at=quote.arrival_at,
    )


def ride_event_view(event: ServerEvent, with_words: bool) -> RideEventView:
    is_passengers = event.name in ("ride.help_called", "ride.feedback")
    detail = "" if is_passengers and not with_words else event.detail
    return RideEventView(happened_at=event.happened_at, name=event.name, by=event.by, detail=detail)


def ride_delay_view(delay: RideDelay) -> RideDelayView:
    return RideDelayView(
        ride_id=delay.ride_id,
        ride_code=delay.ride_code,
        pickup_s=round(delay.pickup_s, 1),
        arrival_s=round(delay.arrival_s, 1),
    )


def feedback_view(feedback: Feedback, *, with_words: bool = True) -> FeedbackView:
    words = feedback.lost_property if with_words else ""
    return FeedbackView(rating=feedback.rating, lost_property=words, made_at=feedback.made_at)


def ride_record(
    ride: Ride, boarding_code: str, outlook: RideOutlook, feedback: FeedbackView | None = None
) -> RideRecord:
    more = {
        "feedback": feedback,
        "source": ride.source,
        "boarding_code": boarding_code,
        "series_id": ride.series_id,
    }
    return RideRecord.model_validate(_fields(ride, outlook) | more)


def tap_view(tap: Tap) -> TapView:
    return TapView(tap_id=tap.tap_id, kind=tap.kind, state=tap.state, reason=tap.reason)


def _fields(ride: Ride, outlook: RideOutlook) -> dict[str, object]:
    pickup, arrival = outlook.pickup, outlook.arrival
    return {
        "ride_id": ride.ride_id,
        "ride_code": ride.ride_code,
        "state": ride.state,
        "from_stop": ride.from_stop,
        "to_stop": ride.to_stop,
        "party": ride.party,
        "wheelchairs": ride.wheelchairs,
        "earliest": ride.earliest,
        "requested_at": ride.requested_at,
        "promise": None if ride.promise is None else _promise(ride.promise),
        "vehicle_id": ride.vehicle_id,
        "vehicle_name": outlook.vehicle_name,
        "pickup_eta": ride.pickup_eta,
        "pickup_earliest": None if pickup is None else pickup.earliest,
        "pickup_latest": None if pickup is None else pickup.latest,
        "arrival_eta": ride.arrival_eta,
        "arrival_earliest": None if arrival is None else arrival.earliest,
        "arrival_latest": None if arrival is None else arrival.latest,
        "boarded_at": ride.boarded_at,
        "ended_at": ride.ended_at,
        "reason": ride.reason,
        "reason_detail": ride.reason_detail,
        "promise_broken": ride.promise_broken,
        "first_promise": None if ride.first_promise is None else _promise(ride.first_promise),
        "left_early": ride.left_early,
        "first_to_stop": ride.first_to_stop,
        "let_out": ride.let_out,
        "stranded_by": ride.stranded_by,
        "seats_left": outlook.seats_left,
    }


def _promise(promise: Promise) -> PromiseView:
    return PromiseView(
        pickup_from=promise.pickup_from, pickup_to=promise.pickup_to, arrive_by=promise.arrive_by
    )

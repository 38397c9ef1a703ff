"""Explains decisions about a ride as text: the shuttles considered, the assignment, or the refusal."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from zoneinfo import ZoneInfo

from contract.roads.model import RoadMap
from server.dispatch.problem_codec import ProblemUnreadable, decode_problem
from server.domain.planning.decisions import (
    Alternative,
    Decision,
    Quote,
    RideDecision,
)
from server.domain.rides.rides import Ride, RideState
from server.usecases.record.refusals import REFUSAL_TEXTS

_HEADS = {
    "booking": "Booking",
    "change": "Change of destination",
    "reassignment": "Reassignment to another shuttle",
    "improvement": "Improvement of the fleet's plan",
}


@dataclass(frozen=True, slots=True)
class StoredRideDecision:
    """A decision's record for one ride, and the complete decision if it is still stored."""

    of_ride: RideDecision
    complete: Decision | None

    @property
    def kind(self) -> str:
        return "booking" if self.complete is None else self.complete.kind


class Explainer:
    """Writes texts with the names and the time zone of one campus."""

    def __init__(self, road_map: RoadMap, vehicle_names: Mapping[str, str]) -> None:
        self._zone = ZoneInfo(road_map.timezone)
        self._stops = {stop.stop_id: stop.name_en or stop.name for stop in road_map.stops}
        self._vehicles = vehicle_names

    def lines(self, ride: Ride, decisions: Sequence[StoredRideDecision]) -> list[str]:
        """The ride, then a heading for each decision with its explanation, indented."""
        lines = [self._request_text(ride), self._state_text(ride)]
        if not decisions:
            lines += ["", "No decision about this ride is stored: none was made, or its record has expired."]
        for decision in decisions:
            lines += ["", f"{self._time(decision.of_ride.made_at)}  {_HEADS[decision.kind]}"]
            lines += [f"  {line}" for line in self._decision(ride, decision)]
        return lines

    # ------------------------------------------------------------ the ride

    def _request_text(self, ride: Ride) -> str:
        booked_to = ride.first_to_stop or ride.to_stop
        sooner = ride.earliest > ride.requested_at
        return (
            f"Ride {ride.ride_code} ({ride.ride_id}): {_people(ride.party, ride.wheelchairs)} from "
            f"{self._stop(ride.from_stop)} to {self._stop(booked_to)}, booked by the {ride.source} on "
            f"{ride.requested_at.astimezone(self._zone):%A %d %B %Y at %H:%M:%S}"
            + (f", not before {self._time(ride.earliest)}." if sooner else ".")
        )

    def _state_text(self, ride: Ride) -> str:
        text = f"It is {str(ride.state).replace('_', ' ')}"
        if ride.vehicle_id is not None:
            text += f" with {self._vehicle(ride.vehicle_id)}"
        if ride.reason:
            text += f" ({ride.reason}{': ' if ride.reason_detail else ''}{ride.reason_detail})"
        if ride.promise is not None:
            promise = ride.promise
            text += (
                f"; promised: pickup {self._time(promise.pickup_from)} to {self._time(promise.pickup_to)}, "
                f"there by {self._time(promise.arrive_by)}"
            )
            if ride.promise_broken:
                text += ", which was broken"
        return text + "."

    # ------------------------------------------------------------ a decision

    def _decision(self, ride: Ride, decision: StoredRideDecision) -> list[str]:
        of_ride = decision.of_ride
        lines = [self._vehicles_considered(decision)]
        if of_ride.best is None:
            text = REFUSAL_TEXTS.get(of_ride.rule, of_ride.rule)
            lines.append(f"Refused by the rule {of_ride.rule}: {text}.")
            lines += self._offered(of_ride.alternatives, ride)
        elif decision.kind == "improvement":
            lines += self._improved(of_ride.best, of_ride.runner_up)
        else:
            lines += self._assigned(of_ride.best, of_ride.runner_up)
        return lines

    def _vehicles_considered(self, decision: StoredRideDecision) -> str:
        count = decision.of_ride.vehicles
        if decision.complete is None:
            return f"{count} shuttles were asked."
        try:
            vehicles = decode_problem(decision.complete.problem).vehicles
        except ProblemUnreadable:
            return f"{count} shuttles were asked (the snapshot is of another version)."
        considered = [self._vehicle(v.vehicle_id) for v in vehicles if v.accepts]
        others = [self._vehicle(v.vehicle_id) for v in vehicles if not v.accepts]
        text = f"Asked: {', '.join(considered) or 'none'}."
        if others:
            text += f" Not asked, because they took no new rides: {', '.join(others)}."
        return text

    def _assigned(self, best: Quote, runner_up: Quote | None) -> list[str]:
        lines = [
            f"{self._vehicle(best.vehicle_id)} got it: {self._times(best)}; "
            f"the cost of the fleet's plan rises by {best.extra_cost_s:.0f} s."
        ]
        if runner_up is None:
            lines.append("No other shuttle could have taken it.")
        else:
            worse_s = runner_up.extra_cost_s - best.extra_cost_s
            lines.append(
                f"Next best was {self._vehicle(runner_up.vehicle_id)}: {self._times(runner_up)}; "
                f"{runner_up.extra_cost_s:.0f} s more, which is {worse_s:.0f} s worse."
            )
        return lines

    def _improved(self, best: Quote, before: Quote | None) -> list[str]:
        lines = [
            f"{self._vehicle(best.vehicle_id)} took it over: {self._times(best)}; "
            f"all changes of this improvement lower the plan's cost by {-best.extra_cost_s:.0f} s."
        ]
        if before is not None:
            lines.append(f"Before, {self._vehicle(before.vehicle_id)} was assigned: {self._times(before)}.")
        return lines

    def _offered(self, alternatives: Sequence[Alternative], ride: Ride) -> list[str]:
        if not alternatives:
            refused = ride.state is RideState.REFUSED
            return ["There was no alternative to offer instead."] if refused else []
        return ["Offered instead:", *(f"  - {self._alternative(one, ride)}" for one in alternatives)]

    def _alternative(self, one: Alternative, ride: Ride) -> str:
        times = ", then ".join(
            f"pickup {self._time(pickup)}, arrival {self._time(arrival)}"
            for pickup, arrival in zip(one.pickup_at, one.arrival_at, strict=True)
        )
        text = {
            "later": "later",
            "other_stops": f"from {self._stop(one.from_stop)} to {self._stop(one.to_stop)}",
            "split_party": f"in parties of {' and '.join(map(str, one.parties))}",
        }[one.kind]
        walk = f", {one.walk_s / 60.0:.0f} min on foot" if one.walk_s > 0.0 else ""
        return f"{text}: {times}{walk}"

    # ------------------------------------------------------------ names

    def _times(self, quote: Quote) -> str:
        return f"pickup {self._time(quote.pickup_at)}, arrival {self._time(quote.arrival_at)}"

    def _time(self, at: datetime) -> str:
        return f"{at.astimezone(self._zone):%H:%M:%S}"

    def _stop(self, stop_id: str) -> str:
        return self._stops.get(stop_id, stop_id)

    def _vehicle(self, vehicle_id: str) -> str:
        name = self._vehicles.get(vehicle_id, "")
        return vehicle_id if name in ("", vehicle_id) else f"{name} ({vehicle_id})"


def _people(party: int, wheelchairs: int) -> str:
    text = "1 person" if party == 1 else f"{party} people"
    return text if wheelchairs == 0 else f"{text}, {wheelchairs} in a wheelchair"

"""Decisions about a ride in plain words: what was asked, who was asked, who got it, or why nobody did."""

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
    "reassignment": "Another shuttle was looked for",
    "improvement": "The fleet's plan was improved",
}


@dataclass(frozen=True, slots=True)
class Decided:
    """A decision about a ride, with the whole of it where it is still stored."""

    about: RideDecision
    whole: Decision | None

    @property
    def kind(self) -> str:
        return "booking" if self.whole is None else self.whole.kind


class Explainer:
    """Words with the names and the time of one campus."""

    def __init__(self, road_map: RoadMap, vehicle_names: Mapping[str, str]) -> None:
        self._zone = ZoneInfo(road_map.timezone)
        self._stops = {stop.stop_id: stop.name_en or stop.name for stop in road_map.stops}
        self._vehicles = vehicle_names

    def lines(self, ride: Ride, decided: Sequence[Decided]) -> list[str]:
        """A heading for each decision, and what is to be said of it, indented."""
        said = [self._asked(ride), self._now(ride)]
        if not decided:
            said += ["", "No decision about this ride is stored: none was taken, or it is past the history."]
        for one in decided:
            said += ["", f"{self._time(one.about.made_at)}  {_HEADS[one.kind]}"]
            said += [f"  {line}" for line in self._decision(ride, one)]
        return said

    # ------------------------------------------------------------ the ride

    def _asked(self, ride: Ride) -> str:
        booked_to = ride.first_to_stop or ride.to_stop
        sooner = ride.earliest > ride.requested_at
        return (
            f"Ride {ride.ride_code} ({ride.ride_id}): {_people(ride.party, ride.wheelchairs)} from "
            f"{self._stop(ride.from_stop)} to {self._stop(booked_to)}, booked by the {ride.source} on "
            f"{ride.requested_at.astimezone(self._zone):%A %d %B %Y at %H:%M:%S}"
            + (f", not before {self._time(ride.earliest)}." if sooner else ".")
        )

    def _now(self, ride: Ride) -> str:
        words = f"It is {str(ride.state).replace('_', ' ')}"
        if ride.vehicle_id is not None:
            words += f" with {self._vehicle(ride.vehicle_id)}"
        if ride.reason:
            words += f" ({ride.reason}{': ' if ride.reason_detail else ''}{ride.reason_detail})"
        if ride.promise is not None:
            promise = ride.promise
            words += (
                f"; promised: pickup {self._time(promise.pickup_from)} to {self._time(promise.pickup_to)}, "
                f"there by {self._time(promise.arrive_by)}"
            )
            if ride.promise_broken:
                words += ", which was broken"
        return words + "."

    # ------------------------------------------------------------ a decision

    def _decision(self, ride: Ride, decided: Decided) -> list[str]:
        about = decided.about
        said = [self._vehicles_asked(decided)]
        if about.best is None:
            said.append(f"Refused by the rule {about.rule}: {REFUSAL_TEXTS.get(about.rule, about.rule)}.")
            said += self._instead(about.alternatives, ride)
        elif decided.kind == "improvement":
            said += self._improved(about.best, about.runner_up)
        else:
            said += self._taken(about.best, about.runner_up)
        return said

    def _vehicles_asked(self, decided: Decided) -> str:
        if decided.whole is None:
            return f"{decided.about.vehicles} shuttles were asked."
        try:
            vehicles = decode_problem(decided.whole.problem).vehicles
        except ProblemUnreadable:
            return f"{decided.about.vehicles} shuttles were asked (the snapshot is of another version)."
        asked = [self._vehicle(v.vehicle_id) for v in vehicles if v.accepts]
        others = [self._vehicle(v.vehicle_id) for v in vehicles if not v.accepts]
        words = f"Asked: {', '.join(asked) or 'nobody'}."
        if others:
            words += f" Not asked, because they took no new rides: {', '.join(others)}."
        return words

    def _taken(self, best: Quote, runner_up: Quote | None) -> list[str]:
        said = [
            f"{self._vehicle(best.vehicle_id)} got it: {self._times(best)}; "
            f"it costs the fleet's plan {best.extra_cost_s:.0f} s more."
        ]
        if runner_up is None:
            said.append("No other shuttle could have taken it.")
        else:
            worse_s = runner_up.extra_cost_s - best.extra_cost_s
            said.append(
                f"Next best was {self._vehicle(runner_up.vehicle_id)}: {self._times(runner_up)}; "
                f"{runner_up.extra_cost_s:.0f} s more, which is {worse_s:.0f} s worse."
            )
        return said

    def _improved(self, best: Quote, before: Quote | None) -> list[str]:
        said = [
            f"{self._vehicle(best.vehicle_id)} took it over: {self._times(best)}; "
            f"with all that changed at the same time the fleet's plan costs {-best.extra_cost_s:.0f} s less."
        ]
        if before is not None:
            said.append(f"Before, {self._vehicle(before.vehicle_id)} was to come: {self._times(before)}.")
        return said

    def _instead(self, alternatives: Sequence[Alternative], ride: Ride) -> list[str]:
        if not alternatives:
            refused = ride.state is RideState.REFUSED
            return ["Nothing could be offered instead."] if refused else []
        return ["Offered instead:", *(f"  - {self._alternative(one, ride)}" for one in alternatives)]

    def _alternative(self, one: Alternative, ride: Ride) -> str:
        times = ", then ".join(
            f"pickup {self._time(pickup)}, arrival {self._time(arrival)}"
            for pickup, arrival in zip(one.pickup_at, one.arrival_at, strict=True)
        )
        words = {
            "later": "later",
            "other_stops": f"from {self._stop(one.from_stop)} to {self._stop(one.to_stop)}",
            "split_party": f"in parties of {' and '.join(map(str, one.parties))}",
        }[one.kind]
        walk = f", {one.walk_s / 60.0:.0f} min on foot" if one.walk_s > 0.0 else ""
        return f"{words}: {times}{walk}"

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
    words = "1 person" if party == 1 else f"{party} people"
    return words if wheelchairs == 0 else f"{words}, {wheelchairs} in a wheelchair"

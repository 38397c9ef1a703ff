"""A campus's demand profile: counts by weekday and hour, by pair of places, and of cancellations.

`campus_nights.json` beside this file has the counts of a real year; `fit_profile` reads others.
"""

import json
from collections import Counter
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any, cast

import msgspec
import numpy as np

from contract.geometry import Array

WEEKDAYS = ("Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday")
HOURS = 24
# The places beyond are addresses with a few rides in a year.
PLACES_MAX = 31
_ARROW = " \u2192 "
_BUILT_IN = "campus_nights.json"


class DemandProfileError(ValueError):
    """The files are not aggregates of rides; the text names what is missing."""


class Method(msgspec.Struct, frozen=True):
    """A booking method: how many rides were booked by it, and how many of them were cancelled."""

    name: str
    booked: int
    cancelled: int

    @property
    def cancel_ratio(self) -> float:
        return self.cancelled / self.booked


class DemandProfile(msgspec.Struct, frozen=True):
    """Counts of recorded rides.

    hourly   7 weekdays (0 is Monday) of 24 hours, local time
    pairs    [from][to], places by rank: the one with the highest demand first
    """

    source: str
    hourly: tuple[tuple[int, ...], ...]
    pairs: tuple[tuple[int, ...], ...]
    methods: tuple[Method, ...]

    def hour_ratio(self, weekday: int) -> Array:
        """(24,) the share of a weekday's rides that begin in each hour."""
        counts = np.array(self.hourly[weekday], float)
        return cast(Array, counts / counts.sum())

    def pair_ratio(self, stops: int) -> Array:
        """(stops, stops) the share of rides from each stop to each other, by rank.

        If there are more stops than places, the further ones have the last place's demand.
        """
        rank = np.minimum(np.arange(stops), len(self.pairs) - 1)
        weights = np.array(self.pairs, float)[np.ix_(rank, rank)]
        if stops > len(self.pairs):
            counts = np.array(self.pairs, float)
            shared = np.outer(counts.sum(axis=1), counts.sum(axis=0)) / counts.sum()
            beyond = rank == len(self.pairs) - 1
            mixed = beyond[:, None] | beyond[None, :]
            weights = np.where(mixed, shared[np.ix_(rank, rank)], weights)
        np.fill_diagonal(weights, 0.0)
        return cast(Array, weights / weights.sum())

    @property
    def method_ratio(self) -> Array:
        booked = np.array([method.booked for method in self.methods], float)
        return cast(Array, booked / booked.sum())

    @property
    def cancel_ratio(self) -> float:
        """Of all rides, for all booking methods."""
        return sum(m.cancelled for m in self.methods) / sum(m.booked for m in self.methods)


def built_in_profile() -> DemandProfile:
    """Campus nights of the University of North Texas; see `source` in the file."""
    content = files("simulator.demand").joinpath(_BUILT_IN).read_bytes()
    return msgspec.json.decode(content, type=DemandProfile)


def fit_profile(folder: Path) -> DemandProfile:
    """Read the aggregates of a folder: *hourly_by_day*.json, *route_demand*.json, *stops*.json and
    *cancellation_by_booking_method*.json.

    Raises DemandProfileError.
    """
    hourly = _read(folder, "hourly_by_day")
    routes = _read(folder, "route_demand")
    stops = _read(folder, "stops")
    methods = _read(folder, "cancellation_by_booking_method")
    try:
        return DemandProfile(
            source=f"fitted to {folder.name}",
            hourly=_by_weekday(hourly),
            pairs=_by_rank({row["route"]: row["count"] for row in routes["routes"]}, stops),
            methods=tuple(
                Method(row["booking_method"], row["total"], row["cancelled"])
                for row in methods["cancellation_by_booking_method"]
            ),
        )
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise DemandProfileError(f"{folder}: the aggregates lack or misspell {error}") from error


def _read(folder: Path, name: str) -> Any:
    found = sorted(folder.glob(f"*{name}*.json"))
    if not found:
        raise DemandProfileError(f"{folder} has no *{name}*.json")
    try:
        return json.loads(found[0].read_text())
    except (OSError, ValueError) as error:
        raise DemandProfileError(f"{found[0]}: {error}") from error


def _by_weekday(months: Mapping[str, Mapping[str, Mapping[str, int]]]) -> tuple[tuple[int, ...], ...]:
    """The sums over all months."""
    counts = np.zeros((len(WEEKDAYS), HOURS), np.int64)
    for month in months.values():
        for weekday, hours in month.items():
            for hour, rides in hours.items():
                counts[WEEKDAYS.index(weekday), int(hour)] += rides
    if not counts.sum(axis=1).all():
        raise ValueError("a weekday without rides")
    return tuple(tuple(int(n) for n in row) for row in counts)


def _by_rank(
    routes: Mapping[str, int], stops: Mapping[str, Mapping[str, float]]
) -> tuple[tuple[int, ...], ...]:
    """Several names of one place, at the same coordinates, count as one."""
    pairs: Counter[tuple[str, str]] = Counter()
    for route, rides in routes.items():
        ends = [_place(name, stops) for name in route.split(_ARROW)]
        if len(ends) == 2 and ends[0] != ends[1]:
            pairs[ends[0], ends[1]] += rides
    demand: Counter[str] = Counter()
    for (origin, destination), rides in pairs.items():
        demand[origin] += rides
        demand[destination] += rides
    places = sorted(demand, key=lambda place: (-demand[place], place))[:PLACES_MAX]
    if len(places) < 2:
        raise ValueError("routes between two places at least")
    return tuple(tuple(pairs[origin, destination] for destination in places) for origin in places)


def _place(name: str, stops: Mapping[str, Mapping[str, float]]) -> str:
    known = stops.get(name.strip())
    return name.strip() if known is None else f"{known['lat']},{known['lng']}"

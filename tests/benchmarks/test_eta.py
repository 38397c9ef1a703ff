"""The benchmark of shown times: what counts as inside, and a short run of it."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from benchmarks.eta.__main__ import first_of_each, inside_pct
from benchmarks.eta.shown_ranges import ShownRange, shown_ranges
from campusloop.shipped import DEFAULT_MAP
from contract.roads.load import load_map
from server.domain.planning.eta_ranges import ExpectedRange

AT = datetime(2026, 9, 1, 8, 0, tzinfo=UTC)


def shown(ride_id: str, picked_up_s: float, minute: int = 0) -> ShownRange:
    """A range from 60 to 120 s after AT, and a pickup."""
    told = ExpectedRange(AT + timedelta(seconds=60), AT + timedelta(seconds=120))
    at = AT + timedelta(minutes=minute)
    return ShownRange(ride_id, at, 90.0, "on_time", told, AT + timedelta(seconds=picked_up_s))


def test_a_pickup_at_either_end_is_inside_and_one_beyond_is_not() -> None:
    ranges = [shown("a", 60), shown("a", 120), shown("b", 59), shown("b", 121)]
    assert inside_pct(ranges) == 50.0
    assert inside_pct([]) is None
    assert ranges[0].width_s == 60.0


def test_only_the_first_range_of_each_party_counts_as_first() -> None:
    first = first_of_each([shown("a", 60), shown("a", 130, minute=1), shown("b", 130)])
    assert [one.ride_id for one in first] == ["a", "b"]
    assert inside_pct(first) == 50.0


@pytest.mark.long
def test_most_pickups_of_an_hour_are_inside(tmp_path: Path) -> None:
    simulated = shown_ranges(load_map(DEFAULT_MAP), tmp_path, seed=7, hours=1.0)
    ranges = simulated.ranges
    assert simulated.violations == []
    assert len(ranges) > 20
    share = inside_pct(ranges)
    assert share is not None
    assert share > 80.0
    arrivals = inside_pct(simulated.arrivals)
    assert arrivals is not None
    assert arrivals > 80.0

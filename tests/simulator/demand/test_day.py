"""Drawn days have the shape of what they were fitted to, and a seed repeats them."""

import json
import os
from datetime import date
from pathlib import Path
from zoneinfo import ZoneInfo

import numpy as np
import pytest

from contract.geometry import Array
from simulator.demand.day import WantedRide, draw_day
from simulator.demand.profile import DemandProfileError, built_in_profile, fit_profile
from simulator.demand.table import RideTableError, read_rides, write_rides

THURSDAY, SUNDAY = date(2026, 1, 8), date(2026, 1, 11)
ZONE = ZoneInfo("Asia/Shanghai")
STOPS = [f"stop-{k}" for k in range(16)]
MANY = 20_000
# Of a normal deviate: a right generator fails once in some thousand tries, and the seeds are fixed.
SIGMAS = 4.0


def drawn(rides: int = MANY, seed: int = 1, day: date = THURSDAY) -> tuple[WantedRide, ...]:
    return draw_day(built_in_profile(), STOPS, day, ZONE, rides, seed)


def assert_shares(counts: Array, ratios: Array) -> None:
    """Each count is within its sampling error of what its share makes it expect."""
    total = counts.sum()
    error = np.sqrt(total * ratios * (1.0 - ratios))
    assert (np.abs(counts - total * ratios) <= SIGMAS * error + 1e-9).all()


@pytest.mark.parametrize("day", [THURSDAY, SUNDAY])
def test_each_hour_has_its_weekdays_share_of_the_rides(day: date) -> None:
    hours = np.bincount([ride.announced_at.astimezone(ZONE).hour for ride in drawn(day=day)], minlength=24)
    assert_shares(hours, built_in_profile().hour_ratio(day.weekday()))


def test_cancellations_have_the_fitted_rate_of_each_way_of_booking() -> None:
    rides, profile = drawn(), built_in_profile()
    assert profile.cancel_ratio == pytest.approx(5633 / 16511)
    for method in profile.methods:
        gone = [ride.cancelled_at is not None for ride in rides if ride.booked_by == method.name]
        ratio = np.array([method.cancel_ratio, 1.0 - method.cancel_ratio])
        assert_shares(np.array([sum(gone), len(gone) - sum(gone)]), ratio)
    assert all(r.cancelled_at > r.announced_at for r in rides if r.cancelled_at is not None)


def test_pairs_of_stops_have_their_popularity_by_rank() -> None:
    counts = np.zeros((len(STOPS), len(STOPS)))
    for ride in drawn():
        counts[STOPS.index(ride.from_stop), STOPS.index(ride.to_stop)] += 1
    ratios = built_in_profile().pair_ratio(len(STOPS))
    assert_shares(counts, ratios)
    asked = ratios.sum(axis=0) + ratios.sum(axis=1)
    assert asked.argmax() == 0
    assert not counts.diagonal().any()


def test_a_campus_with_more_stops_than_the_profile_has_rides_to_all_of_them() -> None:
    ratios = built_in_profile().pair_ratio(50)
    assert ratios.sum() == pytest.approx(1.0)
    assert (ratios.sum(axis=0) > 0.0).all()
    assert (ratios.sum(axis=1) > 0.0).all()


def test_the_same_seed_writes_the_same_file_and_it_is_read_back(tmp_path: Path) -> None:
    one, again, other = (tmp_path / name for name in ("one.csv", "again.csv", "other.csv"))
    for path, seed in ((one, 7), (again, 7), (other, 8)):
        write_rides(path, drawn(200, seed))
    assert one.read_bytes() == again.read_bytes() != other.read_bytes()
    assert read_rides(one) == tuple(sorted(drawn(200, 7), key=lambda r: (r.announced_at, r.ride)))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a,b\n1,2\n", "no column announced_at"),
        ("announced_at,from_stop,to_stop\n2026-01-08T19:00:00,a,b\n", "line 2: .* has no offset"),
        ("announced_at,from_stop,to_stop,party\n2026-01-08T19:00:00Z,a,b,0\n", "at least one person"),
        (
            "announced_at,from_stop,to_stop,ride\n" + "2026-01-08T19:00:00Z,a,b,r1\n" * 2,
            "two rides called r1",
        ),
    ],
)
def test_a_table_that_cannot_be_read_says_where_and_why(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "rides.csv"
    path.write_text(text)
    with pytest.raises(RideTableError, match=words):
        read_rides(path)


def some_aggregates(folder: Path) -> None:
    week = ("Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday")
    months = {month: {day: {"20": 3, "21": 1} for day in week} for month in ("january", "march")}
    routes = [("A \u2192 B", 5), ("B \u2192 A (north)", 2), ("A \u2192 C", 1), ("A \u2192 A (north)", 9)]
    methods = [{"booking_method": "app", "total": 10, "cancelled": 4}]
    for name, content in (
        ("hourly_by_day_data", months),
        ("route_demand", {"routes": [{"route": route, "count": count} for route, count in routes]}),
        ("stops", {"A": {"lat": 1.0, "lng": 2.0}, "A (north)": {"lat": 1.0, "lng": 2.0}}),
        ("cancellation_by_booking_method", {"cancellation_by_booking_method": methods}),
    ):
        (folder / f"x_{name}.json").write_text(json.dumps(content))


def test_a_profile_is_fitted_to_aggregates_and_names_of_one_place_are_merged(tmp_path: Path) -> None:
    some_aggregates(tmp_path)
    profile = fit_profile(tmp_path)
    assert profile.hour_ratio(0)[20] == pytest.approx(0.75)
    assert profile.pairs == ((0, 5, 1), (2, 0, 0), (0, 0, 0))
    assert profile.cancel_ratio == pytest.approx(0.4)


def test_the_built_in_numbers_are_those_of_the_files() -> None:
    default = Path(__file__).resolve().parents[3].parent / "shared"
    folder = Path(os.environ.get("CAMPUSLOOP_SHARED", default)) / "data" / "demand"
    if not folder.is_dir():
        pytest.skip(f"no aggregates under {folder}; set CAMPUSLOOP_SHARED")
    fitted, built_in = fit_profile(folder), built_in_profile()
    assert (fitted.hourly, fitted.pairs, fitted.methods) == (
        built_in.hourly,
        built_in.pairs,
        built_in.methods,
    )


def test_a_folder_without_aggregates_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(DemandProfileError, match=r"has no .*hourly_by_day"):
        fit_profile(tmp_path)

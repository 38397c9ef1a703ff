"""Departures, in local time."""

from datetime import UTC, date, datetime

from contract.roads.model import TimetableTrip
from server.domain.service.timetable import departures_of


def test_departures_are_local_times_and_sorted_by_their_first_call() -> None:
    trips = [
        TimetableTrip("late", (("A", 9 * 3600), ("B", 9 * 3600 + 180))),
        TimetableTrip("early", (("A", 8 * 3600), ("B", 8 * 3600 + 180))),
    ]
    first, second = departures_of("campus", trips, "Asia/Shanghai", date(2026, 11, 23))
    assert first.departure_id == "early@2026-11-23"
    assert first.calls[0].leave_at == datetime(2026, 11, 23, 0, 0, tzinfo=UTC)
    assert second.calls[1].leave_at == datetime(2026, 11, 23, 1, 3, tzinfo=UTC)


def test_a_trip_past_midnight_belongs_to_the_day_on_which_it_began() -> None:
    trip = TimetableTrip("night", (("A", 25 * 3600), ("B", 25 * 3600 + 180)))
    (departure,) = departures_of("campus", [trip], "Asia/Shanghai", date(2026, 11, 23))
    assert departure.calls[0].leave_at == datetime(2026, 11, 23, 17, 0, tzinfo=UTC)
    assert departure.day == date(2026, 11, 23)

"""Texts that say why a ride is refused and what to do."""

from datetime import datetime

from server.domain.service.service import ServiceCalendar

REFUSAL_TEXTS = {
    "no_vehicle_free": "no shuttle is in service at that time",
    "seats": "no shuttle has so many seats",
    "wheelchair": "no shuttle has so many wheelchair places",
    "pickup_window": "every shuttle is too busy to pick you up in time",
    "ride_time": "the ride would take too long",
    "arrival": "no shuttle could bring you there in time",
    "timetable": "every shuttle that could come has a timetable to keep",
    "battery": "no shuttle has enough charge left for this ride",
    "closed_road": "a road closure cuts these stops off from each other",
}
# Rules that may bind because the service closes.
IN_TIME = ("pickup_window", "ride_time", "arrival")


def closing_text(calendar: ServiceCalendar, closes: datetime) -> str:
    """Why a ride that would end after closing is refused, and what to book instead."""
    local = closes.astimezone(calendar.zone)
    return f"the service closes at {local:%H:%M}, before you could be there; {calendar.advice(closes)}"

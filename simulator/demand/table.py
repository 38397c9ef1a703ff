"""Reads and writes a day of rides as a CSV file: a ride a row, times in ISO 8601 with offset."""

import csv
import io
from datetime import datetime
from pathlib import Path

from simulator.demand.day import WantedRide

COLUMNS = (
    "ride",
    "announced_at",
    "earliest",
    "from_stop",
    "to_stop",
    "party",
    "wheelchairs",
    "booked_by",
    "cancelled_at",
)
_NEEDED = ("announced_at", "from_stop", "to_stop")


class RideTableError(ValueError):
    """The file is not a valid table of rides; the text names the row and the error."""


def write_rides(path: Path, rides: tuple[WantedRide, ...]) -> None:
    """Raises OSError."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for ride in rides:
        writer.writerow(_cell(getattr(ride, column)) for column in COLUMNS)
    path.write_text(text.getvalue(), encoding="utf-8", newline="")


def read_rides(path: Path) -> tuple[WantedRide, ...]:
    """The rides in the order of announcement.

    Columns are found by the header row. announced_at, from_stop and to_stop are required; the others have
    defaults.

    Raises RideTableError, OSError.
    """
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = csv.DictReader(file)
        try:
            missing = [name for name in _NEEDED if name not in (rows.fieldnames or ())]
            if missing:
                raise RideTableError(f"{path} has no column {', '.join(missing)}")
            rides = [_ride(path, number, row) for number, row in enumerate(rows, start=2)]
        except (csv.Error, UnicodeDecodeError) as error:
            raise RideTableError(f"{path} is not a CSV file: {error}") from error
    names = [ride.ride for ride in rides]
    if len(set(names)) != len(names):
        again = next(name for k, name in enumerate(names) if name in names[:k])
        raise RideTableError(f"{path} has two rides called {again}")
    return tuple(sorted(rides, key=lambda ride: (ride.announced_at, ride.ride)))


def _cell(value: object) -> object:
    if value is None:
        return ""
    return value.isoformat() if isinstance(value, datetime) else value


def _ride(path: Path, number: int, row: dict[str, str | None]) -> WantedRide:
    def cell(name: str) -> str:
        return (row.get(name) or "").strip()

    try:
        announced_at = _moment(cell("announced_at"))
        ride = WantedRide(
            ride=cell("ride") or f"row {number}",
            announced_at=announced_at,
            earliest=_moment(cell("earliest")) if cell("earliest") else announced_at,
            from_stop=cell("from_stop"),
            to_stop=cell("to_stop"),
            party=int(cell("party") or 1),
            wheelchairs=int(cell("wheelchairs") or 0),
            booked_by=cell("booked_by"),
            cancelled_at=_moment(cell("cancelled_at")) if cell("cancelled_at") else None,
        )
    except ValueError as error:
        raise RideTableError(f"{path}, line {number}: {error}") from error
    if ride.party < 1 or not 0 <= ride.wheelchairs <= ride.party:
        raise RideTableError(
            f"{path}, line {number}: a party has at least one person, and no more wheelchairs than people"
        )
    return ride


def _moment(text: str) -> datetime:
    moment = datetime.fromisoformat(text)
    if moment.tzinfo is None:
        raise ValueError(f"{text} has no offset; write 2026-01-08T19:00:00+08:00")
    return moment

"""Calendars, and the timetable's departures."""

from datetime import date
from typing import Protocol

from server.domain.service.service import ServiceException, ServicePattern
from server.domain.service.timetable import Departure
from server.domain.service.trips import Timetable, TimetableVersion


class DepartureRepository(Protocol):
    def get(self, departure_id: str) -> Departure | None: ...

    def unfinished(self) -> tuple[Departure, ...]:
        """Planned or assigned, by first call."""
        ...

    def add(self, departure: Departure) -> None: ...

    def save(self, departure: Departure) -> None: ...


class ServiceRepository(Protocol):
    def patterns(self) -> tuple[ServicePattern, ...]:
        """By service id."""
        ...

    def pattern(self, service_id: str) -> ServicePattern | None: ...

    def save_pattern(self, pattern: ServicePattern) -> None:
        """New, or in place of the one of this service."""
        ...

    def remove_pattern(self, service_id: str) -> None:
        """With its exceptions."""
        ...

    def timetable(self, revision: int | None = None) -> Timetable | None:
        """A version, the newest where none is named; None while there is none."""
        ...

    def timetable_versions(self, limit: int) -> tuple[TimetableVersion, ...]:
        """Newest first."""
        ...

    def add_timetable(self, timetable: Timetable) -> None: ...

    def exceptions(self, since: date | None = None) -> tuple[ServiceException, ...]:
        """By day, the whole campus's before single services'."""
        ...

    def save_exception(self, exception: ServiceException) -> None: ...

    def remove_exception(self, day: date, service_id: str) -> bool:
        """False when there was none."""
        ...

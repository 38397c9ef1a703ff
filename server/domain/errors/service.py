"""Refusals of the hours of service and its calendars."""

from server.domain.errors.base import DomainError


class NoService(DomainError):
    """The campus does not run at that time, or not for long enough; the detail names when it opens."""

    code = "no_service"


class PatternUnknown(DomainError):
    """No service of this name has a calendar."""

    code = "pattern_unknown"


class PatternInvalid(DomainError):
    """A calendar whose days or hours contradict each other."""

    code = "pattern_invalid"


class PatternInUse(DomainError):
    """Timetable trips run by this calendar."""

    code = "pattern_in_use"


class ExceptionUnknown(DomainError):
    """The calendar has no exception on that day."""

    code = "exception_unknown"


class AnnouncementInvalid(DomainError):
    """An announcement without text or with too long a one, or one that ends before it begins."""

    code = "announcement_invalid"


class AnnouncementUnknown(DomainError):
    """No announcement has this id."""

    code = "announcement_unknown"


class AnnouncementOver(DomainError):
    """The announcement's time has passed, or it was ended already."""

    code = "announcement_over"


class TimetableInvalid(DomainError):
    """A trip of the timetable cannot run: its stops, times or service are wrong."""

    code = "timetable_invalid"


class TimetableChanged(DomainError):
    """Another operator has changed the timetable since it was read."""

    code = "timetable_changed"


class TimetableUnknown(DomainError):
    """The timetable has no such version."""

    code = "timetable_unknown"

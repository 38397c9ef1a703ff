"""Instants as numbers since the Unix epoch, and back. Moments are aware datetimes."""

from datetime import UTC, datetime, timedelta

EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_DAY_S = 86_400


def ns_of(moment: datetime) -> int:
    """Nanoseconds, exact to the microsecond that datetimes hold; what the wire uses."""
    since = moment - EPOCH
    return ((since.days * _DAY_S + since.seconds) * 1_000_000 + since.microseconds) * 1000


def moment_of_ns(stamp_ns: int) -> datetime:
    """To the microsecond."""
    return EPOCH + timedelta(microseconds=stamp_ns // 1000)


def ms_of(moment: datetime | None) -> int:
    """Milliseconds, exact in a JavaScript number; 0 for None."""
    return 0 if moment is None else (moment - EPOCH) // timedelta(milliseconds=1)

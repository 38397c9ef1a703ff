"""Server time on the wire: integer nanoseconds since the Unix epoch, UTC."""

from datetime import UTC, datetime, timedelta

EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


def ns_of(moment: datetime) -> int:
    """moment: aware. Exact to the microsecond that datetimes hold."""
    return (moment - EPOCH) // timedelta(microseconds=1) * 1000

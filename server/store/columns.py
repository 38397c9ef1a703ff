"""How values are stored in columns: instants in UTC, nested values as JSON text."""

from datetime import UTC, datetime
from typing import TypeVar

import msgspec
from sqlalchemy import DateTime, Dialect
from sqlalchemy.types import TypeDecorator

T = TypeVar("T")

_encoder = msgspec.json.Encoder()


class Utc(TypeDecorator[datetime]):
    """An aware UTC datetime, microseconds kept; SQLite has no zones, so the zone is given back on reading."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        if value is None:
            return None
        if value.tzinfo is None:
            raise ValueError(f"{value} has no time zone; the store keeps instants")
        return value.astimezone(UTC)

    def process_result_value(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        if value is None:
            return None
        return value.replace(tzinfo=UTC) if value.tzinfo is None else value.astimezone(UTC)


def to_json(value: object) -> str:
    return _encoder.encode(value).decode()


def from_json(text: str, kind: type[T]) -> T:
    """Raises msgspec.ValidationError for text that another version of the program wrote differently."""
    return msgspec.json.decode(text, type=kind)

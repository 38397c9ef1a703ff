"""The naming of constraints, and the columns that many tables have."""

from datetime import datetime

from sqlalchemy import Column, MetaData, String, Text

from server.store.columns import Utc

metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "pk": "pk_%(table_name)s",
    }
)


def campus_key() -> Column[str]:
    return Column("campus_id", String(64), primary_key=True)


def key(name: str, length: int = 64) -> Column[str]:
    return Column(name, String(length), primary_key=True)


def string(name: str, length: int = 64) -> Column[str]:
    return Column(name, String(length), nullable=False)


def text(name: str) -> Column[str]:
    return Column(name, Text, nullable=False)


def instant(name: str) -> Column[datetime]:
    return Column(name, Utc(), nullable=False)


def optional_instant(name: str) -> Column[datetime]:
    return Column(name, Utc(), nullable=True)

"""Runs migrations on the connection it is given, or on the database named by CAMPUSLOOP_DATABASE_URL."""

import os

from alembic import context
from sqlalchemy import Connection, create_engine

from server.store.tables import metadata


def render_item(kind: str, item: object, _autogen: object) -> str | bool:
    """A migration must stand alone: it names no type of the program."""
    if kind == "type" and type(item).__name__ == "Utc":
        return "sa.DateTime(timezone=True)"
    return False


def migrate(connection: Connection) -> None:
    context.configure(
        connection=connection, target_metadata=metadata, render_item=render_item, render_as_batch=True
    )
    with context.begin_transaction():
        context.run_migrations()


def migrate_by_url() -> None:
    url = os.environ.get("CAMPUSLOOP_DATABASE_URL")
    if not url:
        raise SystemExit("set CAMPUSLOOP_DATABASE_URL, e.g. sqlite:///var/campusloop.db")
    with create_engine(url.replace("postgresql://", "postgresql+psycopg://", 1)).connect() as connection:
        migrate(connection)
        connection.commit()


given = context.config.attributes.get("connection")
if given is None:
    migrate_by_url()
else:
    migrate(given)

"""Bringing a database up to the tables that this version of the program needs."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Engine
from sqlalchemy.exc import SQLAlchemyError

from server.domain.errors import StoreUnavailable
from server.store.writing.failures import cause_of

# Any number that means nothing else in this database.
_MIGRATION_LOCK = 4_117_001
MIGRATIONS = Path(__file__).resolve().parents[2] / "migrations"


class DatabaseTooNew(RuntimeError):
    """The database was written by a newer version of the program."""


def upgrade_to_head(engine: Engine) -> None:
    """Run every migration that is missing, all in one transaction; nothing where none is.

    Raises DatabaseTooNew.
    """
    config = alembic_config()
    scripts = ScriptDirectory.from_config(config)
    with engine.begin() as connection:
        if engine.dialect.name == "postgresql":
            # Several servers may start at once. SQLite's transaction is exclusive.
            connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({_MIGRATION_LOCK})")
        present = MigrationContext.configure(connection).get_current_revision()
        if present == scripts.get_current_head():
            return
        if present is not None and present not in {script.revision for script in scripts.walk_revisions()}:
            raise DatabaseTooNew(
                f"the database is at {present}, which this version does not know; update the program"
            )
        config.attributes["connection"] = connection
        command.upgrade(config, "head")


def is_current(engine: Engine) -> bool:
    """The database has exactly the tables of this version. Raises StoreUnavailable."""
    try:
        present = present_revision(engine)
    except SQLAlchemyError as error:
        raise StoreUnavailable(f"the database cannot be read now ({cause_of(error)})") from error
    return present == head_revision()


def present_revision(engine: Engine) -> str | None:
    """The revision of the tables in the database, None if it has none. Raises SQLAlchemyError."""
    with engine.connect() as connection:
        return MigrationContext.configure(connection).get_current_revision()


def head_revision() -> str:
    """The revision of this version's tables."""
    head = ScriptDirectory.from_config(alembic_config()).get_current_head()
    assert head is not None
    return head


def known_revisions() -> frozenset[str]:
    """All revisions that this version can bring to its own."""
    return frozenset(
        script.revision for script in ScriptDirectory.from_config(alembic_config()).walk_revisions()
    )


def alembic_config() -> Config:
    """Where the migrations are."""
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    return config

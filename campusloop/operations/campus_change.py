"""One change of a stored campus, whether its servers run or not."""

import os
from collections.abc import Callable
from typing import TypeVar

from server.adapters import Argon2Hasher, RandomIds, SystemClock
from server.domain.rides.ticket_keys import TicketKeys
from server.domain.rules import FleetRules
from server.settings import settings_from
from server.store.engine import open_engine
from server.store.roads.map_library import MapLibrary
from server.store.unit_of_work import Context
from server.store.writing.retries import Retries
from server.store.writing.writer import Job, Writer
from server.usecases.ports.unit_of_work import UnitOfWork

T = TypeVar("T")


def change_campus(database_url: str | None, campus_id: str, work: Callable[[UnitOfWork], T]) -> T:
    """What the use case returns; it is stored. It may need no ticket keys and no rules of the settings.

    Servers that run see that another has written, as replicas do. Nothing is sent on their bus: they find out
    when they read next, open connections within `RECHECK_EVERY_S` of `server/api/security/access_watch.py`.

    database_url  None: that of the settings

    Raises SettingsError, DatabaseUnsupported, what `work` raises, and StoreUnavailable and OutcomeUnknown.
    """
    engine = open_engine(settings_from(os.environ, database_url=database_url).database())
    rules = FleetRules()
    context = Context(
        campus_id, SystemClock(), RandomIds(), rules, Argon2Hasher(), MapLibrary(rules), TicketKeys(())
    )
    writer = Writer(engine, context, Retries())
    try:
        job = Job(work)
        writer.write([job])
        result, _ = job.result()
        return result
    finally:
        writer.close()
        engine.dispose()

"""The history of a campaign of kills, judged by the rules of `campusloop.simulation.history`."""

import asyncio
import time

from sqlalchemy import select

from benchmarks.faults.agent_process import AgentProcess
from benchmarks.faults.riders import Riders
from benchmarks.faults.stored_events import acknowledged_by, not_stored
from benchmarks.faults.wire_vehicle import WireVehicle
from campusloop.simulation.history import rides
from campusloop.simulation.history.records import Violation
from server.store import tables
from server.store.engine import open_engine
from server.store.planning.plans import plan_from_row

_STORED_WITHIN_S = 60.0


async def verdict(
    url: str, riders: Riders, vehicle: WireVehicle, agent: AgentProcess
) -> tuple[list[Violation], int]:
    """What is broken, and how many events were checked. Events may still be on their way for a minute.

    url  of the database, as SQLAlchemy has it
    """
    promised = agent.promised() | acknowledged_by(vehicle)
    until_s = time.monotonic() + _STORED_WITHIN_S
    while (found := not_stored(url, promised)) and time.monotonic() < until_s:  # noqa: ASYNC110
        await asyncio.sleep(1.0)
    at_s = time.monotonic() - riders.begun_s
    engine = open_engine(url)
    with engine.connect() as connection:
        keys = {row.ride_id: row.idempotency_key for row in connection.execute(select(tables.rides))}
        planned = {
            row.vehicle_id: plan_from_row(row).ride_ids for row in connection.execute(select(tables.plans))
        }
    engine.dispose()
    found += rides.lost_bookings(at_s, riders.acknowledged, keys)
    found += rides.doubled_bookings(at_s, riders.acknowledged)
    found += rides.doubled_keys(at_s, {ride_id: key for ride_id, key in keys.items() if key})
    found += rides.planned_twice(at_s, planned)
    return found, sum(len(events) for events in promised.values())

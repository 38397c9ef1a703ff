"""The history of a campaign of kills, judged by the rules of `campusloop.simulation.history`."""

import asyncio
import time
from collections.abc import Mapping

import msgspec
from sqlalchemy import Engine, select

from benchmarks.faults.riders import Riders
from benchmarks.faults.wire_vehicle import WireVehicle
from benchmarks.kills.agent_process import AgentProcess
from campusloop.simulation.history import rides, vehicles
from campusloop.simulation.history.records import Violation
from contract.wire.messages import VehicleEvent
from server.store import tables
from server.store.engine import open_engine
from server.store.planning.plans import plan_from_row

_STORED_WITHIN_S = 60.0
_decoder = msgspec.json.Decoder(VehicleEvent)


async def verdict(
    url: str, riders: Riders, vehicle: WireVehicle, agent: AgentProcess
) -> tuple[list[Violation], int]:
    """What is broken, and how many events were checked. Events may still be on their way for a minute.

    url  of the database, as SQLAlchemy has it
    """
    promised = {(agent.vehicle_id, boot_id): events for boot_id, events in agent.durable().items()}
    promised[vehicle.vehicle_id, vehicle.boot_id] = {
        number: msgspec.json.encode(body).decode()
        for number, body in enumerate(vehicle.events[: vehicle.acknowledged])
    }
    engine = open_engine(url)
    until_s = time.monotonic() + _STORED_WITHIN_S
    while (found := _lost_events(engine, promised)) and time.monotonic() < until_s:  # noqa: ASYNC110
        await asyncio.sleep(1.0)
    at_s = time.monotonic() - riders.begun_s
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


def _lost_events(engine: Engine, promised: Mapping[tuple[str, str], Mapping[int, str]]) -> list[Violation]:
    event = tables.vehicle_events.c
    found: list[Violation] = []
    with engine.connect() as connection:
        for (vehicle_id, boot_id), events in promised.items():
            rows = connection.execute(
                select(event.sequence, event.body).where(
                    event.vehicle_id == vehicle_id, event.boot_id == boot_id
                )
            )
            stored = {row.sequence: _as_sent(row.body) for row in rows}
            found += vehicles.lost_events(0.0, vehicle_id, boot_id, events, stored)
    return found


def _as_sent(body: object) -> str:
    text = body if isinstance(body, (str, bytes)) else msgspec.json.encode(body)
    return msgspec.json.encode(_decoder.decode(text)).decode()

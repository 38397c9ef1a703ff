"""Whether the events that vehicles may rely on are stored once, by the rules of the history checker."""

from collections.abc import Mapping

import msgspec
from sqlalchemy import select

from benchmarks.faults.wire_vehicle import WireVehicle
from campusloop.simulation.history.records import Violation
from campusloop.simulation.history.vehicles import doubled_events, lost_events
from contract.wire.messages import VehicleEvent
from server.store import tables
from server.store.engine import open_engine

# Events that must be stored: by vehicle and boot, then number; each as JSON.
Promised = Mapping[tuple[str, str], Mapping[int, str]]
_decoder = msgspec.json.Decoder(VehicleEvent)


def acknowledged_by(vehicle: WireVehicle) -> dict[tuple[str, str], dict[int, str]]:
    bodies = vehicle.events[: vehicle.acknowledged]
    known = {number: msgspec.json.encode(body).decode() for number, body in enumerate(bodies)}
    return {(vehicle.vehicle_id, vehicle.boot_id): known}


def not_stored(url: str, promised: Promised) -> list[Violation]:
    """url: of the database, as SQLAlchemy has it"""
    event = tables.vehicle_events.c
    found: list[Violation] = []
    engine = open_engine(url)
    with engine.connect() as connection:
        for (vehicle_id, boot_id), events in promised.items():
            rows = connection.execute(
                select(event.sequence, event.body).where(
                    event.vehicle_id == vehicle_id, event.boot_id == boot_id
                )
            ).all()
            stored = {row.sequence: _as_sent(row.body) for row in rows}
            found += lost_events(0.0, vehicle_id, boot_id, events, stored)
            found += doubled_events(0.0, vehicle_id, boot_id, [row.sequence for row in rows])
    engine.dispose()
    return found


def _as_sent(body: str) -> str:
    return msgspec.json.encode(_decoder.decode(body)).decode()

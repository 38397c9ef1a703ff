"""Reads the database back: is every acknowledged event stored, once, and as it was sent?"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
from sqlalchemy import select

from benchmarks.ingest.city import Place
from benchmarks.ingest.fleet_keys import vehicle_name
from benchmarks.ingest.messages import BOOT, CYCLE, event_body
from contract.wire.messages import VehicleEvent
from server.store import tables
from server.store.engine import open_engine


@dataclass(frozen=True, slots=True)
class Readback:
    """lost: acknowledged and not stored; doubled: stored twice; altered: stored with another content."""

    stored: int
    lost: int
    doubled: int
    altered: int


def read_back(url: str, acknowledged_below: Sequence[int], places: list[Place]) -> Readback:
    """url: of the database, as SQLAlchemy has it; acknowledged_below: by vehicle"""
    lost = doubled = altered = total = 0
    decoder = msgspec.json.Decoder(VehicleEvent)
    stored: defaultdict[str, list[tuple[int, str]]] = defaultdict(list)
    columns = tables.vehicle_events.c
    engine = open_engine(url)
    with engine.connect() as connection:
        chosen = select(columns.vehicle_id, columns.sequence, columns.body).where(columns.boot_id == BOOT)
        for row in connection.execute(chosen):
            stored[row.vehicle_id].append((row.sequence, row.body))
    engine.dispose()
    for vehicle, place in enumerate(places):
        rows = stored[vehicle_name(vehicle)]
        bodies = dict(rows)
        bodies_wanted = [event_body(place, turn) for turn in range(CYCLE)]
        total += len(rows)
        doubled += len(rows) - len(bodies)
        lost += sum(number not in bodies for number in range(acknowledged_below[vehicle]))
        altered += sum(decoder.decode(body) != bodies_wanted[number % CYCLE] for number, body in rows)
    return Readback(total, lost, doubled, altered)

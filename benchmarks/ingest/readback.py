"""Reads the database back: is every acknowledged event stored, once, and as it was sent?"""

import sqlite3
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import msgspec

from benchmarks.ingest.city import Place
from benchmarks.ingest.fleet_keys import vehicle_name
from benchmarks.ingest.ledger import AckLedger
from benchmarks.ingest.messages import BOOT, CYCLE, event_body
from contract.wire.messages import VehicleEvent


@dataclass(frozen=True, slots=True)
class Readback:
    """lost: acknowledged and not stored; doubled: stored twice; altered: stored with another content."""

    stored: int
    lost: int
    doubled: int
    altered: int


def read_back(database: Path, ledger: AckLedger, places: list[Place]) -> Readback:
    lost = doubled = altered = total = 0
    decoder = msgspec.json.Decoder(VehicleEvent)
    stored: defaultdict[str, list[tuple[int, str]]] = defaultdict(list)
    with sqlite3.connect(f"file:{database}?mode=ro", uri=True) as connection:
        for vehicle_id, sequence, body in connection.execute(
            "SELECT vehicle_id, sequence, body FROM vehicle_events WHERE boot_id = ?", (BOOT,)
        ):
            stored[vehicle_id].append((sequence, body))
    for vehicle, place in enumerate(places):
        rows = stored[vehicle_name(vehicle)]
        bodies = dict(rows)
        bodies_wanted = [event_body(place, turn) for turn in range(CYCLE)]
        total += len(rows)
        doubled += len(rows) - len(bodies)
        lost += sum(number not in bodies for number in range(ledger.acknowledged_below[vehicle]))
        altered += sum(decoder.decode(body) != bodies_wanted[number % CYCLE] for number, body in rows)
    return Readback(total, lost, doubled, altered)

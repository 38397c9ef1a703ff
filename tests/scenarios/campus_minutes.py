"""Some minutes of a whole campus: server, two shuttles with lidar, people, two passengers.

Run as a program (`FOLDER SEED SECONDS`) it prints the hashes of the run logs and of what the server kept.
"""

import hashlib
import sys
from pathlib import Path

import msgspec
import sqlalchemy as sa

from campusloop.clients.passengers import Journey, RideDemand
from campusloop.virtual.campus import CampusOptions, VirtualCampus
from contract.roads.load import load_map
from tests.faults.real_campus import nearest_pair
from tests.server.feeds.roads.shipped import CAMPUS_MAP

# What happened and what was decided; keys are made by the vehicles and differ.
KEPT = ("rides", "plans", "orders", "incidents", "vehicle_events", "server_events", "runs", "segments")


def campus_minutes(folder: Path, seed: int, duration_s: float) -> dict[str, str]:
    road_map = load_map(CAMPUS_MAP)
    database = folder / "campus.db"
    campus = VirtualCampus(CampusOptions(road_map, folder, seed, 2, database_url=f"sqlite:///{database}"))
    campus.start()
    passengers = campus.passengers(lambda journey: None)
    from_stop, to_stop = nearest_pair(road_map)
    for number, after_s, stops in ((1, 0.0, (from_stop, to_stop)), (2, 7.0, (to_stop, from_stop))):
        demand = RideDemand(number, after_s, *stops, 1, "code")
        campus.conductor.loop.create_task(passengers.run_journey(Journey(demand)))
    campus.conductor.run_for(duration_s)
    campus.stop()
    hashes = {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("*.mcap")
    }
    engine = sa.create_engine(f"sqlite:///{database}")
    with engine.connect() as connection:
        for table in KEPT:
            rows = connection.execute(sa.text(f"SELECT * FROM {table}")).fetchall()
            assert rows or table in ("incidents", "runs", "segments"), f"nothing in {table}"
            hashes[table] = f"{len(rows)}:{hashlib.sha256(repr(rows).encode()).hexdigest()}"
    return dict(sorted(hashes.items()))


if __name__ == "__main__":
    hashes = campus_minutes(Path(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]))
    print(msgspec.json.encode(hashes).decode())

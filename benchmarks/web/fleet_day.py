"""A day of a fleet as the server stores it: positions twice a second, the events of every shuttle."""

import sqlite3
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from contract.roads.network import RoadNetwork
from contract.wire.codec import encode
from contract.wire.messages import SectionReleased, VisitChanged
from server.domain.instants import ns_of
from server.store.engine import open_engine
from server.store.schema import upgrade_to_head

POSITIONS_HZ = 2
SPEED_MPS = 3.0
# As measured in simulation: a section is released every 14 s, and every sixth time a stop is served.
RELEASED_EVERY_S = 14
STOP_EVERY = 6
_HISTORY = (
    "INSERT INTO history (campus_id, vehicle_id, boot_id, stamp_ns, received_at, x_m, y_m, yaw_rad, speed_mps, "
    "mode, battery_ratio) VALUES (?, ?, 'boot', ?, ?, ?, ?, ?, ?, 'autonomous', 0.8)"
)
_EVENTS = (
    "INSERT INTO vehicle_events (campus_id, number, vehicle_id, boot_id, sequence, stamp_ns, received_ns, body) "
    "VALUES (?, ?, ?, 'boot', ?, 0, ?, ?)"
)


def write_day(database: Path, network: RoadNetwork, vehicles: int, start: datetime, hours: float) -> int:
    """Write it into a new SQLite database; returns how many positions it has.

    The shuttles drive along one lane after another; what they do there plays no part in a replay.
    """
    engine = open_engine(f"sqlite:///{database}")
    upgrade_to_head(engine)
    engine.dispose()
    campus_id = network.road_map.campus_id
    with sqlite3.connect(database) as connection:
        connection.executemany(_HISTORY, _positions(campus_id, network, vehicles, start, hours))
        connection.executemany(_EVENTS, _events(campus_id, network, vehicles, start, hours))
        # The server numbers its own events from here on.
        connection.execute(
            "INSERT INTO counters (campus_id, name, value) "
            "SELECT campus_id, 'vehicle_event', max(number) + 1 FROM vehicle_events GROUP BY campus_id"
        )
        (count,) = connection.execute("SELECT count(*) FROM history").fetchone()
    connection.close()
    return int(count)


def _positions(
    campus_id: str, network: RoadNetwork, vehicles: int, start: datetime, hours: float
) -> Iterator[tuple[object, ...]]:
    xs, ys, yaws = _way(network)
    for step in range(int(hours * 3600 * POSITIONS_HZ)):
        moment = start + timedelta(seconds=step / POSITIONS_HZ)
        at = moment.astimezone(UTC).strftime("%Y-%m-%d %H:%M:%S.%f")
        for number in range(vehicles):
            place = (step + number * len(xs) // vehicles) % len(xs)
            yield campus_id, name_of(number), step, at, xs[place], ys[place], yaws[place], SPEED_MPS


def _way(network: RoadNetwork) -> tuple[list[float], list[float], list[float]]:
    """Poses half a second apart, all lanes one after another."""
    poses = [
        network.pose(lane_id, float(s_m))
        for lane_id in sorted(network.lines)
        for s_m in np.arange(0.0, network.lines[lane_id].length_m, SPEED_MPS / POSITIONS_HZ)
    ]
    x_m, y_m, yaw_rad = (list(column) for column in zip(*poses, strict=True))
    return x_m, y_m, yaw_rad


def _events(
    campus_id: str, network: RoadNetwork, vehicles: int, start: datetime, hours: float
) -> Iterator[tuple[object, ...]]:
    stops = [stop.stop_id for stop in network.road_map.stops]
    section_id = network.road_map.sections[0].section_id
    for sequence in range(int(hours * 3600) // RELEASED_EVERY_S):
        received_ns = ns_of(start + timedelta(seconds=sequence * RELEASED_EVERY_S))
        for number in range(vehicles):
            is_stop = (sequence + number) % STOP_EVERY == 0
            stop_id = stops[(sequence + number) % len(stops)]
            body = (
                VisitChanged("visit", stop_id, "under_way")
                if is_stop
                else SectionReleased(section_id, sequence)
            )
            yield (
                campus_id,
                sequence * vehicles + number,
                name_of(number),
                sequence,
                received_ns,
                encode(body).decode(),
            )


def name_of(number: int) -> str:
    return f"shuttle-{number + 1}"

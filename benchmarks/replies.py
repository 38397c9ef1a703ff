"""Response times of refusals with alternatives, and of replanning the rides of a lost shuttle.

    python -m benchmarks.replies [--vehicles 12] [--rides 150] [--map MAP.json] [--json FILE]

Each figure is one use case in one transaction on SQLite, commit included, as the server runs it. The fleet
is filled with bookings for the next hour until it refuses some; refused bookings are timed separately. Then
one shuttle after the other is lost: its first rides are set to be aboard, and it is taken off the road. The
transaction that replans its rides, those aboard included, is timed.
"""

import argparse
import asyncio
import random
import tempfile
import time
from datetime import timedelta
from pathlib import Path

import numpy as np

from benchmarks.bookings.server import enter_shuttle, shuttle_name
from benchmarks.reporting.report import RunReport
from campusloop.live.server import answer_promptly
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from contract.wire.messages import RiderBoarded
from server.domain.instants import ns_of
from server.domain.record.events import RecordedEvent
from server.domain.rides.rides import BookRide, Ride, RideState
from server.live_ports import live_ports
from server.settings import settings_from
from server.usecases.fleet import events, vehicles
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.rides import rides

_MAP = Path(__file__).resolve().parent.parent / "maps" / "shanghai-university" / "map.json"
_REFUSALS = 200
_LOST = 6
_BOOT = "boot-1"


def main() -> None:
    report = RunReport()
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--vehicles", type=int, default=12)
    parser.add_argument("--rides", type=int, default=150, help="accepted before anything is timed")
    parser.add_argument("--map", type=Path, default=_MAP)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="campusloop-replies-") as var:
        rows = asyncio.run(_measured(args.map, Path(var), args.vehicles, args.rides, args.seed))
    arguments = {name: str(value) for name, value in vars(args).items() if name != "json"}
    summary = {f"{row['what']}_p99_ms".replace(" ", "_"): row["p99_ms"] for row in rows}
    report.write(args.json, "replies", arguments, rows, summary)


async def _measured(
    map_path: Path, var: Path, fleet: int, wanted: int, seed: int
) -> list[dict[str, float | int | str]]:
    environment = {
        "CAMPUSLOOP_VAR_DIR": str(var),
        "CAMPUSLOOP_MAP_PATH": str(map_path),
        "CAMPUSLOOP_OPERATOR_PASSWORD": "replies-are-measured",
    }
    live = await live_ports(settings_from(environment, host="127.0.0.1", port=0))
    transactions, road_map = live.ports.transactions, load_map(map_path)
    network = RoadNetwork(road_map)
    for number in range(fleet):
        await enter_shuttle(transactions, road_map, network, number)
    answer_promptly()
    rng, stops = random.Random(seed), [stop.stop_id for stop in road_map.stops]
    taken: list[Ride] = []
    refused_ms: list[float] = []
    while len(taken) < wanted or len(refused_ms) < _REFUSALS:
        begins = time.perf_counter()
        ride = await transactions.run(lambda uow: rides.book(uow, _ride_request(uow, rng, stops)))
        if ride.state is RideState.ASSIGNED:
            taken.append(ride)
        else:
            refused_ms.append(1e3 * (time.perf_counter() - begins))
        if len(refused_ms) >= 10 * _REFUSALS:
            break
    lost_ms, moved = await _lost(transactions, fleet)
    await live.ports.close()
    return [
        _row("refusal", refused_ms, len(taken)),
        _row("lost vehicle", lost_ms, moved),
    ]


async def _lost(transactions: Transactions, fleet: int) -> tuple[list[float], int]:
    """Milliseconds for each lost vehicle, and how many rides they had in all."""
    times_ms, moved = [], 0
    for number in range(min(_LOST, fleet - 1)):
        vehicle_id = shuttle_name(number)
        mine = await transactions.read(
            lambda uow, v=vehicle_id: uow.rides.of_vehicle(v, [RideState.ASSIGNED])  # type: ignore[misc]
        )
        aboard = [ride for ride in mine if ride.party <= 2][:2]
        for sequence, ride in enumerate(aboard, start=1):
            await transactions.run(
                lambda uow, v=vehicle_id, n=sequence, r=ride: _board(uow, v, n, r.ride_id)  # type: ignore[misc]
            )
        begins = time.perf_counter()
        await transactions.run(lambda uow, v=vehicle_id: vehicles.retire(uow, v, "benchmark"))  # type: ignore[misc]
        times_ms.append(1e3 * (time.perf_counter() - begins))
        moved += len(mine)
    return times_ms, moved


def _board(uow: UnitOfWork, vehicle_id: str, sequence: int, ride_id: str) -> None:
    now = ns_of(uow.now)
    boarded = RiderBoarded(ride_id, "sensor")
    events.apply_event(uow, RecordedEvent(vehicle_id, _BOOT, sequence, now, now, boarded))


def _ride_request(uow: UnitOfWork, rng: random.Random, stops: list[str]) -> BookRide:
    from_stop, to_stop = rng.sample(stops, 2)
    earliest = uow.now + timedelta(seconds=rng.uniform(0.0, 3600.0))
    return BookRide(from_stop, to_stop, rng.randint(1, 3), earliest=earliest)


def _row(what: str, times_ms: list[float], rides_moved: int) -> dict[str, float | int | str]:
    return {
        "what": what,
        "count": len(times_ms),
        "rides": rides_moved,
        "p50_ms": round(float(np.percentile(times_ms, 50)), 2),
        "p99_ms": round(float(np.percentile(times_ms, 99)), 2),
    }


if __name__ == "__main__":
    main()

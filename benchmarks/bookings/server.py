"""The server of `benchmarks.bookings`: shuttles that stand at their resting places and report it.

    python -m benchmarks.bookings.server MAP.json VAR_DIR VEHICLES

Prints its port when it is ready. CAMPUSLOOP_DATABASE_URL names a database other than a new SQLite file, and
CAMPUSLOOP_BUS_URL the bus of several servers. The shuttles speak through the use cases that the link calls.
"""

import asyncio
import os
import sys
from pathlib import Path

import uvicorn
import uvloop

from campusloop.live.server import answer_promptly, listen, uvicorn_config
from contract.geometry import Pose2
from contract.roads.load import load_map
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from contract.wire.messages import EventLogState, ModeChanged, Status
from server.domain.fleet.vehicles import StatusReport
from server.domain.instants import ns_of
from server.domain.record.events import RecordedEvent
from server.live_ports import live_ports
from server.settings import settings_from
from server.usecases.fleet import events, vehicle_sessions
from server.usecases.fleet.vehicle_sessions import HelloFacts
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.record import identity

_REPORT_S = 1.0
_BOOT = "boot-1"


async def _serve(map_path: Path, var: Path, vehicles: int) -> None:
    environment = {
        "CAMPUSLOOP_VAR_DIR": str(var),
        "CAMPUSLOOP_MAP_PATH": str(map_path),
        "CAMPUSLOOP_DATABASE_URL": os.environ.get("CAMPUSLOOP_DATABASE_URL", ""),
        "CAMPUSLOOP_TICKET_KEY_FILE": os.environ.get("CAMPUSLOOP_TICKET_KEY_FILE", str(var / "ticket.key")),
        "CAMPUSLOOP_BUS_URL": os.environ.get("CAMPUSLOOP_BUS_URL", ""),
        "CAMPUSLOOP_BOOKINGS_PER_MINUTE": "1000000",
        "CAMPUSLOOP_OPERATOR_PASSWORD": "bookings-are-measured",
    }
    listening = listen("127.0.0.1", 0)
    settings = settings_from(environment, host="127.0.0.1", port=listening.getsockname()[1])
    live = await live_ports(settings)
    transactions = live.ports.transactions
    road_map = load_map(map_path)
    network = RoadNetwork(road_map)
    if vehicles > len(road_map.resting_places):
        sys.exit(f"the map has resting places for {len(road_map.resting_places)} shuttles only")
    for number in range(vehicles):
        await enter_shuttle(transactions, road_map, network, number)
    reporting = asyncio.create_task(_report(transactions, road_map, network, vehicles))
    print(settings.port, flush=True)
    server = uvicorn.Server(uvicorn_config(settings, live))
    answer_promptly()
    await server.serve(sockets=[listening])
    reporting.cancel()


async def enter_shuttle(
    transactions: Transactions, road_map: RoadMap, network: RoadNetwork, number: int
) -> None:
    """Enrol a shuttle, say hello, report where it stands, and be in service."""
    vehicle_id = shuttle_name(number)

    def work(uow: UnitOfWork) -> None:
        identity.create_enrolment_code(uow, vehicle_id, vehicle_id, "benchmark", seats=6, wheelchair_places=1)
        hello = HelloFacts(
            vehicle_id,
            _BOOT,
            "benchmark",
            "none",
            road_map.map_version,
            (EventLogState(_BOOT, 0, 0),),
            None,
            6,
            1,
        )
        vehicle_sessions.open_session(uow, hello)
        vehicle_sessions.record_status(uow, [_status(uow, road_map, network, number)])
        now = ns_of(uow.now)
        said = ModeChanged("autonomous", detail="resumed")
        events.apply_event(uow, RecordedEvent(vehicle_id, _BOOT, 0, now, now, said))

    await transactions.run(work)


async def _report(transactions: Transactions, road_map: RoadMap, network: RoadNetwork, vehicles: int) -> None:
    while True:
        await asyncio.sleep(_REPORT_S)
        await transactions.run(
            lambda uow: vehicle_sessions.record_status(
                uow, [_status(uow, road_map, network, number) for number in range(vehicles)]
            )
        )


def _status(uow: UnitOfWork, road_map: RoadMap, network: RoadNetwork, number: int) -> StatusReport:
    place = road_map.resting_places[number]
    x_m, y_m, yaw_rad = network.pose(place.lane_id, place.s_m)
    status = Status(
        epoch=1,
        stamp_ns=ns_of(uow.now),
        pose_map=Pose2(x_m, y_m, yaw_rad),
        speed_mps=0.0,
        accel_mps2=0.0,
        steer_rad=0.0,
        mode="autonomous",
        battery_ratio=1.0,
        doors_open=False,
        lane_id=place.lane_id,
        s_m=place.s_m,
        order_id="",
        revision=0,
        visit_id="",
    )
    return StatusReport(shuttle_name(number), _BOOT, uow.now, status)


def shuttle_name(number: int) -> str:
    return f"shuttle-{number + 1}"


if __name__ == "__main__":
    with asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner:
        runner.run(_serve(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])))

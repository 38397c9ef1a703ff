"""A vehicle's link process that is killed: the agent's own outbox, session and websocket, without a drive.

    python -m benchmarks.faults.agent FOLDER SERVER_URL VEHICLE BOOT MAP.json RESTING_PLACE

It stands at a resting place, reports its status and an event ten times a second, and accepts orders. Each
event is noted in FOLDER/durable.jsonl, and on the output, after the outbox has it on disk and before it is
sent.
"""

import asyncio
import sys
import time
from pathlib import Path

import msgspec

from contract.geometry import Pose2
from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from contract.wire.messages import (
    DoorsChanged,
    ModeChanged,
    Order,
    OrderAccepted,
    Status,
    VehicleEvent,
)
from vehicle_agent.link.bridge import LinkBridge, TickUpdate
from vehicle_agent.link.client import LinkClient
from vehicle_agent.link.keys import load_or_create_key, signature_text
from vehicle_agent.link.session import Identity
from vehicle_agent.signals import LinkMessage

_EVENT_EVERY_S = 0.1


class DurableEvent(msgspec.Struct, frozen=True):
    """An event that the vehicle has on its disk. body: as JSON"""

    boot_id: str
    sequence: int
    body: str


class _Agent:
    def __init__(
        self, folder: Path, url: str, identity: Identity, network: RoadNetwork, resting_place: int
    ) -> None:
        key = load_or_create_key(folder / "key.pem")
        self._boot_id = identity.boot_id
        self._bridge = LinkBridge(folder, identity, lambda text: signature_text(key, text))
        self._client = LinkClient(f"{url}/ws/vehicle", self._bridge, self._take, time.monotonic_ns)
        self._durable = (folder / "durable.jsonl").open("ab", buffering=0)
        place = network.road_map.resting_places[resting_place]
        self._lane_id, self._s_m = place.lane_id, place.s_m
        self._pose = Pose2(*network.pose(place.lane_id, place.s_m))
        self._answers: list[OrderAccepted] = []
        self._order = ("", 0)
        self._sequence = 0

    async def run(self) -> None:
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self._client.run())
            tasks.create_task(self._report())

    async def _report(self) -> None:
        while True:
            self._step()
            await asyncio.sleep(_EVENT_EVERY_S)

    def _step(self) -> None:
        event = self._next_event()
        answers, self._answers = tuple(self._answers), []
        now_ns = time.monotonic_ns()
        memory = msgspec.json.encode(self._order) if answers else None
        update = TickUpdate(now_ns, self._status(now_ns), (event,), answers, memory)
        lines = self._bridge.number_events(update)
        self._bridge.write(update, lines)
        body = msgspec.json.encode(event).decode()
        noted = DurableEvent(self._boot_id, self._sequence, body)
        self._durable.write(msgspec.json.encode(noted) + b"\n")
        print("durable", self._sequence, flush=True)
        self._sequence += 1
        self._bridge.send(update, now_ns)
        self._client.wake()

    def _next_event(self) -> VehicleEvent:
        """First that it drives by itself again, as after an operator's word; then its doors."""
        if self._sequence == 0:
            return ModeChanged("autonomous", detail="resumed")
        return DoorsChanged(self._sequence % 2 == 1, f"visit-{self._sequence}")

    def _take(self, message: LinkMessage) -> None:
        if isinstance(message, Order):
            self._order = (message.order_id, message.revision)
            self._answers.append(OrderAccepted(0, message.order_id, message.revision))

    def _status(self, now_ns: int) -> Status:
        order_id, revision = self._order
        return Status(
            0,
            now_ns,
            self._pose,
            0.0,
            0.0,
            0.0,
            "autonomous",
            0.9,
            False,
            self._lane_id,
            self._s_m,
            order_id,
            revision,
            "",
        )


def main() -> None:
    folder, url, vehicle_id, boot_id, campus_map, resting_place = sys.argv[1:]
    network = RoadNetwork(load_map(Path(campus_map)))
    identity = Identity(vehicle_id, boot_id, "kills", "none", network.map_version, 6, 1)
    asyncio.run(_Agent(Path(folder), url, identity, network, int(resting_place)).run())


if __name__ == "__main__":
    main()

"""The newest detailed scene of each vehicle that an operator has asked for it."""

from datetime import datetime
from typing import Literal, NamedTuple

import msgspec

from contract.wire.codec import decode_from_vehicle
from contract.wire.messages import OnboardScene
from server.domain.fleet.vehicles import CommandState
from server.supervision.standing_tasks import TopicReader
from server.usecases.ports import topics
from server.usecases.ports.bus import Bus
from server.usecases.ports.clock_and_ids import Clock


class ShownScene(msgspec.Struct, frozen=True):
    """What a vehicle shows, and how old that is by the server's clock.

    request  how the newest request of the last minute stands; "" without one
    detail   the reason for a refusal
    scene    the newest, None before the first; it came at received_ms
    """

    vehicle_id: str
    connected: bool
    now_ms: int
    request: CommandState | Literal[""] = ""
    detail: str = ""
    received_ms: int = 0
    scene: OnboardScene | None = None


class ReceivedScene(NamedTuple):
    received_at: datetime
    scene: OnboardScene


class OnboardScenes:
    """Each replica has all of them: they come by the bus. They are not stored."""

    def __init__(self, campus_id: str, clock: Clock, bus: Bus) -> None:
        self._clock = clock
        self._newest: dict[str, ReceivedScene] = {}
        topic = topics.vehicle_scene(campus_id, "*")
        self.reader = TopicReader("onboard.scenes", bus, topic, self._take)

    def newest(self, vehicle_id: str) -> ReceivedScene | None:
        """However old it is."""
        return self._newest.get(vehicle_id)

    def _take(self, topic: str, payload: bytes) -> None:
        scene = decode_from_vehicle(payload)
        assert isinstance(scene, OnboardScene), f"{topic} carries a {type(scene).__name__}"
        self._newest[topic.split("/")[3]] = ReceivedScene(self._clock.now(), scene)

"""The newest picture of each camera that an operator has asked for."""

from datetime import datetime, timedelta
from typing import Literal, NamedTuple

import msgspec

from contract.wire.codec import decode_from_vehicle
from contract.wire.messages import CameraPicture
from server.domain.fleet.vehicles import CommandState
from server.supervision.standing_tasks import TopicReader
from server.usecases.ports import topics
from server.usecases.ports.bus import Bus
from server.usecases.ports.clock_and_ids import Clock


class ShownCamera(msgspec.Struct, frozen=True):
    """What a camera of a vehicle shows, and how old that is by the server's clock.

    request  how the newest request of the last minute stands; "" without one: then there is no picture either
    detail   the reason for a refusal
    picture  the newest, None before the first; it came at received_ms
    """

    vehicle_id: str
    connected: bool
    now_ms: int
    request: CommandState | Literal[""] = ""
    detail: str = ""
    received_ms: int = 0
    picture: CameraPicture | None = None


# As long as a request stands: pictures of people are not kept for longer.
KEPT = timedelta(seconds=60)


class ReceivedPicture(NamedTuple):
    received_at: datetime
    picture: CameraPicture


class CameraPictures:
    """Each replica has all of them: they come by the bus. They are not stored."""

    def __init__(self, campus_id: str, clock: Clock, bus: Bus) -> None:
        self._clock = clock
        self._newest: dict[str, dict[str, ReceivedPicture]] = {}
        topic = topics.vehicle_camera(campus_id, "*")
        self.reader = TopicReader("camera.pictures", bus, topic, self._take)

    def newest(self, vehicle_id: str, camera: str) -> ReceivedPicture | None:
        """However old it is. camera: "" for whichever came last."""
        of_vehicle = self._newest.get(vehicle_id, {})
        if camera:
            return of_vehicle.get(camera)
        return max(of_vehicle.values(), key=lambda one: one.received_at, default=None)

    def _take(self, topic: str, payload: bytes) -> None:
        picture = decode_from_vehicle(payload)
        assert isinstance(picture, CameraPicture), f"{topic} carries a {type(picture).__name__}"
        now = self._clock.now()
        self._drop_before(now - KEPT)
        of_vehicle = self._newest.setdefault(topic.split("/")[3], {})
        of_vehicle[picture.camera] = ReceivedPicture(now, picture)

    def _drop_before(self, oldest: datetime) -> None:
        for vehicle_id, pictures in tuple(self._newest.items()):
            kept = {camera: one for camera, one in pictures.items() if one.received_at >= oldest}
            if kept:
                self._newest[vehicle_id] = kept
            else:
                del self._newest[vehicle_id]

"""Passes reports of infrastructure cameras on to the vehicles near their area, and to screens."""

import msgspec

from contract.roads.areas import outline_array
from contract.wire.messages import PresenceReport
from server.domain.errors import AreaUnknown
from server.domain.instants import ns_of
from server.usecases.ports import topics
from server.usecases.ports.bus import Bus
from server.usecases.ports.clock_and_ids import Clock
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork

# Reports of one area that come faster are dropped.
SOONEST_NS = 80_000_000


class AreaPresence(msgspec.Struct, frozen=True):
    """x_m, y_m: the middle of the area, map frame; stamp_ns: when it was seen, server time."""

    area_id: str
    count: int
    x_m: float
    y_m: float
    stamp_ns: int


class PresenceRelay:
    """Takes the cameras' reports. The latest one counts: none is stored or repeated."""

    def __init__(self, campus_id: str, clock: Clock, transactions: Transactions, bus: Bus) -> None:
        self._campus_id, self._clock = campus_id, clock
        self._transactions, self._bus = transactions, bus
        self._told_ns: dict[str, int] = {}

    async def seen(self, report: PresenceReport) -> None:
        """Raises AreaUnknown for an area that the active map does not have."""
        now_ns = ns_of(self._clock.now())
        if now_ns - self._told_ns.get(report.area_id, 0) < SOONEST_NS:
            return
        x_m, y_m = await self._transactions.read(lambda uow: _middle(uow, report.area_id))
        self._told_ns[report.area_id] = now_ns
        seen_ns = now_ns - round(report.age_s * 1e9)
        payload = msgspec.json.encode(AreaPresence(report.area_id, report.count, x_m, y_m, seen_ns))
        await self._bus.publish(topics.area_presence(self._campus_id, report.area_id), payload)


def _middle(uow: UnitOfWork, area_id: str) -> tuple[float, float]:
    for area in uow.network().road_map.observation_areas:
        if area.area_id == area_id:
            x_m, y_m = outline_array(area).mean(axis=0)
            return float(x_m), float(y_m)
    raise AreaUnknown(f"the active map has no observation area {area_id}")

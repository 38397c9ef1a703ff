"""The inbox: everything that is not deterministic, until the next tick."""

from collections.abc import Sequence

from contract.wire.messages import Command, Grants, Order, PassengerTap
from vehicle_agent.runtime.code_mask import CodeMask
from vehicle_agent.signals import (
    CanFrame,
    CodeTyped,
    DoorState,
    FleetVehicle,
    GnssFix,
    ImuSample,
    InboxBody,
    InboxItem,
    Inputs,
    LinkState,
    ObstaclePercept,
    PedestrianPresence,
    PlanAnswer,
    SeatButton,
    SeatSensor,
    TrackPercept,
)


class Inbox:
    """Collects items of all sources; each source has its own sequence.

    The bound is common to all sources. When it is reached, new items are dropped and counted, so that a
    broken device cannot fill the memory.

    mask  masks boarding codes; None for a vehicle that is given none
    """

    def __init__(self, items_max: int = 2000, mask: CodeMask | None = None) -> None:
        self.dropped = 0
        self._mask = mask
        self._items: list[InboxItem] = []
        self._items_max = items_max
        self._next: dict[str, int] = {}

    def put(self, arrival_ns: int, source: str, body: InboxBody) -> None:
        if len(self._items) >= self._items_max:
            self.dropped += 1
            return
        sequence = self._next.get(source, 0)
        self._next[source] = sequence + 1
        if self._mask is not None:
            body = self._mask.masked(body)
        self._items.append(InboxItem(arrival_ns, source, sequence, body))

    def drain(self) -> tuple[InboxItem, ...]:
        """All items in (arrival, source, sequence) order; the inbox is empty afterwards."""
        items = tuple(sorted(self._items, key=lambda item: (item.arrival_ns, item.source, item.sequence)))
        self._items.clear()
        return items


def inputs_from(items: Sequence[InboxItem], stamp_ns: int) -> Inputs:
    """One tick's inputs: the drained items split by kind, each kind in drained order."""
    bodies = [item.body for item in items]
    links = [body for body in bodies if isinstance(body, LinkState)]
    return Inputs(
        stamp_ns=stamp_ns,
        frames=tuple(body for body in bodies if isinstance(body, CanFrame)),
        navigation=tuple(body for body in bodies if isinstance(body, GnssFix | ImuSample)),
        percepts=tuple(body for body in bodies if isinstance(body, ObstaclePercept | TrackPercept)),
        plans=tuple(body for body in bodies if isinstance(body, PlanAnswer)),
        infrastructure=tuple(body for body in bodies if isinstance(body, FleetVehicle | PedestrianPresence)),
        messages=tuple(body for body in bodies if isinstance(body, Order | Grants | Command | PassengerTap)),
        cabin_events=tuple(
            body for body in bodies if isinstance(body, SeatButton | CodeTyped | SeatSensor | DoorState)
        ),
        link=links[-1] if links else None,
    )

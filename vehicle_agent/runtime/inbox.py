"""The inbox: everything that is not deterministic, until the next tick."""

from collections import Counter, deque
from collections.abc import Sequence

from contract.wire.messages import Command, Grants, Order, PassengerTap
from vehicle_agent.runtime.code_mask import CodeMask
from vehicle_agent.signals import (
    CanFrame,
    CodeTyped,
    DestinationChoice,
    DoorState,
    FleetVehicle,
    HelpButton,
    InboxBody,
    InboxItem,
    Inputs,
    LidarConditions,
    LinkState,
    Navigation,
    ObstaclePercept,
    PedestrianPresence,
    PlanAnswer,
    PoseHint,
    SeatButton,
    SeatSensor,
    SignPercept,
    TrackPercept,
)

# A second without a tick: the module sends about 500 frames, the inertial sensor and the receiver 300 values.
SHARE_MAX = 1000
SHARES = 32
# Under this name items are counted whose source has no share.
UNKNOWN_SOURCE = "unknown"


class Inbox:
    """Collects items of all sources; each source has its own sequence and its own share.

    A source that has filled its share loses its oldest items, and no other source loses any: a broken device
    neither fills the memory nor displaces the others. Sources beyond the number of shares are refused.

    share_max, shares  items of one source between two ticks, number of sources
    mask               masks boarding codes; None for a vehicle that is given none
    dropped            lost items by source, since the start
    """

    def __init__(
        self, share_max: int = SHARE_MAX, shares: int = SHARES, mask: CodeMask | None = None
    ) -> None:
        self.dropped: Counter[str] = Counter()
        self._mask = mask
        self._share_max, self._shares = share_max, shares
        self._items: dict[str, deque[InboxItem]] = {}
        self._next: dict[str, int] = {}

    def put(self, arrival_ns: int, source: str, body: InboxBody) -> None:
        items = self._items.get(source)
        if items is None:
            if len(self._items) >= self._shares:
                self.dropped[UNKNOWN_SOURCE] += 1
                return
            items = self._items[source] = deque(maxlen=self._share_max)
        if len(items) == self._share_max:
            self.dropped[source] += 1
        sequence = self._next.get(source, 0)
        self._next[source] = sequence + 1
        if self._mask is not None:
            body = self._mask.masked(body)
        items.append(InboxItem(arrival_ns, source, sequence, body))

    def drain(self) -> tuple[InboxItem, ...]:
        """All items in (arrival, source, sequence) order; the inbox is empty afterwards."""
        items = [item for share in self._items.values() for item in share]
        for share in self._items.values():
            share.clear()
        return tuple(sorted(items, key=lambda item: (item.arrival_ns, item.source, item.sequence)))


def inputs_from(items: Sequence[InboxItem], stamp_ns: int) -> Inputs:
    """One tick's inputs: the drained items split by kind, each kind in drained order."""
    bodies = [item.body for item in items]
    links = [body for body in bodies if isinstance(body, LinkState)]
    return Inputs(
        stamp_ns=stamp_ns,
        frames=tuple(body for body in bodies if isinstance(body, CanFrame)),
        navigation=tuple(body for body in map(_told_to_localization, bodies) if isinstance(body, Navigation)),
        percepts=tuple(
            body
            for body in bodies
            if isinstance(body, ObstaclePercept | TrackPercept | SignPercept | LidarConditions)
        ),
        plans=tuple(body for body in bodies if isinstance(body, PlanAnswer)),
        infrastructure=tuple(body for body in bodies if isinstance(body, FleetVehicle | PedestrianPresence)),
        messages=tuple(body for body in bodies if isinstance(body, Order | Grants | Command | PassengerTap)),
        cabin_events=tuple(
            body
            for body in bodies
            if isinstance(
                body, SeatButton | HelpButton | CodeTyped | DestinationChoice | SeatSensor | DoorState
            )
        ),
        link=links[-1] if links else None,
    )


def _told_to_localization(body: InboxBody) -> InboxBody | PoseHint:
    """A command that names the vehicle's place is a hint for localization; the mission answers it."""
    if isinstance(body, Command) and body.kind == "set_position" and body.pose_map is not None:
        return PoseHint(body.command_id, body.pose_map)
    return body

"""What was stored of a stretch of time: positions, events, incidents, rides, runs. Only for reading."""

from collections.abc import Sequence
from datetime import datetime
from typing import NamedTuple, Protocol

from server.domain.record.events import RecordedEvent, ServerEvent
from server.domain.record.incidents import Incident
from server.domain.record.runs import Run
from server.domain.rides.rides import Ride


class PastPosition(NamedTuple):
    """Where a vehicle was, in the map frame; `at` is the server's clock.

    A named tuple, since tens of thousands are made for one answer.
    """

    vehicle_id: str
    at: datetime
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    mode: str
    battery_ratio: float


class SpeedCount(NamedTuple):
    """Positions at [from_kmh, from_kmh + 1), and the sum of their speeds."""

    from_kmh: int
    positions: int
    speeds_mps: float


class Past(Protocol):
    """All of one campus and of [since, until), oldest first, at most `limit`."""

    def positions(self, since: datetime, until: datetime, limit: int) -> tuple[PastPosition, ...]: ...

    def vehicle_events(
        self, since: datetime, until: datetime, kinds: Sequence[str], limit: int
    ) -> tuple[RecordedEvent, ...]:
        """kinds: their tags on the wire. Those that another version wrote differently are left out."""
        ...

    def server_events(
        self, since: datetime, until: datetime, names: Sequence[str], limit: int
    ) -> tuple[ServerEvent, ...]: ...

    def incidents(self, since: datetime, until: datetime, limit: int) -> tuple[Incident, ...]:
        """Those that were opened then."""
        ...

    def rides(self, since: datetime, until: datetime, limit: int) -> tuple[Ride, ...]:
        """Those with a vehicle that were requested before the end and not over at the beginning."""
        ...

    def wanted_rides(self, since: datetime, until: datetime, limit: int) -> tuple[Ride, ...]:
        """Those that were wanted for a time from `since` on, refused ones too."""
        ...

    def speeds(self, since: datetime, until: datetime) -> tuple[SpeedCount, ...]:
        """All stored positions, counted by whole km/h."""
        ...

    def runs(self, since: datetime, until: datetime, limit: int) -> tuple[Run, ...]:
        """Those that have begun before the end, and of which something was recorded after the beginning."""
        ...

"""What a simulated vehicle needs from outside, and what it is made of."""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from contract.wire.messages import OrderAccepted, RiderTask, VehicleEvent
from vehicle_agent.link.session import Sign
from vehicle_agent.mission.memory import MissionMemory
from vehicle_agent.mission.mission import Mission


class Cabin(Protocol):
    """The people at a vehicle's doors."""

    def codes(
        self, vehicle_id: str, boarding: tuple[RiderTask, ...], alighting: tuple[RiderTask, ...]
    ) -> tuple[str, ...]:
        """The codes that are typed now."""
        ...


class Observer(Protocol):
    """What the history learns of a vehicle, in the order in which it is true."""

    def booted(self, vehicle_id: str, boot_id: str, memory: MissionMemory) -> None: ...

    def accepted(self, vehicle_id: str, answer: OrderAccepted, memory: MissionMemory) -> None: ...

    def happened(self, vehicle_id: str, events: tuple[VehicleEvent, ...]) -> None: ...

    def on_disk(
        self, vehicle_id: str, boot_id: str, first: int, events: tuple[VehicleEvent, ...]
    ) -> None: ...

    def stands(self, vehicle_id: str, memory: MissionMemory) -> None: ...


@dataclass(frozen=True, slots=True)
class VehicleSetup:
    """syncs_disk: events reach the disk itself before they are sent; a simulated disk needs no such wait."""

    vehicle_id: str
    folder: Path
    mission: Mission
    seats: int
    wheelchair_places: int
    sign: Sign
    syncs_disk: bool = False

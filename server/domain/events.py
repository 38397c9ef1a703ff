"""What has happened on a vehicle, as the server keeps it: named for ever by (vehicle, boot, sequence)."""

from dataclasses import dataclass

from contract.wire.messages import VehicleEvent


@dataclass(frozen=True, slots=True)
class RecordedEvent:
    """stamp_ns is the vehicle's clock, received_ns the server's (UTC); both are kept."""

    vehicle_id: str
    boot_id: str
    sequence: int
    stamp_ns: int
    received_ns: int
    body: VehicleEvent

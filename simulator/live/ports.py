"""The loopback ports of a real-time simulation, relative to a base port."""

from dataclasses import dataclass

from simulator.live.bus import channel_of

BASE_PORT = 47_100
VEHICLES_MAX = 100


@dataclass(frozen=True, slots=True)
class VehiclePorts:
    """The channels between one vehicle's computer and the simulation.

    can_channel  its CAN bus, as the gate opens it
    values_port  of its tick process, for device values
    scans_port   of its perception worker, for finished scans
    hmi_port     of the simulation, for the vehicle's output to screen, speaker and doors
    screen_port  of the vehicle's screen for passengers (TCP)
    """

    can_channel: str
    values_port: int
    scans_port: int
    hmi_port: int
    screen_port: int


def control_port(base_port: int = BASE_PORT) -> int:
    """The simulation's own port (`simulator.control`)."""
    return base_port


def ports_of(number: int, base_port: int = BASE_PORT) -> VehiclePorts:
    """The ports of the number-th vehicle, from 0. ValueError from VEHICLES_MAX on."""
    if not 0 <= number < VEHICLES_MAX:
        raise ValueError(f"vehicle {number}: one simulation has ports for {VEHICLES_MAX} vehicles")
    return VehiclePorts(
        channel_of(number, base_port + VEHICLES_MAX),
        base_port + 2 * VEHICLES_MAX + number,
        base_port + 3 * VEHICLES_MAX + number,
        base_port + 4 * VEHICLES_MAX + number,
        base_port + 5 * VEHICLES_MAX + number,
    )

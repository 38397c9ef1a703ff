"""The lowest of all speed commands wins (GEM, section II), and names its source."""

from collections.abc import Iterable

import msgspec

from contract.wire.reasons import SpeedLimitReason


class SpeedCommand(msgspec.Struct, frozen=True):
    """One voice: go no faster than this. accel_mps2 is the command's own slope as the vehicle moves on it."""

    name: SpeedLimitReason
    speed_mps: float
    accel_mps2: float = 0.0
    emergency: bool = False


def lowest(commands: Iterable[SpeedCommand]) -> SpeedCommand:
    """The slowest command; of equals an emergency first, then the one that falls fastest, then by order."""
    ranked = enumerate(commands)
    return min(ranked, key=lambda c: (c[1].speed_mps, not c[1].emergency, c[1].accel_mps2, c[0]))[1]

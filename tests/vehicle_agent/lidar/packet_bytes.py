"""Packets as sensors send them, of a room whose walls' distances are known in every direction."""

import math
import struct
from collections.abc import Callable
from datetime import UTC, datetime

from vehicle_agent.lidar.models import PANDAR40P, PANDAR64, LidarModel

# metres along a ray of (azimuth_rad, elevation_rad), both with the beam's own correction
Ranges = Callable[[float, float], float]
_PRODUCTS = {"HDL-32E": 0x21, "VLP-16": 0x22, "Puck Hi-Res": 0x24, "VLP-32C": 0x28}
NOON = datetime(2026, 5, 4, 12, tzinfo=UTC)


def velodyne_packets(
    model: LidarModel,
    count: int,
    ranges: Ranges,
    begin_cdeg: float = 0.0,
    dual: bool = False,
    begin_us: int = 0,
) -> list[tuple[int, bytes]]:
    """(arrival ns, bytes) of `count` packets at 10 turns a second. dual: both returns are the same."""
    packets = []
    cdeg_per_ns = 36_000 / 1e8
    time_ns = 1e3 * begin_us
    begun_ns = time_ns
    sequences = 2 if model.channels == 16 else 1
    for _ in range(count):
        data = b""
        sent_ns = time_ns
        for _ in range(6 if dual else 12):
            azimuth = begin_cdeg + (time_ns - begun_ns) * cdeg_per_ns
            block = b"\xff\xee" + struct.pack("<H", round(azimuth) % 36_000)
            for sequence in range(sequences):
                for unit in range(model.channels):
                    fired = azimuth + cdeg_per_ns * (sequence * model.sequence_ns + model.firing_ns[unit])
                    block += _unit(model, math.radians(fired / 100.0), unit, ranges, 3)
            time_ns += sequences * model.sequence_ns
            data += block * (2 if dual else 1)
        data += struct.pack(
            "<IBB", round(sent_ns / 1e3) % 3_600_000_000, 0x39 if dual else 0x37, _PRODUCTS[model.name]
        )
        packets.append((round(sent_ns), data))
    return packets


def hesai_packets(
    model: LidarModel, count: int, ranges: Ranges, begin_cdeg: int = 0, dual: bool = False
) -> list[tuple[int, bytes]]:
    """(arrival ns, bytes) of `count` packets at 10 turns a second, from NOON on."""
    is_xt = model.name.startswith("XT")
    blocks = {PANDAR40P.name: 10, PANDAR64.name: 6}.get(model.name, 8)
    step_cdeg = round(model.sequence_ns * 36_000 / 1e8)
    packets, azimuth, time_us = [], begin_cdeg, 0.0
    for number in range(count):
        data = b""
        if is_xt:
            data = struct.pack("<2sBBHBBBBBB", b"\xee\xff", 6, 1, 0, model.channels, 8, 1, 4, 2, 1)
        if model is PANDAR64:
            data = struct.pack("<2sBBBBBB", b"\xee\xff", 64, 6, 0, 4, 2, 0)
        for _ in range(blocks // (2 if dual else 1)):
            block = (b"\xff\xee" if model is PANDAR40P else b"") + struct.pack("<H", azimuth % 36_000)
            for unit in range(model.channels):
                block += _unit(model, math.radians(azimuth / 100.0), unit, ranges, 4 if is_xt else 3)
            data += block * (2 if dual else 1)
            azimuth += step_cdeg
            time_us += model.sequence_ns / 1e3
        mode = 0x39 if dual else 0x37
        date = bytes((NOON.year - (1900 if is_xt else 2000), NOON.month, NOON.day, NOON.hour, 0, 0))
        if is_xt:
            data += struct.pack("<10xBH6sIBI", mode, 600, date, round(time_us), 0x42, number)
        else:
            data += struct.pack("<5xB2xHIBB6s", 0, 600, round(time_us), mode, 0x42, date)
        packets.append((round(1e3 * time_us), data))
    return packets


def _unit(model: LidarModel, azimuth_rad: float, unit: int, ranges: Ranges, size: int) -> bytes:
    azimuth_rad += model.azimuths_rad[unit]
    reach = ranges(azimuth_rad, float(model.elevations_rad[unit]))
    return struct.pack("<HB", round(reach / model.distance_m), 10 + unit % 16) + bytes(size - 3)


def square_room(half_m: float) -> Ranges:
    """Four upright walls half_m from the sensor."""

    def reach_m(azimuth_rad: float, elevation_rad: float) -> float:
        level = half_m / max(abs(math.cos(azimuth_rad)), abs(math.sin(azimuth_rad)))
        return level / math.cos(elevation_rad)

    return reach_m

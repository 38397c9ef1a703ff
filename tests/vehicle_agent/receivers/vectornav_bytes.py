"""Binary messages as a VectorNav sends them, written from its manual and by nothing of ours."""

import struct


def crc16(data: bytes) -> int:
    """CCITT, polynomial 0x1021, begun with 0, bit by bit."""
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x1021 if crc & 0x8000 else crc << 1) & 0xFFFF
    return crc


def message(groups: int, fields: list[int], payload: bytes) -> bytes:
    body = struct.pack("<B", groups) + struct.pack(f"<{len(fields)}H", *fields) + payload
    return b"\xfa" + body + struct.pack(">H", crc16(body))


def common(
    accel: tuple[float, float, float] = (0.0, 0.0, -9.80665),
    rates: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ypr_deg: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> bytes:
    """Group 1: yaw, pitch and roll, angular rates, acceleration."""
    return message(0x01, [1 << 3 | 1 << 5 | 1 << 8], struct.pack("<9f", *ypr_deg, *rates, *accel))


def ins(
    latitude_deg: float,
    longitude_deg: float,
    north_mps: float,
    east_mps: float,
    yaw_deg: float,
    position_std_m: float = 0.02,
    mode: int = 2,
    gps_ns: int = 0,
) -> bytes:
    """Group 1 with time and attitude, group 6 with status, place, velocity and deviation."""
    payload = struct.pack("<Q3f", gps_ns, yaw_deg, 0.0, 0.0)
    payload += struct.pack(
        "<H3d3ff", mode, latitude_deg, longitude_deg, 12.0, north_mps, east_mps, 0.0, position_std_m
    )
    return message(0x21, [1 << 1 | 1 << 3, 1 << 0 | 1 << 1 | 1 << 4 | 1 << 9], payload)

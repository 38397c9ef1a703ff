"""VectorNav inertial sensors and receivers: their binary output, of any configuration. Pure.

Interface: VN-100, VN-200 and VN-300 user manuals, "Binary Output Message Protocol". A message names its
groups of fields and the fields of each; all values are little-endian. There is no maintained reader as a
wheel, so this is ours.
"""

import math
import struct

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.receivers.solutions import Solution

_SYNC = 0xFA
_CRC_BYTES = 2
# Bytes of each field of the groups Common, Time, IMU, GPS, Attitude, INS and GPS2; 0: not defined.
_GPS = (8, 8, 2, 1, 1, 24, 24, 12, 12, 12, 4, 4, 2, 28)
_FIELD_BYTES = (
    (8, 8, 8, 12, 16, 12, 24, 12, 12, 24, 20, 28, 2, 4, 8),
    (8, 8, 8, 2, 8, 8, 8, 4, 4, 1),
    (2, 12, 12, 12, 4, 4, 16, 12, 12, 12, 12, 2),
    _GPS,
    (2, 12, 16, 36, 12, 12, 12, 12, 12, 12),
    (2, 24, 24, 12, 12, 12, 12, 12, 12, 4, 4),
    _GPS,
)
# (group, bit) of the fields that are read.
_COMMON, _TIME, _IMU, _ATTITUDE, _INS = 0, 1, 2, 4, 5
_YPR, _RATES, _POSITION, _VELOCITY, _ACCEL = (
    (_COMMON, 3),
    (_COMMON, 5),
    (_COMMON, 6),
    (_COMMON, 7),
    (_COMMON, 8),
)
_INS_STATUS, _GPS_TIME = (_COMMON, 12), (_COMMON, 1)
_GPS_LEAP_S = 18
_GPS_EPOCH_UTC_S = 315_964_800
# INS modes (bits 0 and 1 of InsStatus): 2 is a solution within its specification, 3 one without GNSS.
_INS_TRACKING, _INS_WITHOUT_GNSS = 2, 3
STANDARD_GRAVITY_MPS2 = 9.80665


class InertialReading(msgspec.Struct, frozen=True):
    """One sample in the sensor's frame, x forward, y right, z down.

    accel_sensor_mps2   (3,) specific force: -g along z at rest
    rates_sensor_radps  (3,)
    roll_rad, pitch_rad of the sensor, None where it sends no attitude
    """

    stamp_ns: int
    accel_sensor_mps2: Array
    rates_sensor_radps: Array
    roll_rad: float | None
    pitch_rad: float | None


class VectorNav:
    """One sensor; sans I/O.

    refused  messages by what is wrong: `bad_checksum`, `unknown_fields` (of a firmware that is not known)
    skipped  bytes that belong to no binary message, the sensor's text lines among them
    other    whole messages without acceleration, rates or position
    """

    def __init__(self) -> None:
        self.refused: dict[str, int] = {}
        self.skipped = 0
        self.other = 0
        self._held = bytearray()

    def add(self, stamp_ns: int, data: bytes) -> tuple[list[InertialReading], list[Solution]]:
        """What these bytes complete; stamp_ns: when they came, in the vehicle's clock."""
        self._held += data
        readings: list[InertialReading] = []
        solutions: list[Solution] = []
        while (fields := self._next()) is not None:
            reading, solution = _reading(stamp_ns, fields), _solution(fields)
            if reading is not None:
                readings.append(reading)
            if solution is not None:
                solutions.append(solution)
            if reading is None and solution is None:
                self.other += 1
        return readings, solutions

    def _next(self) -> dict[tuple[int, int], bytes] | None:
        """The fields of the next whole message."""
        while True:
            begin = self._held.find(_SYNC)
            self._drop(begin if begin >= 0 else len(self._held))
            layout = _layout(self._held)
            if layout is None:
                return None
            names, length = layout
            if length == 0:
                self._refuse("unknown_fields")
                self._drop(1)
                continue
            if len(self._held) < length:
                return None
            if _crc(self._held[1:length]) != 0:
                self._refuse("bad_checksum")
                self._drop(1)
                continue
            at = length - _CRC_BYTES - sum(_FIELD_BYTES[group][bit] for group, bit in names)
            fields: dict[tuple[int, int], bytes] = {}
            for group, bit in names:
                size = _FIELD_BYTES[group][bit]
                fields[group, bit] = bytes(self._held[at : at + size])
                at += size
            del self._held[:length]
            return fields

    def _drop(self, count: int) -> None:
        self.skipped += count
        del self._held[:count]

    def _refuse(self, code: str) -> None:
        self.refused[code] = self.refused.get(code, 0) + 1


def _layout(held: bytearray) -> tuple[list[tuple[int, int]], int] | None:
    """(fields, length) of the message at the front; length 0: it has unknown fields; None: too few bytes."""
    if len(held) < 2:
        return None
    groups = [group for group in range(8) if held[1] >> group & 1]
    if not groups or groups[-1] >= len(_FIELD_BYTES):
        return [], 0
    header = 2 + 2 * len(groups)
    if len(held) < header:
        return None
    names: list[tuple[int, int]] = []
    for number, group in enumerate(groups):
        chosen = int.from_bytes(held[2 + 2 * number : 4 + 2 * number], "little")
        if chosen == 0 or chosen >> len(_FIELD_BYTES[group]):
            return [], 0
        names += [(group, bit) for bit in range(len(_FIELD_BYTES[group])) if chosen >> bit & 1]
    return names, header + sum(_FIELD_BYTES[group][bit] for group, bit in names) + _CRC_BYTES


def _reading(stamp_ns: int, fields: dict[tuple[int, int], bytes]) -> InertialReading | None:
    accel = fields.get(_ACCEL) or fields.get((_IMU, 9)) or fields.get((_IMU, 2))
    rates = fields.get(_RATES) or fields.get((_IMU, 10)) or fields.get((_IMU, 3))
    if accel is None and (_COMMON, 9) in fields:
        accel = fields[_COMMON, 9][:12]
        rates = rates or fields[_COMMON, 9][12:]
    if accel is None or rates is None:
        return None
    attitude = fields.get(_YPR) or fields.get((_ATTITUDE, 1))
    roll_rad = pitch_rad = None
    if attitude is not None:
        _, pitch_deg, roll_deg = struct.unpack("<3f", attitude)
        roll_rad, pitch_rad = math.radians(roll_deg), math.radians(pitch_deg)
    return InertialReading(stamp_ns, _vector(accel), _vector(rates), roll_rad, pitch_rad)


def _solution(fields: dict[tuple[int, int], bytes]) -> Solution | None:
    """Where the sensor says that it is. None if it says that it does not know, or sends too few fields."""
    position = fields.get((_INS, 1)) or fields.get(_POSITION)
    velocity = fields.get((_INS, 4)) or fields.get(_VELOCITY)
    status = fields.get((_INS, 0)) or fields.get(_INS_STATUS)
    attitude = fields.get(_YPR) or fields.get((_ATTITUDE, 1))
    deviation = fields.get((_INS, 9))
    if position is None or velocity is None or status is None or attitude is None or deviation is None:
        return None
    if struct.unpack("<H", status)[0] & 3 not in (_INS_TRACKING, _INS_WITHOUT_GNSS):
        return None
    latitude_deg, longitude_deg, _ = struct.unpack("<3d", position)
    north_mps, east_mps, _ = struct.unpack("<3f", velocity)
    yaw_deg, _, _ = struct.unpack("<3f", attitude)
    return Solution(
        _utc_ns(fields),
        latitude_deg,
        longitude_deg,
        math.hypot(north_mps, east_mps),
        math.atan2(east_mps, north_mps),
        math.radians(yaw_deg),
        struct.unpack("<f", deviation)[0],
    )


def _utc_ns(fields: dict[tuple[int, int], bytes]) -> int | None:
    """GPS time, less the leap seconds since 1980; None where it is not sent or not known yet."""
    raw = fields.get(_GPS_TIME) or fields.get((_TIME, 1))
    gps_ns = 0 if raw is None else int.from_bytes(raw, "little")
    return gps_ns + (_GPS_EPOCH_UTC_S - _GPS_LEAP_S) * 1_000_000_000 if gps_ns else None


def _vector(data: bytes) -> Array:
    return np.array(struct.unpack("<3f", data), dtype=np.float64)


def _crc(data: bytearray) -> int:
    """CRC-16 of CCITT, begun with 0; 0 over a whole message with its own at the end, high byte first."""
    crc = 0
    for byte in data:
        crc = (crc >> 8 | crc << 8) & 0xFFFF
        crc ^= byte
        crc ^= (crc & 0xFF) >> 4
        crc ^= crc << 12 & 0xFFFF
        crc ^= (crc & 0xFF) << 5
    return crc

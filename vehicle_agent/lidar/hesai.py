"""Hesai's data packets: XT16, XT32, Pandar40P, Pandar64 (user manuals, "point cloud data packet")."""

from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from vehicle_agent.lidar.models import PANDAR40P, PANDAR64, XT16, XT32, LidarModel
from vehicle_agent.lidar.packets import PacketError, PacketLayout, Packets, blocks_of, u32

_HEADER = b"\xee\xff"
_BLOCK = b"\xff\xee"
_RETURNS = {0x33: 1, 0x37: 1, 0x38: 1, 0x39: 2, 0x3B: 2, 0x3C: 2}


@dataclass(frozen=True, slots=True, eq=False)
class _Kind:
    """The layout of packets, and where they have the stamp (us), the date (6 bytes) and the return mode."""

    layout: PacketLayout
    stamp: int
    date: int
    first_year: int
    return_mode: int


def _xt(channels: int) -> _Kind:
    block_bytes = 2 + 4 * channels
    tail = 12 + 8 * block_bytes
    return _Kind(
        PacketLayout(tail + 28, 0, 12, block_bytes, 8, b"", 4, channels),
        tail + 19,
        tail + 13,
        1900,
        tail + 10,
    )


def _pandar(channels: int, header_bytes: int, blocks: int, mark: bytes) -> _Kind:
    block_bytes = len(mark) + 2 + 3 * channels
    tail = header_bytes + blocks * block_bytes
    # A sequence number of 4 bytes may follow.
    layout = PacketLayout(tail + 22, 4, header_bytes, block_bytes, blocks, mark, 3, channels)
    return _Kind(layout, tail + 10, tail + 16, 2000, tail + 14)


_KINDS = {
    XT16.name: _xt(16),
    XT32.name: _xt(32),
    PANDAR40P.name: _pandar(40, 0, 10, _BLOCK),
    PANDAR64.name: _pandar(64, 8, 6, b""),
}


def is_hesai(packet: bytes) -> bool:
    """Whether a packet is Hesai's by its first mark; a Pandar40P's has no header and is known by its size."""
    size = _KINDS[PANDAR40P.name].layout.size
    return packet[:2] == _HEADER or (packet[:2] == _BLOCK and len(packet) in (size, size + 4))


def model_of(packet: bytes) -> LidarModel:
    """The model by the header; PacketError for one that is not known."""
    if packet[:2] == _BLOCK:
        return PANDAR40P
    if len(packet) < 8:
        raise PacketError("cut_packet", f"{len(packet)} bytes are no packet")
    major, lasers, blocks = packet[2], packet[6], packet[7]
    if major == 6 and blocks == 8 and lasers in (16, 32):
        return XT16 if lasers == 16 else XT32
    # The Pandar64's header has no version: its third byte is the number of lasers.
    if packet[2] == 64 and packet[3] == 6:
        return PANDAR64
    raise PacketError("unknown_model", f"Hesai header {packet[:8].hex()} is not known")


def mode_of(packet: bytes, model: LidarModel) -> int:
    """The byte of the return mode; PacketError for a packet that ends before it."""
    at = _KINDS[model.name].return_mode
    if len(packet) <= at:
        raise PacketError("cut_packet", f"{len(packet)} bytes end before the return mode")
    return packet[at]


def decode(data: list[bytes], model: LidarModel) -> Packets:
    """These packets, at least one, all of one return mode; PacketError."""
    kind = _KINDS[model.name]
    raw, azimuths, distances, intensities = blocks_of(data, kind.layout)
    mode = int(raw[0, kind.return_mode])
    if mode not in _RETURNS:
        raise PacketError("unknown_model", f"{model.name} has no return mode 0x{mode:02x}")
    return Packets(
        model, azimuths, distances, intensities, _dates_ns(raw, kind) + 1000 * u32(raw, kind.stamp),
        _RETURNS[mode], 0,
    )  # fmt: skip


def _dates_ns(raw: np.ndarray, kind: _Kind) -> np.ndarray:
    """(p,) whole seconds of UTC in ns; 0 for a date that is none: the sensor was never told the time."""
    dates = raw[:, kind.date : kind.date + 6]
    known, which = np.unique(dates, axis=0, return_inverse=True)
    return np.array([_date_ns(date.tolist(), kind.first_year) for date in known], dtype=np.int64)[
        which.ravel()
    ]


def _date_ns(date: list[int], first_year: int) -> int:
    year, month, day, hour, minute, second = date
    try:
        moment = datetime(first_year + year, month, day, hour, minute, second, tzinfo=UTC)
    except ValueError:
        return 0
    return int(moment.timestamp()) * 1_000_000_000

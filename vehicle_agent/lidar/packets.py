"""What one packet says, the same for every maker, and the errors of packets that say nothing."""

from dataclasses import dataclass

import numpy as np

from vehicle_agent.lidar.models import LidarModel


class PacketError(ValueError):
    """A packet that cannot be decoded; `code` is one of PACKET_CODES."""

    def __init__(self, code: str, detail: str) -> None:
        super().__init__(detail)
        self.code = code


# unknown_model: no lidar that is known sends this. cut_packet: the end is missing, or there is too much.
# bad_block: a block does not begin with its mark. bad_azimuth: an azimuth of 360 degrees or more.
PACKET_CODES = ("unknown_model", "cut_packet", "bad_block", "bad_azimuth")


@dataclass(frozen=True, slots=True, eq=False)
class PacketLayout:
    """Where the values are in the packets of a model.

    size         bytes of a packet; trailing_bytes_max more are allowed and ignored
    first_block  where the blocks begin; block_bytes of one; blocks of them
    mark         bytes at the beginning of each block, b"" without one
    unit_bytes   of one return: distance (2, little-endian), intensity (1), and what is ignored
    """

    size: int
    trailing_bytes_max: int
    first_block: int
    block_bytes: int
    blocks: int
    mark: bytes
    unit_bytes: int
    units: int


@dataclass(frozen=True, slots=True, eq=False)
class Packets:
    """Packets of one model, decoded.

    azimuths_cdeg  (p, blocks) int64, hundredths of a degree, 0..35999
    distances      (p, blocks, units) int64, raw
    intensities    (p, blocks, units) uint8
    sensor_ns      (p,) int64, the time in the packet, in the sensor's clock (see sensor_time_period_ns)
    returns        1, 2 or 3: the returns of one firing, in blocks that follow each other
    sensor_time_period_ns  after which sensor_ns begins again; 0 for a whole date
    """

    model: LidarModel
    azimuths_cdeg: np.ndarray
    distances: np.ndarray
    intensities: np.ndarray
    sensor_ns: np.ndarray
    returns: int
    sensor_time_period_ns: int


def each_of(packets: Packets) -> list[Packets]:
    """The packets one by one; their arrays are views."""
    return [
        Packets(
            packets.model,
            packets.azimuths_cdeg[k : k + 1],
            packets.distances[k : k + 1],
            packets.intensities[k : k + 1],
            packets.sensor_ns[k : k + 1],
            packets.returns,
            packets.sensor_time_period_ns,
        )
        for k in range(len(packets.sensor_ns))
    ]


def blocks_of(
    data: list[bytes], layout: PacketLayout
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(bytes (p, size), azimuths (p, blocks), distances, intensities (p, blocks, units)); PacketError."""
    for packet in data:
        if not layout.size <= len(packet) <= layout.size + layout.trailing_bytes_max:
            raise PacketError("cut_packet", f"{len(packet)} bytes where {layout.size} were expected")
    raw = np.frombuffer(b"".join(packet[: layout.size] for packet in data), dtype=np.uint8)
    raw = raw.reshape(len(data), layout.size)
    end = layout.first_block + layout.blocks * layout.block_bytes
    blocks = raw[:, layout.first_block : end].reshape(len(data), layout.blocks, layout.block_bytes)
    mark = len(layout.mark)
    if mark and (blocks[:, :, :mark] != np.frombuffer(layout.mark, dtype=np.uint8)).any():
        raise PacketError("bad_block", f"a block does not begin with {layout.mark.hex()}")
    azimuths = _u16(blocks[:, :, mark : mark + 2])
    if (azimuths >= 36_000).any():
        raise PacketError("bad_azimuth", f"azimuth {azimuths.max() / 100.0:.2f} degrees")
    units = blocks[:, :, mark + 2 : mark + 2 + layout.units * layout.unit_bytes]
    units = units.reshape(len(data), layout.blocks, layout.units, layout.unit_bytes)
    return raw, azimuths, _u16(units[..., 0:2]), units[..., 2]


def u32(raw: np.ndarray, at: int) -> np.ndarray:
    """(p,) little-endian numbers of four bytes at this place of every packet (p, size)."""
    return np.ascontiguousarray(raw[:, at : at + 4]).view("<u4")[:, 0].astype(np.int64)


def _u16(pairs: np.ndarray) -> np.ndarray:
    return pairs[..., 0].astype(np.int64) | (pairs[..., 1].astype(np.int64) << 8)

"""Velodyne's data packets: VLP-16, Puck LITE, Puck Hi-Res, HDL-32E, VLP-32C (63-9243 rev. E, chapter 9)."""

import numpy as np

from vehicle_agent.lidar.models import HDL32E, PUCK_HI_RES, VLP16, VLP32C, LidarModel
from vehicle_agent.lidar.packets import PacketError, PacketLayout, Packets, blocks_of, u32

LAYOUT = PacketLayout(
    size=1206,
    trailing_bytes_max=0,
    first_block=0,
    block_bytes=100,
    blocks=12,
    mark=b"\xff\xee",
    unit_bytes=3,
    units=32,
)
_STAMP, _RETURN_MODE, _PRODUCT = 1200, 1204, 1205
_HOUR_NS = 3_600_000_000_000
_DUAL = 0x39
_PRODUCTS = {0x21: HDL32E, 0x22: VLP16, 0x24: PUCK_HI_RES, 0x28: VLP32C}


def is_velodyne(packet: bytes) -> bool:
    """Whether a packet is Velodyne's by its size and first mark."""
    return len(packet) == LAYOUT.size and packet[:2] == LAYOUT.mark


def model_of(packet: bytes) -> LidarModel:
    """The model by the product's byte; PacketError for one that is not known."""
    if len(packet) != LAYOUT.size:
        raise PacketError("cut_packet", f"{len(packet)} bytes where {LAYOUT.size} were expected")
    model = _PRODUCTS.get(packet[_PRODUCT])
    if model is None:
        raise PacketError("unknown_model", f"Velodyne product 0x{packet[_PRODUCT]:02x} is not known")
    return model


def mode_of(packet: bytes) -> int:
    """The byte of the return mode, of a packet whose size is right."""
    return packet[_RETURN_MODE]


def decode(data: list[bytes], model: LidarModel) -> Packets:
    """These packets, at least one, all of one return mode; PacketError."""
    raw, azimuths, distances, intensities = blocks_of(data, LAYOUT)
    returns = 2 if raw[0, _RETURN_MODE] == _DUAL else 1
    if model.channels == 16:
        azimuths, distances, intensities = _sequences(azimuths, distances, intensities, returns)
    return Packets(model, azimuths, distances, intensities, 1000 * u32(raw, _STAMP), returns, _HOUR_NS)


def _sequences(
    azimuths: np.ndarray, distances: np.ndarray, intensities: np.ndarray, returns: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The two sequences of 16 firings of a block as blocks of their own.

    The second one's azimuth is halfway to the next block's; of the last block, as far as the one before.
    """
    packets = len(azimuths)
    gaps = (azimuths[:, returns:] - azimuths[:, :-returns]) % 36_000
    gaps = np.hstack((gaps, gaps[:, -returns:]))
    halfway = (azimuths + gaps // 2) % 36_000
    split = np.stack((azimuths, halfway), axis=2)
    distances, intensities = (
        values.reshape(packets, LAYOUT.blocks, 2, 16) for values in (distances, intensities)
    )
    if returns == 2:
        # Both returns of a sequence one after the other, as the returns of the other models are.
        split, distances, intensities = (
            values.reshape(packets, LAYOUT.blocks // 2, 2, 2, *values.shape[3:]).swapaxes(2, 3)
            for values in (split, distances, intensities)
        )
    blocks = 2 * LAYOUT.blocks
    return (
        split.reshape(packets, blocks),
        distances.reshape(packets, blocks, 16),
        intensities.reshape(packets, blocks, 16),
    )

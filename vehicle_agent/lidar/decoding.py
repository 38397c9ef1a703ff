"""Packets of any known lidar: which model sends them, and what they say."""

from vehicle_agent.lidar import hesai, velodyne
from vehicle_agent.lidar.models import VELODYNE, LidarModel
from vehicle_agent.lidar.packets import PacketError, Packets


def model_of(packet: bytes) -> LidarModel:
    """The model that sends this packet; PacketError."""
    if velodyne.is_velodyne(packet):
        return velodyne.model_of(packet)
    if hesai.is_hesai(packet):
        return hesai.model_of(packet)
    raise PacketError(
        "unknown_model", f"{len(packet)} bytes that begin with {packet[:4].hex()} are no known packet"
    )


def kind_of(packet: bytes) -> tuple[LidarModel, int]:
    """Model and return mode: packets in which both are the same are decoded together. PacketError."""
    model = model_of(packet)
    return model, velodyne.mode_of(packet) if model.maker == VELODYNE else hesai.mode_of(packet, model)


def decode_packets(data: list[bytes], model: LidarModel) -> Packets:
    """These packets of one model, at least one; PacketError for the first one that is wrong."""
    return velodyne.decode(data, model) if model.maker == VELODYNE else hesai.decode(data, model)

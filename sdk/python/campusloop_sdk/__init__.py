"""Script a Campusloop campus: list vehicles and rides, send shuttles, receive notifications."""

from campusloop_sdk.client import Campus, Topic, connect
from campusloop_sdk.errors import ConnectionLost, RequestRefused
from campusloop_sdk.models import (
    CommandReceipt,
    Notification,
    Pose,
    RideSummary,
    SentVisit,
    Shuttle,
    Stop,
    VehicleFacts,
    VehicleStatus,
    VehicleTask,
)

__all__ = [
    "Campus",
    "CommandReceipt",
    "ConnectionLost",
    "Notification",
    "Pose",
    "RequestRefused",
    "RideSummary",
    "SentVisit",
    "Shuttle",
    "Stop",
    "Topic",
    "VehicleFacts",
    "VehicleStatus",
    "VehicleTask",
    "connect",
]

"""Script a Campusloop campus: list vehicles and rides, send shuttles, follow what happens."""

from campusloop_sdk.client import Campus, Topic, connect
from campusloop_sdk.errors import ConnectionLost, RequestRefused
from campusloop_sdk.models import CommandReceipt, Notification, RideSummary, SentVisit, Shuttle, Stop

__all__ = [
    "Campus",
    "CommandReceipt",
    "ConnectionLost",
    "Notification",
    "RequestRefused",
    "RideSummary",
    "SentVisit",
    "Shuttle",
    "Stop",
    "Topic",
    "connect",
]

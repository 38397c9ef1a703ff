"""Scans of a run beside the map that the vehicle compared them with."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import msgspec

from contract.geometry import Pose2
from contract.runlog.indexed import messages_of
from contract.runlog.matched_scans import AGREES, NEW, THROUGH, MatchedScan, points_of
from contract.runlog.reader import RunLogError
from contract.runlog.records import SCAN_TOPIC

MS_NS = 1_000_000

PointKind = Literal["agrees", "new", "through"]
_KINDS: dict[int, PointKind] = {AGREES: "agrees", NEW: "new", THROUGH: "through"}


class ScanMoment(msgspec.Struct, frozen=True):
    """One scan, map frame, metres.

    agreement  share of the points above the road that lie on the map
    agrees     x0, y0, x1, y1, ... of points on the map
    new        of points on something that the map has not
    through    of points beyond a wall of the map: something has gone, or the pose is wrong
    """

    at_ms: int
    pose_map: Pose2
    agreement: float
    agrees: list[float]
    new: list[float]
    through: list[float]


def recorded_scans(segments: Sequence[Path], from_ms: int, to_ms: int) -> list[ScanMoment]:
    """Every scan of [from_ms, to_ms), oldest first.

    A damaged or cut segment ends where it is no longer sound; so does one with a message that is no scan.
    """
    found: list[ScanMoment] = []
    decoder = msgspec.json.Decoder(MatchedScan)
    for path in segments:
        try:
            for message in messages_of(path, (SCAN_TOPIC,), from_ms * MS_NS, to_ms * MS_NS):
                found.append(_moment(decoder.decode(message.data), message.log_ns // MS_NS))
        except msgspec.DecodeError:
            continue
        except RunLogError as error:
            if error.code not in ("truncated", "damaged"):
                raise
    return found


def _moment(scan: MatchedScan, at_ms: int) -> ScanMoment:
    points, kinds = points_of(scan)
    parts = {name: points[kinds == number].round(2).ravel().tolist() for number, name in _KINDS.items()}
    return ScanMoment(at_ms, scan.pose_map, round(scan.agreement, 3), **parts)

"""The positions of a run at 5 Hz, in the map frame and on WGS 84, as CSV or GeoJSON."""

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import msgspec

from campusloop.run_logs.folders import RecordedRun, utc_of
from contract.roads.load import decode_map
from contract.roads.projection import unproject
from contract.runlog.reader import RunLogError, messages, open_segment
from contract.runlog.records import REPORT_TOPIC, TICK_TOPIC, TickRecord
from contract.wire.messages import Status
from vehicle_agent.signals import Ego

# About 1 cm on the ground, as far as a position can be trusted.
DEGREE_DECIMALS = 7
CSV_COLUMNS = (
    "utc", "latitude_deg", "longitude_deg", "x_m", "y_m", "yaw_rad",
    "speed_mps", "accel_mps2", "steer_rad", "mode", "lane_id", "battery_ratio", "doors_open",
)  # fmt: skip


class _Localized(msgspec.Struct):
    """The part of a tick's record that is read."""

    ego: Ego


@dataclass(frozen=True, slots=True)
class Position:
    """Where the middle of the rear axle was, on WGS 84 and, in `status`, in the map frame."""

    at: datetime
    latitude_deg: float
    longitude_deg: float
    status: Status


@dataclass(frozen=True, slots=True)
class Positions:
    """defects: what is wrong with each file that is not sound to its end; what came before is in `found`."""

    found: tuple[Position, ...]
    defects: tuple[RunLogError, ...]


def positions_of(run: RecordedRun) -> Positions:
    """A position for each report at which the vehicle knew where it was.

    Raises MapError and RunLogError for a segment whose map or records cannot be read at all.
    """
    found: list[Position] = []
    defects: list[RunLogError] = []
    for segment in run.segments:
        origin = decode_map(open_segment(segment.path).road_map).origin
        try:
            for log_ns, status in _localized_reports(segment.path):
                pose = status.pose_map
                latitude_deg, longitude_deg = unproject(origin, pose.x_m, pose.y_m)
                found.append(Position(utc_of(log_ns), latitude_deg, longitude_deg, status))
        except RunLogError as error:
            if error.code not in ("truncated", "damaged"):
                raise
            defects.append(error)
    return Positions(tuple(found), tuple(defects))


def positions_csv(found: tuple[Position, ...]) -> bytes:
    """A line for each position, below a line with the names of CSV_COLUMNS."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(CSV_COLUMNS)
    for one in found:
        status, pose = one.status, one.status.pose_map
        longitude_deg, latitude_deg = _degrees(one)
        place = (round(pose.x_m, 3), round(pose.y_m, 3), round(pose.yaw_rad, 5))
        motion = (round(status.speed_mps, 3), round(status.accel_mps2, 3), round(status.steer_rad, 5))
        state = (status.mode, status.lane_id, round(status.battery_ratio, 4), status.doors_open)
        lines.writerow((_utc(one.at), latitude_deg, longitude_deg, *place, *motion, *state))
    return text.getvalue().encode()


def positions_geojson(run: RecordedRun, found: tuple[Position, ...]) -> bytes:
    """A FeatureCollection (RFC 7946) of one line, or of one point for a single position.

    The property coordTimes has the UTC time of each coordinate, as programs that read GPX tracks expect.
    """
    pairs = [_degrees(one) for one in found]
    geometry: dict[str, object] | None = None
    if pairs:
        is_line = len(pairs) > 1
        geometry = {
            "type": "LineString" if is_line else "Point",
            "coordinates": pairs if is_line else pairs[0],
        }
    header = run.header
    properties = {
        "vehicle_id": header.vehicle_id,
        "boot_id": header.boot_id,
        "campus_id": header.campus_id,
        "map_version": header.map_version,
        "stack": header.stack,
        "coordTimes": [_utc(one.at) for one in found],
        "speeds_mps": [round(one.status.speed_mps, 3) for one in found],
    }
    feature = {"type": "Feature", "geometry": geometry, "properties": properties}
    return msgspec.json.encode({"type": "FeatureCollection", "features": [feature]}) + b"\n"


def _degrees(one: Position) -> tuple[float, float]:
    """(longitude, latitude), the order of GeoJSON."""
    return round(one.longitude_deg, DEGREE_DECIMALS), round(one.latitude_deg, DEGREE_DECIMALS)


def _utc(at: datetime) -> str:
    return at.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _localized_reports(path: Path) -> Iterator[tuple[int, Status]]:
    """(log time, status) while the tick says that the vehicle is localized. Raises like `messages`."""
    records = msgspec.msgpack.Decoder(TickRecord)
    rooms = msgspec.msgpack.Decoder(_Localized)
    statuses = msgspec.json.Decoder(Status)
    is_localized = False
    for message in messages(path):
        if message.topic == TICK_TOPIC:
            is_localized = rooms.decode(records.decode(message.data).rooms).ego.valid
        elif message.topic == REPORT_TOPIC and is_localized:
            yield message.log_ns, statuses.decode(message.data)

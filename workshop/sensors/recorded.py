"""Recorded sources: bags, folders of scans, and files of a receiver's bytes."""

from pathlib import Path

from workshop.clouds import bags
from workshop.clouds.errors import CloudFileError
from workshop.clouds.fields import MissingFieldError
from workshop.clouds.point_cloud2 import CloudMessageError, cloud_of_message
from workshop.clouds.recordings import READERS, find_recordings
from workshop.sensors.gnss_source import GnssCheck
from workshop.sensors.lidar_source import CloudCheck, PacketCheck
from workshop.sensors.source_report import Arrivals, SourceReport

RECEIVER_SUFFIXES = (".nmea", ".ubx", ".gnss")
# Less than any epoch, so that none is passed over.
_CHUNK_BYTES = 32


def check_recorded(path: Path) -> list[SourceReport]:
    """Every source of a bag, a folder of scans or a file of a receiver's bytes; CloudFileError."""
    if bags.is_bag(path):
        return _check_bag(path)
    if path.suffix.lower() in RECEIVER_SUFFIXES:
        return [_check_receiver_file(path)]
    if path.is_dir() or path.suffix.lower() in READERS:
        return _check_folders(path)
    raise CloudFileError(path, f"is no bag, no folder of scans and no {', '.join(RECEIVER_SUFFIXES)}")


def _check_bag(path: Path) -> list[SourceReport]:
    packets: dict[str, PacketCheck] = {}
    clouds: dict[str, CloudCheck] = {}
    others: dict[str, Arrivals] = {}
    refused: dict[str, dict[str, int]] = {}
    topics = bags.topics(path)
    for item in bags.messages(path):
        name = item.topic.name
        if item.topic.kind in bags.PACKET_TYPES:
            for arrived_ns, data in bags.packets_of(item):
                packets.setdefault(name, PacketCheck()).add(arrived_ns, data)
        elif item.topic.kind == bags.CLOUD_TYPE:
            made_ns = bags.stamp_of(item.message.header.stamp)
            try:
                cloud = cloud_of_message(item.message, made_ns)
            except (CloudMessageError, MissingFieldError):
                counts = refused.setdefault(name, {})
                counts["bad_message"] = counts.get("bad_message", 0) + 1
                continue
            clouds.setdefault(name, CloudCheck()).add(item.recorded_ns, cloud, made_ns)
        else:
            header = getattr(item.message, "header", None)
            made = None if header is None else bags.stamp_of(header.stamp) or None
            others.setdefault(name, Arrivals()).add(item.recorded_ns, made)
    reports = []
    for topic in topics:
        name = topic.name
        if name in packets:
            reports.append(packets[name].report(name))
        elif topic.kind == bags.CLOUD_TYPE:
            reports.append(clouds.get(name, CloudCheck()).report(name, topic.kind, refused.get(name, {})))
        else:
            reports.append(_of_other(topic, others.get(name, Arrivals())))
    return reports


def _of_other(topic: bags.Topic, arrivals: Arrivals) -> SourceReport:
    """Of a topic that is not understood: its times. Many are sent once, or when something happens."""
    clock, latency_ms = arrivals.clock()
    return SourceReport(
        topic.name, topic.kind, len(arrivals.arrived_ns), arrivals.rate_hz, latency_ms, clock, ()
    )


def _check_folders(path: Path) -> list[SourceReport]:
    reports = []
    for recording in find_recordings(path):
        check = CloudCheck()
        for cloud in recording.scans():
            check.add(cloud.stamp_ns, cloud, None)
        reports.append(check.report(str(recording.path), "scans", {}))
    return reports


def _check_receiver_file(path: Path) -> SourceReport:
    check = GnssCheck()
    try:
        data = path.read_bytes()
    except OSError as error:
        raise CloudFileError(path, error.strerror or "cannot be read") from error
    for at in range(0, len(data), _CHUNK_BYTES):
        check.add(None, data[at : at + _CHUNK_BYTES])
    return check.report(path.name)

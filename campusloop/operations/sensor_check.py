"""Live sensors, listened to for some seconds: `campusloop sensors check`."""

import select
import time
from dataclasses import dataclass
from typing import Protocol

from vehicle_agent.receivers.gnss_receiver import ReceiverError
from vehicle_agent.runtime.devices.byte_sources import ByteSourceError, DatagramSource, StreamSource
from workshop.sensors.gnss_source import GnssCheck
from workshop.sensors.lidar_source import PacketCheck
from workshop.sensors.source_report import SourceReport

FORMS = "lidar:udp:PORT, gnss:udp:PORT, gnss:tcp:HOST:PORT, gnss:/dev/NAME"


class SourceNameError(Exception):
    """A source that cannot be listened to; the message says why."""


class Check(Protocol):
    """What a live source's bytes are given to."""

    def add(self, arrived_ns: int, data: bytes) -> None: ...

    def report(self, name: str) -> SourceReport: ...


@dataclass(frozen=True, slots=True, eq=False)
class LiveSource:
    """One source that is open."""

    name: str
    source: DatagramSource | StreamSource
    check: Check


def is_live(name: str) -> bool:
    """Whether this names a live source, not a file."""
    return name.startswith(("lidar:", "gnss:"))


def open_source(name: str) -> LiveSource:
    """SourceNameError for a name of no form, or a source that cannot be opened."""
    try:
        match name.split(":"):
            case ["lidar", "udp", port] if port.isdigit():
                return LiveSource(name, DatagramSource(int(port)), PacketCheck())
            case ["gnss", "udp", port] if port.isdigit():
                return LiveSource(name, DatagramSource(int(port)), GnssCheck())
            case ["gnss", "tcp", host, port] if port.isdigit():
                return LiveSource(name, StreamSource.connected(host, int(port)), GnssCheck())
            case ["gnss", device] if device.startswith("/"):
                return LiveSource(name, StreamSource.device(device), GnssCheck())
    except (ByteSourceError, ReceiverError) as error:
        raise SourceNameError(f"{name}: {error}") from error
    raise SourceNameError(f"{name} names no source; there are: {FORMS}")


def listen(sources: list[LiveSource], seconds: float) -> list[SourceReport]:
    """What comes from all of them in this time, stamped with this computer's UTC."""
    end_s = time.monotonic() + seconds
    open_sources = list(sources)
    while open_sources and (left_s := end_s - time.monotonic()) > 0.0:
        ready, _, _ = select.select([live.source for live in open_sources], [], [], min(left_s, 0.1))
        arrived_ns = time.time_ns()
        for live in open_sources:
            if live.source in ready:
                for data in live.source.poll():
                    live.check.add(arrived_ns, data)
        open_sources = [live for live in open_sources if not getattr(live.source, "ended", False)]
    return [live.check.report(live.name) for live in sources]

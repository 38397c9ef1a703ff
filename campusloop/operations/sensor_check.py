"""Live sensors, listened to for some seconds: `campusloop sensors check`."""

import select
import termios
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from vehicle_agent.lidar.cola import START_TURNS
from vehicle_agent.receivers.gnss_receiver import ReceiverError
from vehicle_agent.runtime.devices.byte_sources import ByteSourceError, DatagramSource, StreamSource
from vehicle_agent.runtime.sensors.addresses import Address, AddressError, address_of
from vehicle_agent.runtime.sensors.sensors_file import SensorsError, load_sensors
from vehicle_agent.runtime.sensors.streams import set_raw
from workshop.sensors.gnss_source import GnssCheck
from workshop.sensors.inertial_source import InertialCheck
from workshop.sensors.lidar_source import PacketCheck
from workshop.sensors.scanner_source import ScannerCheck
from workshop.sensors.source_report import SourceReport

FORMS = (
    "lidar:udp:PORT; scanner:tcp:HOST:PORT; gnss: or imu: with udp:PORT, tcp:HOST:PORT or /dev/NAME; "
    "a sensors.toml"
)


class SourceNameError(Exception):
    """A source that cannot be listened to; the message says why."""


class Check(Protocol):
    """What a live source's bytes are given to."""

    def add(self, arrived_ns: int, data: bytes) -> None: ...

    def report(self, name: str) -> SourceReport: ...


# Of a byte stream, by the kind of its sensor.
CHECKS: dict[str, Callable[[], Check]] = {"gnss:": GnssCheck, "imu:": InertialCheck}


@dataclass(frozen=True, slots=True, eq=False)
class LiveSource:
    """One source that is open."""

    name: str
    source: DatagramSource | StreamSource
    check: Check


def is_live(name: str) -> bool:
    """Whether this names a live source, not a file."""
    return name.startswith(("lidar:", "scanner:", *CHECKS))


def open_source(name: str) -> LiveSource:
    """SourceNameError for a name of no form, or a source that cannot be opened."""
    try:
        match name.split(":"):
            case ["lidar", "udp", port] if port.isdigit():
                return LiveSource(name, DatagramSource(int(port)), PacketCheck())
            case ["scanner", "tcp", _, _]:
                return _scanner(name, address_of(name, name.partition(":")[2]))
            case ["gnss" | "imu" as kind, *_]:
                address = address_of(name, name.partition(":")[2])
                return LiveSource(name, _opened(address), CHECKS[f"{kind}:"]())
    except AddressError as error:
        raise SourceNameError(str(error)) from error
    except (ByteSourceError, ReceiverError) as error:
        raise SourceNameError(f"{name}: {error}") from error
    raise SourceNameError(f"{name} names no source; there are: {FORMS}")


def open_vehicle(path: Path) -> list[LiveSource]:
    """The sources of a vehicle's sensors.toml; SourceNameError. Its agent must not run: it has them open."""
    try:
        settings = load_sensors(path)
    except SensorsError as error:
        raise SourceNameError(str(error)) from error
    if settings is None:
        raise SourceNameError(f"{path} is no file")
    opened: list[LiveSource] = []
    try:
        for lidar in settings.lidars:
            check = PacketCheck(lidar.model)
            opened.append(LiveSource(lidar.name, DatagramSource(lidar.port), check))
        opened += [_scanner(name, address) for name, address in settings.scanners.items()]
        for name, address in settings.addresses.items():
            made = GnssCheck() if name in settings.file.receivers else InertialCheck()
            opened.append(LiveSource(name, _opened(address), made))
    except (ByteSourceError, ReceiverError) as error:
        for live in opened:
            live.source.close()
        raise SourceNameError(f"{path}: {error}; does the vehicle's agent run?") from error
    return opened


def _scanner(name: str, address: Address) -> LiveSource:
    """One that is asked for its turns. Raises ByteSourceError."""
    source = StreamSource.connected(address.host, address.port)
    try:
        source.write(START_TURNS)
    except ByteSourceError:
        source.close()
        raise
    return LiveSource(name, source, ScannerCheck())


def _opened(address: Address) -> DatagramSource | StreamSource:
    """Raises ByteSourceError."""
    if address.kind == "udp":
        return DatagramSource(address.port)
    if address.kind == "tcp":
        return StreamSource.connected(address.host, address.port)
    source = StreamSource.device(address.path)
    if address.baud:
        try:
            set_raw(source.fileno(), address.baud)
        except termios.error as error:
            source.close()
            raise ByteSourceError(f"{address.path} is no serial device ({error})") from error
    return source


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

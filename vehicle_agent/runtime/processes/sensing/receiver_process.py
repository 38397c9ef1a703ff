"""Receivers and inertial sensors of a real vehicle as a process: bytes in, fixes and samples to the tick.

A sensor whose stream ends or cannot be opened is opened again, and none waits for another.
"""

import asyncio
import ssl
from collections.abc import Callable, Sequence

import numpy as np
import structlog

from contract.geometry import Array
from vehicle_agent.device_feed import DatagramPort, DeviceValue, DeviceValues
from vehicle_agent.receivers.gnss_receiver import GnssReceiver
from vehicle_agent.receivers.mounting import Antenna, at_axle, imu_sample
from vehicle_agent.receivers.solutions import FixTracker, Solution
from vehicle_agent.receivers.vectornav import VectorNav
from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.sensors.ntrip import Caster, NtripRefused, NtripSession, gga_sentence
from vehicle_agent.runtime.sensors.sensors_file import InertialEntry, Place, SensorSettings
from vehicle_agent.runtime.sensors.streams import CONNECT_S, Stream, open_stream

log = structlog.get_logger()

OPEN_AGAIN_S = 1.0
# Casters ask for pauses between attempts, and block who does not make them.
CALL_AGAIN_S = 10.0
SILENT_S = 30.0
TELL_PLACE_EVERY_S = 10.0


class _Receiver:
    """Bytes of a GNSS receiver to fixes of the axle."""

    def __init__(self, place: Place) -> None:
        self._reader, self._antenna = GnssReceiver(), _antenna(place)

    @property
    def latest(self) -> Solution | None:
        return self._reader.latest

    def add(self, stamp_ns: int, data: bytes) -> list[DeviceValue]:
        return [at_axle(fix, self._antenna) for fix in self._reader.add(stamp_ns, data)]


class _Inertial:
    """Bytes of a VectorNav to samples, and to fixes if they are asked for."""

    def __init__(self, entry: InertialEntry) -> None:
        self._reader, self._fixes, self._antenna = VectorNav(), FixTracker(), _antenna(entry.place)
        self._turn: Array = np.ascontiguousarray(entry.place.transform()[:3, :3])
        self._gives_position = entry.gives == "samples and position"

    def add(self, stamp_ns: int, data: bytes) -> list[DeviceValue]:
        readings, solutions = self._reader.add(stamp_ns, data)
        found: list[DeviceValue] = [imu_sample(reading, self._turn) for reading in readings]
        if self._gives_position:
            fixes = [self._fixes.fix(stamp_ns, solution) for solution in solutions]
            found += [at_axle(fix, self._antenna) for fix in fixes if fix is not None]
        return found


class ReceiverProcess:
    """values_port: of the tick, on this computer."""

    def __init__(self, settings: SensorSettings, values_port: int, clock: Clock) -> None:
        """Raises ReceiverError without the parsers."""
        file = settings.file
        self._settings, self._values_port, self._clock = settings, values_port, clock
        self._port = DatagramPort()
        self._receivers = {name: _Receiver(entry.place) for name, entry in file.receivers.items()}
        self._inertial = {name: _Inertial(entry) for name, entry in file.inertial.items()}
        self._open: dict[str, Stream] = {}
        self._told_ns = 0

    async def run(self, stop: asyncio.Event) -> None:
        """Until `stop`."""
        sensors: dict[str, _Receiver | _Inertial] = {**self._receivers, **self._inertial}
        async with asyncio.TaskGroup() as group:
            tasks = [group.create_task(self._read(name, sensor.add)) for name, sensor in sensors.items()]
            if self._settings.caster is not None:
                tasks.append(group.create_task(self._correct(self._settings.caster)))
            await stop.wait()
            for task in tasks:
                task.cancel()
        self._port.close()

    async def _read(self, name: str, add: Callable[[int, bytes], Sequence[DeviceValue]]) -> None:
        """One sensor, for ever."""
        told = ""
        while True:
            try:
                stream = await open_stream(self._settings.addresses[name])
            except OSError as error:
                if str(error) != told:
                    log.warning("sensor.not_open", name=name, error=str(error))
                told = str(error)
                await asyncio.sleep(OPEN_AGAIN_S)
                continue
            log.info("sensor.open", name=name)
            told = ""
            self._open[name] = stream
            try:
                while data := await stream.read():
                    values = add(self._clock.now_ns(), data)
                    if values:
                        self._port.send(self._values_port, DeviceValues(tuple(values)))
                log.warning("sensor.ended", name=name)
            except OSError as error:
                log.warning("sensor.ended", name=name, error=str(error))
            finally:
                del self._open[name]
                stream.close()
            await asyncio.sleep(OPEN_AGAIN_S)

    async def _correct(self, caster: Caster) -> None:
        """Corrections to their receiver, for ever."""
        while True:
            try:
                await self._corrections_of(caster)
                log.warning("corrections.ended", caster=caster.host)
            except (OSError, NtripRefused) as error:
                log.warning("corrections.missing", caster=caster.host, error=str(error) or "it is silent")
            await asyncio.sleep(CALL_AGAIN_S)

    async def _corrections_of(self, caster: Caster) -> None:
        """One connection to the caster, until it ends."""
        file = self._settings.file.corrections
        assert file is not None
        tls = ssl.create_default_context() if caster.is_encrypted else None
        self._told_ns = 0
        async with asyncio.timeout(CONNECT_S):
            reader, writer = await asyncio.open_connection(caster.host, caster.port, ssl=tls)
        session, began, silent_s = NtripSession(caster), False, 0.0
        try:
            writer.write(session.request())
            while True:
                data = await _within(reader, TELL_PLACE_EVERY_S)
                if data == b"":
                    return
                silent_s = 0.0 if data else silent_s + TELL_PLACE_EVERY_S
                if silent_s >= SILENT_S:
                    raise TimeoutError
                corrections = session.add(data or b"")
                if session.has_begun and not began:
                    began = True
                    log.info("corrections.open", caster=caster.host, mountpoint=caster.mountpoint)
                if file.tell_place and began:
                    self._tell_place(writer, file.to)
                if corrections and (stream := self._open.get(file.to)) is not None:
                    await self._hand_over(stream, corrections)
        finally:
            writer.close()

    def _tell_place(self, writer: asyncio.StreamWriter, name: str) -> None:
        """At most every ten seconds."""
        solution, now_ns = self._receivers[name].latest, self._clock.now_ns()
        if solution is not None and now_ns - self._told_ns >= TELL_PLACE_EVERY_S * 1e9:
            self._told_ns = now_ns
            writer.write(gga_sentence(solution, now_ns + self._clock.utc_offset_ns()))

    async def _hand_over(self, stream: Stream, corrections: bytes) -> None:
        """The receiver's own task says when its stream ends."""
        try:
            async with asyncio.timeout(OPEN_AGAIN_S):
                await stream.write(corrections)
        except OSError as error:
            log.warning("corrections.not_taken", error=str(error) or "the receiver takes nothing")


async def _within(reader: asyncio.StreamReader, seconds: float) -> bytes | None:
    """The next bytes, b"" at the end, None if nothing came in this time."""
    try:
        async with asyncio.timeout(seconds):
            return await reader.read(4_096)
    except TimeoutError:
        return None


def _antenna(place: Place) -> Antenna:
    return Antenna(place.x_m, place.y_m, float(np.radians(place.yaw_deg)))

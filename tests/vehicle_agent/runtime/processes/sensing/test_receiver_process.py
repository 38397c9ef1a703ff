"""Receivers on real streams become fixes of the axle; each one that fails is opened again."""

import asyncio
import os
import pty
import socket
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from tests.vehicle_agent.receivers.test_gnss_receiver import epoch
from tests.vehicle_agent.receivers.vectornav_bytes import common
from vehicle_agent.device_feed import DatagramPort, DeviceValue, DeviceValues
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.sensing import receiver_process
from vehicle_agent.runtime.processes.sensing.receiver_process import ReceiverProcess
from vehicle_agent.runtime.sensors.sensors_file import load_sensors
from vehicle_agent.signals import GnssFix, ImuSample

HOST = "127.0.0.1"
RTCM = b"\xd3\x00\x13\x3e\xd7\xd3\x02\x02"
PLACE = "place = { x_m = 0.0, y_m = 0.0, z_m = 2.0 }\n"


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(receiver_process, "OPEN_AGAIN_S", 0.01)
    monkeypatch.setattr(receiver_process, "CALL_AGAIN_S", 0.01)


@asynccontextmanager
async def serving(folder: Path, sensors: str, tick: DatagramPort) -> AsyncIterator[ReceiverProcess]:
    (folder / "sensors.toml").write_text(sensors)
    settings = load_sensors(folder / "sensors.toml")
    assert settings is not None
    process, stop = ReceiverProcess(settings, tick.port, MONOTONIC), asyncio.Event()
    running = asyncio.create_task(process.run(stop))
    try:
        yield process
    finally:
        stop.set()
        await running


async def until(found: Callable[[], bool], within_s: float = 10.0) -> None:
    async with asyncio.timeout(within_s):
        while not found():  # noqa: ASYNC110  what is waited for happens in a kernel's socket
            await asyncio.sleep(0.005)


Serve = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


async def listening(serve: Serve) -> tuple[asyncio.Server, int]:
    server = await asyncio.start_server(serve, HOST, 0)
    port: int = server.sockets[0].getsockname()[1]
    return server, port


def test_a_receiver_that_hangs_up_is_called_again(tmp_path: Path) -> None:
    """And another one that nobody answers for holds it up in nothing."""

    async def run() -> list[DeviceValue]:
        calls = 0

        async def receiver(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            nonlocal calls
            calls += 1
            writer.write(epoch(2 * calls) + epoch(2 * calls + 1))
            await writer.drain()
            writer.close()

        server, port = await listening(receiver)
        with socket.socket() as closed:
            closed.bind((HOST, 0))
            nobody = closed.getsockname()[1]
        sensors = (
            f'[receivers.main]\nsource = "tcp:{HOST}:{port}"\n{PLACE}'
            f'[receivers.other]\nsource = "tcp:{HOST}:{nobody}"\n{PLACE}'
        )
        tick, found = DatagramPort(), []

        def has_enough() -> bool:
            found.extend(
                item for data in tick.take() if isinstance(data, DeviceValues) for item in data.items
            )
            return len(found) >= 6

        async with server, serving(tmp_path, sensors, tick):
            await until(has_enough)
        tick.close()
        return found

    fixes = asyncio.run(run())
    assert all(isinstance(fix, GnssFix) for fix in fixes)
    stamps = [fix.stamp_ns for fix in fixes]
    assert stamps == sorted(stamps)


def test_an_inertial_sensor_on_a_serial_line_gives_samples(tmp_path: Path) -> None:
    async def run() -> list[DeviceValue]:
        ours, theirs = pty.openpty()
        tick, found = DatagramPort(), []
        sensors = f'[inertial.vn]\nsource = "{os.ttyname(theirs)}"\nbaud = 921600\n{PLACE}'
        try:
            async with serving(tmp_path, sensors, tick):

                def has_enough() -> bool:
                    # Bytes that a line discipline would change or take for itself are in it.
                    os.write(ours, b"\r\n\x03\x11\x13" + common((0.5, 0.0, -9.80665), (0.0, 0.0, -0.25)))
                    found.extend(
                        item for data in tick.take() if isinstance(data, DeviceValues) for item in data.items
                    )
                    return len(found) >= 3

                await until(has_enough)
        finally:
            os.close(ours)
            os.close(theirs)
            tick.close()
        return found

    for sample in asyncio.run(run()):
        assert isinstance(sample, ImuSample)
        assert sample.accel_mps2 == pytest.approx(0.5)
        assert sample.yaw_rate_radps == pytest.approx(0.25)


def test_corrections_reach_the_receiver_and_the_caster_hears_where_it_is(tmp_path: Path) -> None:
    async def run() -> tuple[bytes, bytes]:
        taken, told, calls = b"", b"", 0

        async def receiver(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            nonlocal taken
            writer.write(epoch(1) + epoch(2))
            while data := await reader.read(100):
                taken += data
            writer.close()

        async def caster(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            nonlocal told, calls
            calls += 1
            request = await reader.readuntil(b"\r\n\r\n")
            assert request.startswith(b"GET /MOUNT HTTP/1.1")
            if calls == 1:
                writer.write(b"HTTP/1.1 503 Service Unavailable\r\n\r\n")
                writer.close()
                return
            writer.write(b"ICY 200 OK\r\n")
            for _ in range(1000):
                writer.write(RTCM)
                try:
                    async with asyncio.timeout(0.01):
                        told += await reader.read(200)
                except TimeoutError:
                    continue
                if reader.at_eof():
                    break
            writer.close()

        receiver_server, receiver_port = await listening(receiver)
        caster_server, caster_port = await listening(caster)
        sensors = (
            f'[receivers.main]\nsource = "tcp:{HOST}:{receiver_port}"\n{PLACE}'
            f'[corrections]\nurl = "http://{HOST}:{caster_port}/MOUNT"\nto = "main"\ntell_place = true\n'
        )
        tick = DatagramPort()
        async with receiver_server, caster_server, serving(tmp_path, sensors, tick):
            await until(lambda: len(taken) >= 2 * len(RTCM) and told.endswith(b"\r\n"))
        tick.close()
        return taken, told

    taken, told = asyncio.run(run())
    assert taken.startswith(RTCM + RTCM)
    assert told.startswith(b"$GPGGA,")
    assert b",3118.90000,N,12123.40000,E," in told

"""Planar scanners on real connections write their turns into rings; each one that fails is asked again."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import pytest
from structlog.testing import capture_logs

from tests.vehicle_agent.lidar.sick_telegrams import telegram
from vehicle_agent.config import PlanarScanner
from vehicle_agent.device_feed import ScanRing
from vehicle_agent.lidar.cola import START_TURNS, TelegramReader, turn_of
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.sensing import scanner_process
from vehicle_agent.runtime.processes.sensing.scanner_process import PlacedScanner, ScannerProcess
from vehicle_agent.runtime.sensors.addresses import Address

HOST = "127.0.0.1"
PARAMS = PlanarScanner(x_m=1.5, y_m=0.2, z_m=0.7, rate_hz=25.0)
TURN_NS = 20_000_000

Serve = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scanner_process, "OPEN_AGAIN_S", 0.01)
    monkeypatch.setattr(scanner_process, "SILENT_S", 0.2)


async def listening(serve: Serve) -> tuple[asyncio.Server, Address]:
    server = await asyncio.start_server(serve, HOST, 0)
    return server, Address("tcp", host=HOST, port=server.sockets[0].getsockname()[1])


@asynccontextmanager
async def serving(folder: Path, addresses: dict[str, Address]) -> AsyncIterator[dict[str, ScanRing]]:
    """The process on these scanners, and readers of its rings."""
    scanners = [PlacedScanner(name, PARAMS, folder / name) for name in addresses]
    stop = asyncio.Event()
    running = asyncio.create_task(ScannerProcess(scanners, addresses, MONOTONIC).run(stop))
    try:
        yield {name: ScanRing(folder / name, create=False) for name in addresses}
    finally:
        stop.set()
        await running


async def until(found: Callable[[], bool], within_s: float = 10.0) -> None:
    async with asyncio.timeout(within_s):
        while not found():  # noqa: ASYNC110  what is waited for is in a file
            await asyncio.sleep(0.005)


def _count(ring: ScanRing) -> int:
    newest = ring.newest()
    return 0 if newest is None else newest.number + 1


async def turns(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, count: int) -> None:
    """A scanner that is asked, answers, and turns."""
    assert await reader.readexactly(len(START_TURNS)) == START_TURNS
    writer.write(b"\x02sEA LMDscandata 1\x03")
    for number in range(count):
        writer.write(telegram([4_000] * 540 + [0], counter=number))
        await writer.drain()
        await asyncio.sleep(0.02)


def test_turns_lie_in_the_vehicles_frame_and_are_stamped_by_their_middle(tmp_path: Path) -> None:
    async def run() -> None:
        async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            await turns(reader, writer, 100)

        server, address = await listening(serve)
        async with server, serving(tmp_path, {"people_scanner": address}) as rings:
            ring = rings["people_scanner"]
            await until(lambda: ring.newest() is not None)
            ready = ring.newest()
            assert ready is not None
            rows = ring.read_rows(ready)
        assert rows is not None
        assert len(rows) == 540, "a beam without a return is no point"
        assert rows[270] == pytest.approx([5.5, 0.2, 0.7, 0.0, 0.0], abs=1e-5)
        assert rows[90, :2] == pytest.approx([1.5, 0.2 - 4.0], abs=1e-5), "a quarter turn to the right"
        assert rows[0, 4] == pytest.approx(-0.0075)
        age_ns = MONOTONIC.now_ns() - ready.stamp_ns
        assert 0.0125e9 < age_ns < 2e9, "sent 20 ms after its zero, 12.5 ms after its middle"

    asyncio.run(run())


def test_no_turn_is_stamped_after_it_came(tmp_path: Path) -> None:
    """Also of a scanner whose clock says that a turn of 15 ms took 1 ms."""
    scanner = PlacedScanner("planar_scanner", PARAMS, tmp_path / "ring")
    turn = turn_of(TelegramReader().add(telegram([4_000] * 541, age_us=1_000))[0])
    assert turn is not None
    scanner.take(10**12, turn)
    newest = ScanRing(tmp_path / "ring", create=False).newest()
    assert newest is not None
    assert newest.stamp_ns == 10**12


@pytest.mark.parametrize(("rate_hz", "expected"), [(50.0, 200), (25.0, 100), (10.0, 40)])
def test_a_scanner_that_turns_oftener_than_the_profile_says_is_thinned(
    tmp_path: Path, rate_hz: float, expected: int
) -> None:
    scanner = PlacedScanner("planar_scanner", PlanarScanner(rate_hz=rate_hz), tmp_path / "ring")
    ring, rng = ScanRing(tmp_path / "ring", create=False), np.random.default_rng(3)
    stamps: set[int] = set()
    for number in range(200):
        turn = turn_of(TelegramReader().add(telegram([4_000] * 541, counter=number))[0])
        assert turn is not None
        # A network delivers a little early and late.
        scanner.take(10**12 + number * TURN_NS + int(rng.integers(0, 3_000_000)), turn)
        newest = ring.newest()
        assert newest is not None
        stamps.add(newest.stamp_ns)
    assert len(stamps) == pytest.approx(expected, abs=1)


def test_one_that_ends_is_asked_again_and_one_that_is_away_holds_up_no_other(tmp_path: Path) -> None:
    async def run() -> None:
        served = 0

        async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            nonlocal served
            served += 1
            await turns(reader, writer, 3)
            writer.close()

        server, address = await listening(serve)
        away = Address("tcp", host=HOST, port=9)
        addresses = {"planar_scanner": away, "people_scanner": address}
        async with server, serving(tmp_path, addresses) as rings:
            await until(lambda: served >= 3)
            assert rings["people_scanner"].newest() is not None
            assert rings["planar_scanner"].newest() is None

    with capture_logs() as logs:
        asyncio.run(run())
    away = [line for line in logs if line["event"] == "sensor.not_open" and line["name"] == "planar_scanner"]
    assert len(away) == 1, "the same is told once"
    ended = [line["error"] for line in logs if line["event"] == "sensor.not_open"]
    assert "it has ended the connection" in ended
    assert sum(line["event"] == "sensor.open" for line in logs) >= 2


@pytest.mark.parametrize(
    ("sent", "said"),
    [
        (b"", "it is silent"),
        (b"\x02sEA LMDscandata 1\x03" * 3, "it is silent"),
        (b"\x02sFA 3\x03", "sFA 3"),
    ],
)
def test_one_that_sends_no_turns_is_left_and_asked_again(tmp_path: Path, sent: bytes, said: str) -> None:
    async def run() -> None:
        served = 0

        async def serve(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            nonlocal served
            served += 1
            for _ in range(40):
                writer.write(sent)
                await asyncio.sleep(0.02)

        server, address = await listening(serve)
        async with server, serving(tmp_path, {"people_scanner": address}):
            await until(lambda: served >= 2)

    with capture_logs() as logs:
        asyncio.run(run())
    assert [line["error"] for line in logs if line["event"] == "sensor.not_open"] == [said]


def test_broken_telegrams_and_a_dirty_window_are_told_and_turns_go_on(tmp_path: Path) -> None:
    async def run() -> None:
        async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            await reader.readexactly(len(START_TURNS))
            for number in range(60):
                writer.write(b"\x02sSN LMDscandata 1 1 X\x03noise")
                writer.write(telegram([4_000] * 271, start_deg=0.0, status=2, counter=number))
                await asyncio.sleep(0.02)

        server, address = await listening(serve)
        async with server, serving(tmp_path, {"people_scanner": address}) as rings:
            await until(lambda: _count(rings["people_scanner"]) >= 5)

    with capture_logs() as logs:
        asyncio.run(run())
    by_event = {line["event"]: line for line in logs}
    assert by_event["scanner.refused_telegrams"]["cut_short"] >= 1
    assert by_event["scanner.not_well"]["says"] == "pollution warning"
    assert by_event["scanner.other_angles"]["field_rad"] == pytest.approx(np.radians(135.0), abs=1e-3)
    assert sum(line["event"] == "scanner.not_well" for line in logs) == 1

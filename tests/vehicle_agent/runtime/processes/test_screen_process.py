"""The onboard screen's server: who gets in, what passes to the tick, and what a screen is told."""

import asyncio
import itertools
import json
from collections.abc import Awaitable, Callable
from pathlib import Path

import httpx
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from contract.wire.messages import CodeRefused
from tests.vehicle_agent.onboard.cabin_views import a_cabin_view
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.mailbox import CabinUpdate, Deliveries, Mailbox, MapAnswer
from vehicle_agent.runtime.processes.screen_process import CLIENTS_MAX, ScreenProcess
from vehicle_agent.runtime.screen.screen_pages import ScreenFile
from vehicle_agent.runtime.screen.screen_requests import CODES_MAX
from vehicle_agent.runtime.screen.screen_settings import ScreenSettings
from vehicle_agent.signals import CodeTyped, SeatButton

PAGE = "/onboard/s1"


class Screen:
    """A running screen process; `tick` is the mailbox that it delivers to."""

    def __init__(self, folder: Path, port: int) -> None:
        self.origin = f"http://127.0.0.1:{port}"
        self.live = f"ws://127.0.0.1:{port}{PAGE}/live"
        self.tick = Mailbox(folder / "tick")
        self.port = port
        self._box = Mailbox(folder / "sender")
        self._folder = folder

    def post(self, update: CabinUpdate | MapAnswer) -> None:
        assert self._box.post(self._folder / "screen", update)

    def connect(self, origin: str | None = None):  # type: ignore[no-untyped-def]
        return connect(self.live, origin=origin or self.origin)  # type: ignore[arg-type]

    async def delivered(self) -> list[object]:
        for _ in range(100):
            mail = [one for one in self.tick.take() if isinstance(one, Deliveries)]
            found: list[object] = [item.body for one in mail for item in one.items]
            if found:
                return found
            await asyncio.sleep(0.01)
        return []

    def close(self) -> None:
        self.tick.close()
        self._box.close()


def with_screen(tmp_path: Path, port: int, work: Callable[[Screen], Awaitable[None]]) -> None:
    async def run() -> None:
        screen = Screen(tmp_path, port)
        reads = itertools.count(1)

        def read_files() -> dict[str, ScreenFile]:
            body = f"<!doctype html>{next(reads)}".encode()
            return {PAGE: ScreenFile(body, "text/html; charset=utf-8", "no-cache")}

        settings = ScreenSettings(listen=f"127.0.0.1:{port}")
        process = ScreenProcess(tmp_path, "s1", 6, settings, read_files, MONOTONIC.open("screen"))
        stop = asyncio.Event()
        running = asyncio.create_task(process.run(stop))
        try:
            await asyncio.sleep(0.1)
            await work(screen)
        finally:
            stop.set()
            await running
            screen.close()

    asyncio.run(run())


async def next_scene(socket, where: Callable[[dict], bool]) -> dict:  # type: ignore[no-untyped-def, type-arg]
    async with asyncio.timeout(5):
        while True:
            message = json.loads(await socket.recv())
            if where(message):
                return message


def test_pages_have_headers_that_let_nothing_else_in(tmp_path: Path, unused_port: int) -> None:
    async def work(screen: Screen) -> None:
        async with httpx.AsyncClient(base_url=screen.origin, timeout=30.0) as http:
            page = await http.get(PAGE)
            assert page.status_code == 200
            assert "default-src 'self'" in page.headers["Content-Security-Policy"]
            assert page.headers["X-Frame-Options"] == "DENY"
            assert (await http.get("/")).headers["Location"] == PAGE
            assert (await http.get("/onboard/other")).status_code == 404
            assert (await http.get("/../../etc/passwd")).status_code == 404

    with_screen(tmp_path, unused_port, work)


def test_a_name_that_points_here_and_another_sites_page_are_refused(tmp_path: Path, unused_port: int) -> None:
    async def work(screen: Screen) -> None:
        async with httpx.AsyncClient(base_url=screen.origin, timeout=30.0) as http:
            assert (await http.get(PAGE, headers={"Host": "evil.example"})).status_code == 421
        with pytest.raises(InvalidStatus, match="403"):
            async with screen.connect(origin="http://evil.example"):
                pass

    with_screen(tmp_path, unused_port, work)


def test_a_stranger_to_the_vehicles_network_is_refused(
    tmp_path: Path, unused_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ScreenSettings, "allowed", lambda _: ())

    async def work(screen: Screen) -> None:
        async with httpx.AsyncClient(base_url=screen.origin, timeout=30.0) as http:
            assert (await http.get(PAGE)).status_code == 403

    with_screen(tmp_path, unused_port, work)


def test_a_touch_reaches_the_ticks_inbox_like_a_button(tmp_path: Path, unused_port: int) -> None:
    async def work(screen: Screen) -> None:
        async with screen.connect() as socket:
            await socket.send('{"type":"stop","seat":2}')
            (press,) = await screen.delivered()
            assert isinstance(press, SeatButton)
            assert press.seat == 2
            await socket.send("no request at all")
            await socket.send('{"type":"code","code":"1234"}')
            (code,) = await screen.delivered()
            assert isinstance(code, CodeTyped)
            assert code.code == "1234"

    with_screen(tmp_path, unused_port, work)


def test_guesses_of_codes_are_refused_and_the_screen_is_told(tmp_path: Path, unused_port: int) -> None:
    async def work(screen: Screen) -> None:
        async with screen.connect() as socket:
            for number in range(CODES_MAX + 1):
                await socket.send(f'{{"type":"code","code":"{number:04d}"}}')
            assert await next_scene(socket, lambda message: "refused" in message) == {"refused": "too_many"}

    with_screen(tmp_path, unused_port, work)


def test_a_screen_gets_each_view_and_what_was_said_of_late(tmp_path: Path, unused_port: int) -> None:
    async def work(screen: Screen) -> None:
        async with screen.connect() as socket:
            first = await next_scene(socket, lambda _: True)
            assert (first["vehicle_id"], first["seats"], first["view"]) == ("s1", 6, None)
            screen.post(CabinUpdate(a_cabin_view(announce="Hello.", answers=(CodeRefused("v"),))))
            scene = await next_scene(socket, lambda message: message.get("view") is not None)
            assert scene["announcements"][0]["text"] == "Hello."
            assert scene["answers"][0]["body"]["event"] == "code_refused"
            assert scene["view_age_s"] < 1.0

    with_screen(tmp_path, unused_port, work)


def test_screens_are_bounded(tmp_path: Path, unused_port: int) -> None:
    async def work(screen: Screen) -> None:
        sockets = [await screen.connect() for _ in range(CLIENTS_MAX)]
        await asyncio.sleep(0.05)
        with pytest.raises(InvalidStatus, match="503"):
            await screen.connect()
        for socket in sockets:
            await socket.close()
        await asyncio.sleep(0.1)
        async with screen.connect() as socket:
            assert await next_scene(socket, lambda _: True)

    with_screen(tmp_path, unused_port, work)


@pytest.fixture
def unused_port() -> int:
    import socket

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def test_when_the_vehicle_drives_by_another_map_screens_are_sent_to_fetch_it(
    tmp_path: Path, unused_port: int
) -> None:
    async def work(screen: Screen) -> None:
        async with (
            httpx.AsyncClient(base_url=screen.origin, timeout=30.0) as http,
            screen.connect() as socket,
        ):
            assert (await http.get(PAGE)).text.endswith("1")
            screen.post(MapAnswer("refused", "off_the_lanes"))
            screen.post(MapAnswer("another"))
            async with asyncio.timeout(5):
                await socket.wait_closed()
            assert socket.close_code == 1012
            assert (await http.get(PAGE)).text.endswith("2")

    with_screen(tmp_path, unused_port, work)

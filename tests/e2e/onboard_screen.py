"""The agent's own screen process with the shipped campus, in a thread; the test is the tick."""

import asyncio
import socket
import threading
import time
from pathlib import Path

from contract.roads.load import load_map
from tests.e2e.server_process import CAMPUS_MAP, ROOT, free_port
from vehicle_agent.onboard.cabin_view import CabinView
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.mailbox import CabinUpdate, Deliveries, Mailbox
from vehicle_agent.runtime.processes.screen_process import ScreenProcess
from vehicle_agent.runtime.screen.screen_map import encode_screen_map
from vehicle_agent.runtime.screen.screen_pages import read_screen_files
from vehicle_agent.runtime.screen.screen_settings import ScreenSettings

VEHICLE, SEATS = "shuttle-1", 6
VIEW_EVERY_S = 0.2


class OnboardScreen:
    """`with OnboardScreen(folder) as screen`. view: what the tick says, at 5 Hz; None: nothing."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._port = free_port()
        self.url = f"http://127.0.0.1:{self._port}/onboard/{VEHICLE}"
        self.view: CabinView | None = None
        self._tick = Mailbox(folder / "tick")
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> "OnboardScreen":
        self._thread.start()
        deadline_s = time.monotonic() + 10
        while time.monotonic() < deadline_s:
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", self._port)) == 0:
                    return self
            time.sleep(0.05)
        raise AssertionError("the screen process does not listen")

    def __exit__(self, *_: object) -> None:
        self._loop.call_soon_threadsafe(self._stop.set)
        self._thread.join(10)
        self._loop.close()
        self._tick.close()

    def say_once(self, view: CabinView) -> None:
        """One more view, as in a tick that passengers must learn of."""
        asyncio.run_coroutine_threadsafe(self._post(view), self._loop).result(5)

    def touched(self) -> list[object]:
        """What reached the tick's inbox since the last call; waits for the first for up to 5 s."""
        deadline_s = time.monotonic() + 5
        while time.monotonic() < deadline_s:
            mail = [one for one in self._tick.take() if isinstance(one, Deliveries)]
            if mail:
                return [item.body for one in mail for item in one.items]
            time.sleep(0.05)
        return []

    def _run(self) -> None:
        self._loop.run_until_complete(self._serve())

    async def _serve(self) -> None:
        settings = ScreenSettings(listen=f"127.0.0.1:{self._port}")
        files = read_screen_files(ROOT / "web" / "dist", VEHICLE, encode_screen_map(load_map(CAMPUS_MAP)))
        clock = MONOTONIC.open("screen")
        process = ScreenProcess(self._folder, VEHICLE, SEATS, settings, lambda: files, clock)
        self._sender = Mailbox(self._folder / "sender")
        self._stop = asyncio.Event()
        views = asyncio.create_task(self._report())
        await process.run(self._stop)
        views.cancel()
        self._sender.close()

    async def _report(self) -> None:
        while True:
            if self.view is not None:
                await self._post(self.view)
            await asyncio.sleep(VIEW_EVERY_S)

    async def _post(self, view: CabinView) -> None:
        self._sender.post(self._folder / "screen", CabinUpdate(view))

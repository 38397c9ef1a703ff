"""The agent's process as its supervisor runs it: started again, with a new boot, when it has ended."""

import asyncio
import base64
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import msgspec

from benchmarks.faults.agent import DurableEvent
from benchmarks.faults.installation import MAP, Installation
from vehicle_agent.link.keys import load_or_create_key

RESTART_AFTER_S = 0.3


class AgentProcess:
    """boots: how often it was started. events: how many it has noted as on disk since this program began."""

    def __init__(
        self, installation: Installation, vehicle_id: str, resting_place: int, port: int | None
    ) -> None:
        """port: None for the server's own"""
        self._port = port or installation.port
        self.folder = installation.folder / vehicle_id
        self.folder.mkdir()
        self.vehicle_id = vehicle_id
        self.boots = self.events = 0
        self._installation, self._resting_place = installation, resting_place
        self._process: asyncio.subprocess.Process | None = None

    async def enrol(self) -> None:
        key = load_or_create_key(self.folder / "key.pem")
        public = base64.b64encode(key.public_key().public_bytes_raw()).decode()
        await self._installation.enrol(self.vehicle_id, public)

    async def keep_running(self) -> None:
        while True:
            self.boots += 1
            place, url = str(self._resting_place), f"ws://127.0.0.1:{self._port}"
            command = [sys.executable, "-m", "benchmarks.faults.agent", str(self.folder), url]
            with (self.folder / "agent.log").open("ab") as journal:
                self._process = await asyncio.create_subprocess_exec(
                    *command,
                    self.vehicle_id,
                    f"boot-{self.boots}",
                    str(MAP),
                    place,
                    stdout=asyncio.subprocess.PIPE,
                    stderr=journal,
                )
            assert self._process.stdout is not None
            async for _ in self._process.stdout:
                self.events += 1
            await self._process.wait()
            await asyncio.sleep(RESTART_AFTER_S)

    @property
    def pid(self) -> int:
        assert self._process is not None
        return self._process.pid

    def kill(self) -> None:
        if self._process is not None and self._process.returncode is None:
            self._process.kill()

    def promised(self) -> dict[tuple[str, str], dict[int, str]]:
        """Events that the server must store."""
        return {(self.vehicle_id, boot_id): events for boot_id, events in self.durable().items()}

    def durable(self) -> dict[str, dict[int, str]]:
        """Events on the vehicle's disk: by boot, then number. The last line may be cut by a kill."""
        found: dict[str, dict[int, str]] = {}
        noted = self.folder / "durable.jsonl"
        for line in (noted.read_bytes() if noted.exists() else b"").split(b"\n")[:-1]:
            event = msgspec.json.decode(line, type=DurableEvent)
            found.setdefault(event.boot_id, {})[event.sequence] = event.body
        return found


@asynccontextmanager
async def an_agent(
    installation: Installation, vehicle_id: str, resting_place: int, port: int | None = None
) -> AsyncIterator[AgentProcess]:
    agent = AgentProcess(installation, vehicle_id, resting_place, port)
    await agent.enrol()
    running = asyncio.create_task(agent.keep_running())
    try:
        yield agent
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        agent.kill()

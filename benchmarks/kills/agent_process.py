"""The agent's process as its supervisor runs it: started again, with a new boot, when it has ended."""

import asyncio
import base64
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import msgspec

from benchmarks.faults.installation import MAP, Installation
from benchmarks.kills.agent import DurableEvent
from vehicle_agent.link.keys import load_or_create_key

RESTART_AFTER_S = 0.3


class AgentProcess:
    """boots: how often it was started. events: how many it has noted as on disk since this program began."""

    def __init__(self, installation: Installation, vehicle_id: str, resting_place: int) -> None:
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
            place, url = str(self._resting_place), self._installation.websocket("")
            command = [sys.executable, "-m", "benchmarks.kills.agent", str(self.folder), url]
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

    def kill(self) -> None:
        if self._process is not None and self._process.returncode is None:
            self._process.kill()

    def durable(self) -> dict[str, dict[int, str]]:
        """Events on the vehicle's disk: by boot, then number. The last line may be cut by a kill."""
        found: dict[str, dict[int, str]] = {}
        for line in (self.folder / "durable.jsonl").read_bytes().split(b"\n")[:-1]:
            event = msgspec.json.decode(line, type=DurableEvent)
            found.setdefault(event.boot_id, {})[event.sequence] = event.body
        return found


@asynccontextmanager
async def an_agent(
    installation: Installation, vehicle_id: str, resting_place: int
) -> AsyncIterator[AgentProcess]:
    agent = AgentProcess(installation, vehicle_id, resting_place)
    await agent.enrol()
    running = asyncio.create_task(agent.keep_running())
    try:
        yield agent
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        agent.kill()

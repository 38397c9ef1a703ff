"""Faults on board: the link's process and its disk. What the vehicle has on disk must reach the server."""

import asyncio
import resource

from benchmarks.faults.agent_process import an_agent
from benchmarks.faults.stage import Stage

_FULL_S = 4.0


async def agent_killed(stage: Stage) -> None:
    """SIGKILL three times, at moments that a seed draws; each start is a new boot."""
    async with an_agent(stage.installation, "shuttle-3", 2) as agent:
        stage.agents.append(agent)
        for _ in range(3):
            await _until_reporting(stage, agent.boots)
            await asyncio.sleep(stage.rng.uniform(0.2, 1.5))
            agent.kill()
        await stage.until_stored(agent)


async def disk_full_on_board(stage: Stage) -> None:
    """The operating system refuses every byte of the link; after its end it starts on a disk with room."""
    async with an_agent(stage.installation, "shuttle-3", 2) as agent:
        stage.agents.append(agent)
        await _until_reporting(stage, 1)
        _, hard = resource.prlimit(agent.pid, resource.RLIMIT_FSIZE)
        resource.prlimit(agent.pid, resource.RLIMIT_FSIZE, (0, hard))
        await asyncio.sleep(_FULL_S)
        await _until_reporting(stage, 2)
        await stage.until_stored(agent)


async def power_cut_on_board(stage: Stage) -> None:
    """The power fails while the outbox is written: its last line is cut."""
    async with an_agent(stage.installation, "shuttle-3", 2) as agent:
        stage.agents.append(agent)
        await _until_reporting(stage, 1)
        agent.kill()
        with (agent.folder / "events.jsonl").open("ab") as outbox:
            outbox.write(b'{"boot_id":"boot-1","sequence":')
        await _until_reporting(stage, 2)
        await stage.until_stored(agent)


async def server_killed_with_a_backlog(stage: Stage) -> None:
    """The server is killed while the agent's events wait for their acknowledgements."""
    async with an_agent(stage.installation, "shuttle-3", 2) as agent:
        stage.agents.append(agent)
        await _until_reporting(stage, 1)
        for _ in range(2):
            stage.installation.kill()
            await asyncio.sleep(2.0)
            await stage.installation.until_ready()
        await stage.until_stored(agent)


async def _until_reporting(stage: Stage, boots: int) -> None:
    """Until the agent's boot of that number has events on its disk."""
    agent = stage.agents[-1]

    async def is_reporting() -> bool:
        return len(agent.durable()) >= boots

    await stage.until(is_reporting, f"boot {boots} of the agent reports", 40.0)

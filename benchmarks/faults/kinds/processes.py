"""Processes that are killed or stopped."""

import asyncio
import resource
import signal
from collections.abc import Awaitable, Callable

import psutil

from benchmarks.faults.stage import Stage, require


async def server_killed(stage: Stage) -> None:
    """SIGKILL three times, at moments that a seed draws."""
    for _ in range(3):
        await asyncio.sleep(stage.rng.uniform(0.5, 2.0))
        starts = stage.installation.starts
        stage.installation.kill()
        await stage.until(_started_again(stage, starts), "the server starts again")
        await stage.installation.until_ready()


async def server_stopped_for_a_while(stage: Stage) -> None:
    """SIGSTOP for 10 s: vehicles and clients run into their time limits."""
    stage.installation.kill(signal.SIGSTOP)
    await asyncio.sleep(10.0)
    stage.installation.kill(signal.SIGCONT)


async def server_stopped_for_long(stage: Stage) -> None:
    """SIGSTOP for 35 s: longer than the database waits for a transaction, and than a ping may take."""
    stage.installation.kill(signal.SIGSTOP)
    await asyncio.sleep(35.0)
    stage.installation.kill(signal.SIGCONT)


async def server_replaced_in_order(stage: Stage) -> None:
    """SIGTERM twice: vehicles hear that the server leaves, and are back after its restart."""
    for _ in range(2):
        await stage.installation.replace()
        for vehicle in (stage.first, stage.second):
            await vehicle.until_served()
    for vehicle in (stage.first, stage.second):
        said = vehicle.goodbyes.count("server_leaving")
        require(said == 2, f"{vehicle.vehicle_id} heard {vehicle.goodbyes}")


async def out_of_descriptors(stage: Stage) -> None:
    """For 10 s the server may open no further file or connection, and 40 clients try."""
    process = stage.installation.process
    soft, hard = resource.prlimit(process.pid, resource.RLIMIT_NOFILE)
    resource.prlimit(process.pid, resource.RLIMIT_NOFILE, (process.num_fds(), hard))
    opened: list[asyncio.StreamWriter] = []
    try:
        for _ in range(40):
            _, writer = await asyncio.open_connection("127.0.0.1", stage.installation.port)
            opened.append(writer)
        await asyncio.sleep(10.0)
        require(stage.installation.starts == 1, "the server ended")
    finally:
        resource.prlimit(process.pid, resource.RLIMIT_NOFILE, (soft, hard))
        for writer in opened:
            writer.close()


async def solver_killed(stage: Stage) -> None:
    """The child process that improves plans is killed twice."""
    for _ in range(2):

        async def has_child() -> bool:
            return bool(_solvers(stage))

        await stage.until(has_child, "a solver process", 60.0)
        for solver in _solvers(stage):
            solver.kill()
        await asyncio.sleep(8.0)
    require(stage.installation.starts == 1, "the server ended with its solver")


def _solvers(stage: Stage) -> list[psutil.Process]:
    children = stage.installation.process.children(recursive=True)
    return [child for child in children if "spawn_main" in " ".join(child.cmdline())]


def _started_again(stage: Stage, starts: int) -> Callable[[], Awaitable[bool]]:
    async def is_started() -> bool:
        return stage.installation.starts > starts

    return is_started

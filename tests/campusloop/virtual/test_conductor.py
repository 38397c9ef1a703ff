import asyncio
import os
import subprocess
import sys
from pathlib import Path

import pytest

from campusloop.virtual.conductor import Conductor
from campusloop.virtual.event_loop import VirtualTimeError

HOUR = Path(__file__).with_name("conducted_hour.py")


def run_hour(seed: int, hash_seed: str) -> str:
    environment = os.environ | {"PYTHONHASHSEED": hash_seed}
    done = subprocess.run(
        [sys.executable, "-m", "tests.campusloop.virtual.conducted_hour", str(seed), "3600"],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        cwd=HOUR.parents[3],
    )
    return done.stdout


def test_a_virtual_hour_repeats_bit_for_bit_in_another_process_with_another_hash_seed() -> None:
    first, second = run_hour(7, "1"), run_hour(7, "4242")
    assert first == second
    assert int(first.split('"events":"')[1].split(":")[0]) > 100


def test_another_seed_gives_another_hour() -> None:
    assert run_hour(7, "1") != run_hour(8, "1")


def test_equal_deadlines_fire_in_the_order_of_their_creation() -> None:
    conductor = Conductor(1)
    fired: list[int] = []
    for number in range(20):
        conductor.loop.call_later(0.1, fired.append, number)
    conductor.run_for(0.2)
    assert fired == list(range(20))


def test_time_stands_still_while_tasks_run_and_sleeps_end_on_their_step() -> None:
    conductor = Conductor(1)
    seen: list[int] = []

    async def sleeper() -> None:
        await asyncio.sleep(0.05)
        seen.append(conductor.loop.now_ns)
        async with asyncio.timeout(5):
            await asyncio.sleep(0.05)
        seen.append(conductor.loop.now_ns)

    conductor.loop.create_task(sleeper())
    conductor.run_for(1.0)
    assert seen == [
        80_000_000,
        140_000_000,
    ]  # begun in the first step, ended in the steps after 70 and 130 ms


def test_a_thread_asked_for_in_virtual_time_fails_the_run() -> None:
    conductor = Conductor(1)

    async def threaded() -> None:
        await asyncio.to_thread(print)

    conductor.loop.create_task(threaded())
    with pytest.raises(VirtualTimeError, match="executor"):
        conductor.run_for(0.1)


def test_an_exception_that_nobody_awaits_fails_the_run() -> None:
    conductor = Conductor(1)

    def broken() -> None:
        raise ValueError("broken callback")

    conductor.loop.call_later(0.01, broken)
    with pytest.raises(ValueError, match="broken callback"):
        conductor.run_for(0.1)

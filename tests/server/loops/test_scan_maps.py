"""The child process that makes maps of scans: a real one, stopped, crashed, and ended with its server."""

import asyncio
import sys
from pathlib import Path

import pytest

from contract.scan_parcels.proposals import COMPARISON, PICTURE
from server.loops.scan_maps import ProcessMapBuilder
from server.usecases.ports.scans import MapBuildRefused
from tests.workshop.scan_maps.street import walls, write_drive


@pytest.mark.long
def test_a_real_child_makes_a_map_and_tells_how_far_it_is(tmp_path: Path) -> None:
    write_drive(tmp_path / "parcels", walls(), step_m=1.0)
    told: list[tuple[str, int]] = []

    async def build() -> None:
        await ProcessMapBuilder().build(
            tmp_path / "parcels", None, tmp_path / "map", lambda stage, percent: told.append((stage, percent))
        )

    asyncio.run(build())
    assert (tmp_path / "map" / COMPARISON).exists()
    assert (tmp_path / "map" / PICTURE).exists()
    assert {"odometry", "surfaces", "comparison"} <= {stage for stage, _ in told}
    assert told[-1] == ("comparison", 100)


@pytest.mark.long
def test_a_real_child_says_why_it_makes_none(tmp_path: Path) -> None:
    (tmp_path / "parcels").mkdir()
    with pytest.raises(MapBuildRefused, match="There is no parcel of scans"):
        asyncio.run(ProcessMapBuilder().build(tmp_path / "parcels", None, tmp_path / "map", _nothing))
    assert not (tmp_path / "map").exists()


def _nothing(_stage: str, _percent: int) -> None:
    return


def program(tmp_path: Path, text: str) -> ProcessMapBuilder:
    path = tmp_path / "program.py"
    path.write_text(text)
    return ProcessMapBuilder((sys.executable, str(path)))


def test_a_child_that_crashes_is_named_with_its_last_line(tmp_path: Path) -> None:
    builder = program(tmp_path, "print('not json'); raise ValueError('no memory')")
    with pytest.raises(MapBuildRefused, match="ended with code 1: ValueError: no memory"):
        asyncio.run(builder.build(tmp_path, None, tmp_path / "map", _nothing))


def test_a_child_that_ends_early_without_a_word_has_failed(tmp_path: Path) -> None:
    with pytest.raises(MapBuildRefused, match="ended with code 0"):
        asyncio.run(program(tmp_path, "pass").build(tmp_path, None, tmp_path / "map", _nothing))


def test_a_child_whose_output_cannot_be_read_has_failed_and_is_killed(tmp_path: Path) -> None:
    text = f"""
import os, pathlib, time
pathlib.Path({str(tmp_path / "pid")!r}).write_text(str(os.getpid()))
print("x" * 200_000, flush=True)
time.sleep(60)
"""
    with pytest.raises(MapBuildRefused, match="cannot be read"):
        asyncio.run(program(tmp_path, text).build(tmp_path, None, tmp_path / "map", _nothing))
    assert not Path(f"/proc/{(tmp_path / 'pid').read_text()}").exists()


def test_a_cancelled_child_is_killed(tmp_path: Path) -> None:
    text = f"""
import json, os, pathlib, time
pathlib.Path({str(tmp_path / "pid")!r}).write_text(str(os.getpid()))
print(json.dumps({{"stage": "odometry", "percent": 1}}), flush=True)
time.sleep(60)
"""

    async def stop() -> None:
        told = asyncio.Event()
        builder = program(tmp_path, text)
        work = asyncio.ensure_future(
            builder.build(tmp_path, None, tmp_path / "map", lambda _stage, _percent: told.set())
        )
        async with asyncio.timeout(20.0):
            await told.wait()
        work.cancel()
        await asyncio.gather(work, return_exceptions=True)

    asyncio.run(stop())
    pid = int((tmp_path / "pid").read_text())
    # Waited for, so that nothing of it is left.
    assert not Path(f"/proc/{pid}").exists()

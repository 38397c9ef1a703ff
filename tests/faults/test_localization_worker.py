"""The localization worker hangs, and is killed: it is told, and scans are compared again after it."""

import asyncio
import os
import signal
import time
from pathlib import Path
from typing import Any

import pytest

from campusloop.live.campus import LiveCampus, LiveOptions
from campusloop.shipped import PROFILES
from contract.roads.load import load_map
from simulator.start_places import start_poses
from tests.faults.real_campus import free_port
from tests.scenarios.wall_map import write_wall_map
from tests.server.feeds.roads.shipped import CAMPUS_MAP

pytestmark = pytest.mark.faults

WORKER = "localization shuttle-1"
WITHIN_S = 120.0


async def until(campus: LiveCampus, phase: str) -> dict[str, Any]:
    """The status once the shuttle says that localization is in this phase."""
    deadline_s = time.monotonic() + WITHIN_S
    while True:
        status = (await campus.operator.vehicle("shuttle-1"))["status"]
        if status is not None and (status["localization"] or {}).get("phase") == phase:
            return dict(status)
        assert time.monotonic() < deadline_s, f"{phase} was not reached: {status}"
        campus._shuttles.restart_ended()
        await asyncio.sleep(0.2)


def test_a_worker_that_hangs_or_is_killed_is_told_and_comes_back(tmp_path: Path) -> None:
    road_map = load_map(CAMPUS_MAP)
    start = start_poses(road_map, ("shuttle-1",))["shuttle-1"]
    write_wall_map(tmp_path / "map", road_map, start.x_m, start.y_m)
    options = LiveOptions(
        CAMPUS_MAP,
        tmp_path / "campus",
        1,
        port=free_port(),
        base_port=48_700,
        pedestrians=False,
        profile_path=PROFILES / "snow-lion.toml",
        point_map=tmp_path / "map",
    )

    async def scenario() -> None:
        campus = LiveCampus(options)
        try:
            await campus.start()
            status = await until(campus, "tracking")
            assert status["localization"]["agreement"] > 0.8
            os.kill(campus.pids[WORKER], signal.SIGSTOP)
            status = await until(campus, "gnss_only")
            assert "localization_silent" in {fault["code"] for fault in status["faults"]}
            os.kill(campus.pids[WORKER], signal.SIGCONT)
            await until(campus, "tracking")
            killed = campus.pids[WORKER]
            os.kill(killed, signal.SIGKILL)
            deadline_s = time.monotonic() + WITHIN_S
            while campus.pids.get(WORKER, killed) == killed:
                assert time.monotonic() < deadline_s, "the worker is not started again"
                campus._shuttles.restart_ended()
                await asyncio.sleep(0.1)
            # Whether the pause was long enough to be told depends on the machine; that it ends does not.
            await asyncio.sleep(4.0)
            status = await until(campus, "tracking")
            assert "localization_silent" not in {fault["code"] for fault in status["faults"]}
        finally:
            await campus.stop()

    asyncio.run(scenario())

"""A map is published while a shuttle carries a rider: it changes over by itself, and rides go on."""

import asyncio
from pathlib import Path
from typing import Any

import msgspec
import pytest

from contract.roads.model import RoadMap
from contract.runlog.reader import open_segment
from server.feeds.roads.workshop import RoadMapWorkshop
from tests.contract.roads.ring_map import ring_map
from tests.faults.real_campus import RealCampus, a_real_campus
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.stacks.choice import build_car

# `make soak-maps`: CI has no room for its minutes.
pytestmark = pytest.mark.faults
API = "/api/v1"
# A machine that does other work as well makes the gate brake now and then, and the operator resume.
WITHIN_S = 420.0


def drawn_ring() -> RoadMap:
    """With the sections that the editor derives: what it publishes differs by the edit alone."""
    return RoadMapWorkshop().completed(msgspec.structs.replace(ring_map(), sections=(), map_version=""))


async def published(real: RealCampus, name: str) -> str:
    """An operator renames the first stop and publishes. Returns the new version."""
    client, headers = real.campus.client, real.campus.operator.headers
    made = await client.post(f"{API}/maps/drafts", json={"name": name}, headers=headers)
    draft: dict[str, Any] = made.raise_for_status().json()
    path = f"{API}/maps/drafts/{draft['draft_id']}"
    stop = (await client.get(path)).json()["elements"]["stops"][0]
    revision = {"If-Match": str(draft["revision"])}
    body = {"put": {"stops": [stop | {"name": name}]}}
    changed = (await client.patch(path, json=body, headers=headers | revision)).raise_for_status().json()
    revision = {"If-Match": str(changed["revision"])}
    answer = await client.post(f"{path}/publications", headers=headers | revision)
    assert answer.status_code == 201, answer.text
    version: str = answer.json()["map_version"]
    return version


async def drives_by(real: RealCampus, version: str) -> None:
    for _ in range(240):
        if (await real.campus.operator.vehicle("shuttle-1"))["map_version"] == version:
            return
        await asyncio.sleep(0.5)
    raise AssertionError(f"the shuttle does not change over to {version}: {real.states} {real.logs()}")


def test_a_shuttle_changes_over_in_the_middle_of_a_ride_and_back_again(tmp_path: Path) -> None:
    async def scenario() -> None:
        async with a_real_campus(tmp_path, 45_700, drawn_ring()) as real:
            first = (await real.campus.operator.vehicle("shuttle-1"))["map_version"]
            journey = real.request_ride()
            await real.until_state(journey, "aboard")
            version = await published(real, "New name")
            await drives_by(real, version)
            await real.until_state(journey, "completed", WITHIN_S)
            headers = real.campus.operator.headers
            back = await real.campus.client.post(f"{API}/maps/{first}/activations", headers=headers)
            assert back.status_code == 200, back.text
            await drives_by(real, first)
            again = real.request_ride()
            await real.until_state(again, "completed", WITHIN_S)
        segments = sorted((tmp_path / "campus" / "vehicles").rglob("*.mcap"))
        assert {open_segment(path).header.map_version for path in segments} == {first, version}
        for segment in segments:
            assert replay_segment(segment, build_car).difference is None

    asyncio.run(scenario())

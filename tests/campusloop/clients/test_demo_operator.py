"""Which stopped shuttles the demo's operator releases, and which incidents it leaves to people."""

import asyncio
from typing import Any

import pytest

from campusloop.clients.demo_operator import DemoOperator


def incident(number: int = 1, **changes: Any) -> dict[str, Any]:
    return {
        "incident_id": f"incident-{number}",
        "kind": "minimal_risk_stop",
        "vehicle_id": f"shuttle-{number}",
        "cause": "bywire_lost, can_speed_report_lost, motion_stale",
        "acknowledged_at": None,
        "closed_at": None,
    } | changes


class FakeOperator:
    def __init__(self, incidents: list[dict[str, Any]]) -> None:
        self.open = incidents
        self.released: list[str] = []

    async def incidents(self) -> list[dict[str, Any]]:
        return self.open

    async def release(self, vehicle_id: str) -> None:
        self.released.append(vehicle_id)
        self.open = [i for i in self.open if i["vehicle_id"] != vehicle_id]


def polled(client: FakeOperator, times: int) -> list[str]:
    reported: list[str] = []
    operator = DemoOperator(client, reported.append, reported.append)
    for _ in range(times):
        asyncio.run(operator.poll())
    return reported


def test_a_shuttle_that_a_busy_machine_stopped_is_released_and_counted_once() -> None:
    client = FakeOperator([incident(1), incident(2, cause="motion_stale, bywire_refuses_enable")])
    reported = polled(client, 4)
    assert client.released == ["shuttle-1", "shuttle-2"]
    assert reported == ["shuttle-1", "shuttle-2"]


def test_it_is_given_a_moment_first() -> None:
    client = FakeOperator([incident()])
    polled(client, 1)
    assert client.released == []


class UnresponsiveVehicle(FakeOperator):
    """shuttle-1 never answers."""

    async def release(self, vehicle_id: str) -> None:
        if vehicle_id == "shuttle-1":
            await asyncio.Event().wait()
        await super().release(vehicle_id)


def test_a_shuttle_that_cannot_be_released_does_not_keep_the_others_waiting() -> None:
    client = UnresponsiveVehicle([incident(1), incident(2)])
    reported: list[str] = []
    operator = DemoOperator(client, reported.append, reported.append, release_timeout_s=0.01)
    for _ in range(2):
        asyncio.run(operator.poll())
    assert client.released == ["shuttle-2"]
    assert any("shuttle-1 could not be released" in line for line in reported)


@pytest.mark.parametrize(
    "changes",
    [
        {"cause": "collision_imminent"},
        {"cause": "bywire_lost, override"},
        {"cause": ""},
        {"cause": "bywire_refuses_enable"},
        {"kind": "takeover"},
        {"acknowledged_at": "2026-09-01T08:00:00Z"},
        {"closed_at": "2026-09-01T08:00:00Z"},
    ],
)
def test_everything_else_is_left_to_people(changes: dict[str, Any]) -> None:
    client = FakeOperator([incident(**changes)])
    assert polled(client, 3) == []
    assert client.released == []

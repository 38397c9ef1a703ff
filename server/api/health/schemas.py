"""What the readiness endpoint says about the server."""

from datetime import datetime
from typing import Literal

from pydantic import BaseModel, ConfigDict

from server.supervision.health import TaskHealth

TaskState = Literal["good", "failing", "late"]


class Health(BaseModel):
    model_config = ConfigDict(json_schema_extra={"example": {"status": "ok"}})

    status: Literal["ok"]


class TaskReadiness(BaseModel):
    """One standing task.

    state         failing: its last attempts failed; late: it hangs
    failures      in a row
    last_good_at  when it last finished its work, null before the first time
    """

    name: str
    state: TaskState
    failures: int
    last_good_at: datetime | None


class Readiness(BaseModel):
    """ready: all of the following is as it should be.

    map_version        of the active campus map, empty if there is none
    database           unavailable: it does not answer; foreign: its tables are another version's
    leaving            it stops and sends its vehicles to other servers
    disk_free_bytes    where the database and the run segments are
    tasks              the server's standing tasks
    """

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "ready": True,
                "map_version": "3f0c9a71d2e84b55",
                "vehicles_connected": 3,
                "leaving": False,
                "database": "good",
                "disk_free_bytes": 52_000_000_000,
                "disk_has_room": True,
                "tasks": [
                    {
                        "name": "dispatcher",
                        "state": "good",
                        "failures": 0,
                        "last_good_at": "2026-09-01T08:00:00Z",
                    }
                ],
            }
        }
    )

    ready: bool
    map_version: str
    vehicles_connected: int
    leaving: bool
    database: Literal["good", "unavailable", "foreign"]
    disk_free_bytes: int
    disk_has_room: bool
    tasks: list[TaskReadiness]


def task_readiness(health: TaskHealth, now: datetime) -> TaskReadiness:
    state: TaskState = "failing" if health.failures else "late" if health.is_late(now) else "good"
    return TaskReadiness(
        name=health.name, state=state, failures=health.failures, last_good_at=health.last_good_at
    )

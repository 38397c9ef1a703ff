"""A straight way to the east with people on it, for the talking room."""

from typing import Any

import msgspec
import numpy as np

from contract.geometry import arc_lengths
from contract.roads.routing import ReferenceLine
from vehicle_agent.signals import PEDESTRIAN, GuardStatus, Path, Task, Tracks, World

TICK_NS = 20_000_000


def line(length_m: float = 120.0) -> ReferenceLine:
    points = np.column_stack((np.arange(length_m + 1.0), np.zeros(round(length_m) + 1)))
    n = len(points)
    return ReferenceLine(
        points, arc_lengths(points), np.zeros(n), np.full(n, 3.0), np.zeros(n, np.int64), ("l",), ()
    )


TASK = Task(
    "drive", line(), 1, 10.0, 0.0, 90.0, "l", 10.0, "o", 1, "v1", "图书馆", "Library", False, (), "", None,
    resumed_ns=1,
)  # fmt: skip
PATH = Path(0, np.empty((0, 2)), np.empty(0), 3.0, "waypoint_speed", None, 80.0, False)


def world(stamp_ns: int, people: list[tuple[float, float, float, float, float]]) -> World:
    """people: x, y, heading, vx, vy, numbered from 1."""
    table = np.array(people).reshape(-1, 5)
    n = len(table)
    tracks = Tracks(
        stamp_ns,
        np.arange(1, n + 1),
        np.full(n, PEDESTRIAN, np.int64),
        np.ascontiguousarray(table[:, :3]),
        np.ascontiguousarray(table[:, 3:]),
        np.full((n, 2), 0.5),
    )
    return World(stamp_ns, stamp_ns, np.empty((0, 2)), (), (), False, tracks)


def task(**changes: Any) -> Task:
    return msgspec.structs.replace(TASK, **changes)


def path(**changes: Any) -> Path:
    return msgspec.structs.replace(PATH, **changes)


def verdict(mode: str = "autonomous") -> GuardStatus:
    return GuardStatus(mode, "", ())  # type: ignore[arg-type]

"""Improving what is planned: requests change places and vehicles; every promise stays a window."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from server.dispatch.arrays import AnyArray
from server.dispatch.engine.plan import ABSENT, total_cost
from server.dispatch.engine.search.optimise import Optimiser, Settings
from server.dispatch.engine.search.partition import Partitioning
from server.dispatch.schedule.part import part_of, put_back
from server.dispatch.schedule.schedule import Schedule

_WORTH_S = 1.0
# A plan in use is good already: what is far from it is not worth a visit.
_HOT, _COLD = 0.1, 0.1
# Routes that are remembered until the end, when the best of them are put together.
_COLUMNS, _VISITS = 2000, 100_000
_PARTITIONING = Partitioning(columns_max=300, nodes_max=20)
# Where nothing is put together there is none to be remembered.
_NO_COLUMNS, _NO_VISITS = 16, 1024


@dataclass(frozen=True, slots=True)
class CoolingSchedule:
    """From hot to cold in so many slices of so many attempts each."""

    slices: int
    attempts: int


def improve(
    schedule: Schedule, cooling: CoolingSchedule, seed: int, most: int, may_continue: Callable[[], bool]
) -> int:
    """Make the board's routes cheaper by `most` slices while `go_on` says so; how many ran.

    Requests that nobody carries are tried again. At the end the best of the routes that were met are put
    together (`engine/search/partition.py`), however many slices ran. The routes stay as they are unless they
    become cheaper by a second at least: people are not told new times for nothing.
    """
    used = np.array(sorted(schedule.rows.values()), dtype=np.int64)
    absent = used[schedule.plan.vehicle_of[used] == ABSENT]
    movable = used[schedule.plan.movable[used]]
    accepting = np.flatnonzero(schedule.accepts)
    if cooling.slices == 0 or not len(movable) or not len(accepting):
        return 0
    if len(movable) == 1 and len(accepting) == 1 and not len(absent):
        return 0
    return _improve_part(schedule, accepting, absent, cooling, seed, most, may_continue, together=True)


def improve_around(schedule: Schedule, v: int, vehicles: int, attempts: int, seed: int) -> None:
    """The same for vehicle v and those whose next stops are nearest to its own: for fleets that are too large
    to be searched as one."""
    accepting = np.flatnonzero(schedule.accepts)
    if vehicles < len(accepting):
        apart = _apart(schedule, v, accepting)
        accepting = np.sort(accepting[np.argsort(apart, kind="stable")[:vehicles]])
    nobody = np.zeros(0, np.int64)
    _improve_part(
        schedule, accepting, nobody, CoolingSchedule(1, attempts), seed, 1, lambda: True, together=False
    )


def _improve_part(
    schedule: Schedule,
    vehicles: AnyArray,
    absent: AnyArray,
    cooling: CoolingSchedule,
    seed: int,
    most: int,
    may_continue: Callable[[], bool],
    together: bool,
) -> int:
    part = part_of(schedule, vehicles, absent)
    if part.task.requests == 0:
        return 0
    settings = Settings(
        attempts=cooling.attempts,
        cycle=cooling.slices + 1,
        hot=_HOT,
        cold=_COLD,
        columns=_COLUMNS if together else _NO_COLUMNS,
        visits=_VISITS if together else _NO_VISITS,
        partitioning=_PARTITIONING,
    )
    search = Optimiser(part.task, seed, settings, start=part.plan)
    while search.slices < most and may_continue():
        search.run_slice()
    if together and search.slices:
        search.put_together()
    if search.cost < float(total_cost(part.task, part.plan)) - _WORTH_S:
        put_back(schedule, part, search.best)
    return search.slices


def _apart(schedule: Schedule, v: int, others: AnyArray) -> AnyArray:
    """(others,) driving between the first visits ahead of each vehicle and those of v; where it stands for
    one without."""
    task, plan = schedule.task, schedule.plan
    first = np.where(plan.length[others] > 2, plan.route[others, 1], plan.route[others, 0])
    mine = int(plan.route[v, 1] if plan.length[v] > 2 else plan.route[v, 0])
    if len(task.travel_s) == 0:
        away: AnyArray = np.linalg.norm(task.xy[task.place[first]] - task.xy[task.place[mine]], axis=1)
        return away
    places = task.travel_s.shape[1]
    target = int(task.place[mine])
    if target >= places:
        target = int(np.argmin(task.travel_s[target]))
    return np.asarray(task.travel_s[task.place[first], target])

"""Makes a plan cheaper: requests change positions and vehicles, and every promise stays a window."""

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
# A plan in use is good already: plans far from it are not worth a search.
_HOT, _COLD = 0.1, 0.1
# Routes that are remembered for the final mix.
_COLUMNS, _VISITS = 2000, 100_000
_PARTITIONING = Partitioning(columns_max=300, nodes_max=20)
# Without a final mix, no route needs to be remembered.
_NO_COLUMNS, _NO_VISITS = 16, 1024


@dataclass(frozen=True, slots=True)
class CoolingSchedule:
    """From hot to cold in so many slices of so many attempts each."""

    slices: int
    attempts: int


def improve(
    schedule: Schedule, cooling: CoolingSchedule, seed: int, most: int, may_continue: Callable[[], bool]
) -> int:
    """Make the routes cheaper by up to `most` slices, while `may_continue` is true. Returns how many ran.

    Requests that no vehicle carries are tried again. At the end the best mix of the routes that were found is
    chosen (`engine/search/partition.py`), however many slices ran. The routes stay unchanged unless they
    become cheaper by a second at least, so that riders do not get new times for a small gain.
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
    """The same for vehicle v and the vehicles with the nearest next stops. For fleets that are too large to
    be searched as a whole."""
    accepting = np.flatnonzero(schedule.accepts)
    if vehicles < len(accepting):
        apart = _apart(schedule, v, accepting)
        accepting = np.sort(accepting[np.argsort(apart, kind="stable")[:vehicles]])
    no_requests = np.zeros(0, np.int64)
    _improve_part(
        schedule, accepting, no_requests, CoolingSchedule(1, attempts), seed, 1, lambda: True, together=False
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
    """(others,) driving between the next visit of each vehicle and that of v. A vehicle without a visit
    counts where it stands."""
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

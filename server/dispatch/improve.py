"""Improving what is planned: requests change places and vehicles; every promise stays a window."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from server.dispatch.board import Board
from server.dispatch.engine.optimise import Optimiser, Settings
from server.dispatch.engine.plan import ABSENT, total_cost

_WORTH_S = 1.0
# A plan in use is good already: what is far from it is not worth a visit.
_HOT = 0.1
# Routes are not put together anew here, so hardly any are remembered.
_COLUMNS, _VISITS = 16, 1024


@dataclass(frozen=True, slots=True)
class Cooling:
    """From hot to cold in so many slices of so many attempts each."""

    slices: int
    attempts: int


def improve(board: Board, cooling: Cooling, seed: int, most: int, go_on: Callable[[], bool]) -> int:
    """Make the board's routes cheaper by `most` slices while `go_on` says so; how many ran.

    Requests that nobody carries are tried again. The routes stay as they are unless they become cheaper by a
    second at least: people are not told new times for nothing.
    """
    used = [board.rows[name] for name in board.rows]
    movable = [r for r in used if board.plan.movable[r]]
    if cooling.slices == 0 or not movable or not board.accepts.any():
        return 0
    absent = [r for r in used if board.plan.vehicle_of[r] == ABSENT]
    if len(movable) == 1 and np.count_nonzero(board.accepts) == 1 and not absent:
        return 0
    settings = Settings(
        attempts=cooling.attempts, cycle=cooling.slices + 1, hot=_HOT, columns=_COLUMNS, visits=_VISITS
    )
    search = Optimiser(board.task, seed, settings, start=board.plan)
    while search.slices < most and go_on():
        search.run_slice()
    if search.cost < float(total_cost(board.task, board.plan)) - _WORTH_S:
        board.adopt(search.best)
    return search.slices

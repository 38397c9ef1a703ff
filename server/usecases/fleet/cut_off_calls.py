"""Which of a vehicle's calls closed roads cut off, and its visits without some riders."""

from collections.abc import Sequence, Set
from dataclasses import replace

import numpy as np

from contract.geometry import Array
from server.dispatch.problem import Call, Problem, VehicleState
from server.domain.planning.plans import PlannedVisit


def cut_off_calls(problem: Problem, vehicle: VehicleState) -> list[Call]:
    """The calls of its route to which no road leads from the call before. Time off needs no road."""
    row: Array = vehicle.to_places_s
    lost = []
    for number, call in enumerate(vehicle.calls):
        if call.off_duty:
            continue
        if number >= vehicle.locked and not np.isfinite(row[call.place]):
            lost.append(call)
        else:
            row = problem.times[call.place]
    return lost


def way_out_s(problem: Problem, vehicle: VehicleState) -> Array:
    """(P,) seconds to every place from where its riders can first be let out: behind the calls that stay."""
    locked = vehicle.calls[: vehicle.locked]
    return problem.times[locked[-1].place] if locked else vehicle.to_places_s


def without_riders(visits: Sequence[PlannedVisit], ride_ids: Set[str]) -> list[PlannedVisit]:
    """The visits without these riders, and without those that were made for them alone."""
    kept = []
    for visit in visits:
        board = tuple(ride_id for ride_id in visit.board if ride_id not in ride_ids)
        alight = tuple(ride_id for ride_id in visit.alight if ride_id not in ride_ids)
        had_riders = bool(visit.board or visit.alight)
        if board or alight or not had_riders or visit.departure_id or visit.state == "under_way":
            kept.append(replace(visit, board=board, alight=alight))
    return kept

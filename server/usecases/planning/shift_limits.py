"""A vehicle's shifts as limits of the dispatcher's problem: beginning, breaks and end."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime, timedelta
from itertools import pairwise
from math import isfinite
from zoneinfo import ZoneInfo

import numpy as np

from server.dispatch.problem import Call, VehicleState
from server.domain.fleet.shifts import Shifts, Span
from server.usecases.ports.unit_of_work import UnitOfWork

# The booking horizon and a long weekend.
_SHIFTS_AHEAD = timedelta(days=11)


def with_shifts(
    uow: UnitOfWork,
    shifts: Shifts,
    state: VehicleState,
    planned: Sequence[datetime],
    until: datetime,
) -> VehicleState:
    """The vehicle with the limits of its shifts that begin by `until`, or by its last call.

    Off duty it gets no calls before its next shift, but it may get rides of later shifts: a call where it
    was last stands for each time off between two shifts. It first finishes with the riders aboard and with
    the calls that were planned before its shift ended.

    planned   when each of its calls is made as planned so far: not before now
    """
    zone = ZoneInfo(uow.network().road_map.timezone)
    # A call that waits for a road to open may be planned months ahead.
    furthest = uow.now + _SHIFTS_AHEAD
    latest = min(max(until, uow.now, *planned), furthest)
    spans = shifts.spans(zone, uow.now, latest) or shifts.spans(zone, uow.now, furthest)[:1]
    if not spans:
        return replace(state, accepts=False)
    begins = spans[0][0]
    if begins > uow.now:
        if state.aboard or state.locked or any(at < begins for at in planned):
            return replace(state, accepts=False)
        state = replace(state, ready_s=max(state.ready_s, begins.timestamp()))
    home_s = uow.roads().way_home_s() * uow.travel_time_factor_at(uow.now)
    return replace(
        state,
        calls=_with_breaks(state, planned, spans, home_s),
        on_duty_to_s=spans[-1][1].timestamp() - home_s,
    )


def _with_breaks(
    state: VehicleState, planned: Sequence[datetime], spans: Sequence[Span], home_s: float
) -> tuple[Call, ...]:
    """The calls with a break wherever a shift ends and another one follows; home_s: the way to rest."""
    made = list(zip(planned, state.calls, strict=True))
    nearest = int(np.argmin(state.to_places_s))
    for number, (before, after) in enumerate(pairwise(spans)):
        begins = after[0]
        at = next((n for n, (planned_at, _) in enumerate(made) if planned_at >= begins), len(made))
        place, drive_s = nearest, float(state.to_places_s[nearest])
        if at:
            place, drive_s = made[at - 1][1].place, 0.0
        # It begins when the shift ends, not when the vehicle arrives, and lasts until the next shift.
        over_s = before[1].timestamp() - home_s
        again_s = begins.timestamp() + (drive_s if isfinite(drive_s) else 0.0)
        off = Call(
            place,
            dwell_s=again_s - over_s,
            leave_from_s=again_s,
            arrive_by_s=over_s,
            fixed=True,
            call_id=f"off-duty-{number}",
            off_duty=True,
        )
        made.insert(at, (begins, off))
    return tuple(call for _, call in made)

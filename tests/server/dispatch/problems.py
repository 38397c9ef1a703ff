"""Small dispatch problems, drawn by hypothesis; distances are Manhattan, so that detours never pay."""

from typing import Any

import numpy as np
from hypothesis import strategies as st

from server.dispatch.problem import Problem, Request, VehicleState

PLACES = 6
FACTORS = st.sampled_from([0.5, 0.9, 1.0, 1.4, 3.0])


def table(points: list[tuple[int, int]]) -> Any:
    xy = np.array(points, dtype=np.float64)
    times: Any = 10.0 * np.abs(xy[:, None, :] - xy[None, :, :]).sum(axis=2)
    return times


@st.composite
def requests(draw: st.DrawFn, name: str, factors: st.SearchStrategy[float]) -> Request:
    pickup = draw(st.integers(0, PLACES - 1))
    dropoff = draw(st.integers(0, PLACES - 1).filter(lambda place: place != pickup))
    opens_s = draw(st.integers(0, 300))
    return Request(
        request_id=name,
        pickup=pickup,
        dropoff=dropoff,
        party=draw(st.integers(1, 4)),
        wheelchairs=draw(st.integers(0, 1)),
        pickup_from_s=float(opens_s),
        pickup_to_s=float(opens_s + draw(st.integers(30, 900))),
        arrive_by_s=float(opens_s + draw(st.integers(300, 2400))),
        ride_s_max=float(draw(st.integers(60, 900))),
        travel_time_factor=draw(factors),
    )


@st.composite
def problems(draw: st.DrawFn, vehicles: int = 2, wanted: int = 4) -> Problem:
    """Empty vehicles and some requests that want one; half of them at hours with factors of their own."""
    factors = draw(st.sampled_from([st.just(1.0), FACTORS]))
    grid = st.tuples(st.integers(0, 8), st.integers(0, 8))
    points = draw(st.lists(grid, min_size=PLACES + vehicles, max_size=PLACES + vehicles))
    times = table(points)
    asked = {f"r{k}": draw(requests(f"r{k}", factors)) for k in range(draw(st.integers(1, wanted)))}
    fleet = tuple(
        VehicleState(
            vehicle_id=f"v{k}",
            to_places_s=times[PLACES + k, :PLACES],
            ready_s=0.0,
            seats=draw(st.integers(2, 6)),
            wheelchair_places=draw(st.integers(0, 1)),
        )
        for k in range(vehicles)
    )
    return Problem(fleet, asked, times[:PLACES, :PLACES], tuple(asked), dwell_s=15.0)

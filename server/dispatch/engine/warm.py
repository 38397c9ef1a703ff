"""Compiles the engine's kernels into numba's cache, so that no decision meets the compiler."""

import numpy as np

from server.dispatch.engine.search.fleet import FleetSearch, FleetSettings
from server.dispatch.engine.search.optimise import Optimiser, Settings
from server.dispatch.engine.task import LOAD_KINDS, Task


def warm_kernels() -> None:
    """Solve a problem of two requests: each kernel is called with the very types that a search gives it."""
    warm_fleet_size()
    warm_search()


def warm_search() -> None:
    """What the dispatcher searches with."""
    settings = Settings(attempts=20, cycle=1, columns=100, visits=1000)
    Optimiser(_two_requests(), 1, settings).run_slice()


def warm_fleet_size() -> None:
    """What a search for as few vehicles as possible needs besides; the dispatcher has no use for it."""
    FleetSearch(_two_requests(), 1, FleetSettings(attempts=20)).run_slice()


def _two_requests() -> Task:
    """Two riders and two vehicles on a straight road; both vehicles start and end at its beginning."""
    requests = vehicles = 2
    nodes = 2 * (requests + vehicles)
    x = np.array([1.0, 3.0, 2.0, 4.0, 0.0, 0.0, 0.0, 0.0])
    load = np.zeros((nodes, LOAD_KINDS), np.int32)
    load[: 2 * requests, 0] = 1, -1, 1, -1
    ride_s_max = np.full(nodes, np.inf)
    ride_s_max[0 : 2 * requests : 2] = 50.0
    ride_s_max[2 * requests :: 2] = 100.0
    return Task(
        place=np.arange(nodes, dtype=np.int32),
        early_s=np.zeros(nodes),
        late_s=np.full(nodes, 100.0),
        service_s=np.zeros(nodes),
        load=load,
        ride_s_max=ride_s_max,
        delay_cost=np.zeros(nodes),
        capacity=np.full((vehicles, LOAD_KINDS), 4, np.int32),
        kind=np.zeros(vehicles, np.int32),
        drive_s_max=np.full(vehicles, np.inf),
        vehicle_cost=np.zeros(vehicles),
        absent_cost=np.full(requests, 16.0),
        travel_s=np.abs(x[:, None] - x[None, :]),
        xy=np.zeros((0, 2)),
        slowness=1.0,
        joined=False,
        travel_time_factor=np.ones(nodes),
    )

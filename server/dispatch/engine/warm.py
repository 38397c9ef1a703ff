"""Compiles the engine's kernels into numba's cache, so that no decision meets the compiler."""

import numpy as np

from server.dispatch.engine.fleet import FleetSearch, FleetSettings
from server.dispatch.engine.from_instance import task_of
from server.dispatch.engine.optimise import Optimiser, Settings
from server.dispatch.instance import Instance


def warm_kernels() -> None:
    """Solve a problem of two requests: each kernel is called with the very types that a search gives it."""
    instance = Instance(
        name="two requests",
        vehicles=2,
        capacity=4,
        duration_max=100.0,
        ride_max=50.0,
        nodes=np.arange(5),
        xy=np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [4.0, 0.0]]),
        service=np.zeros(5),
        load=np.array([0, 1, 1, -1, -1]),
        early=np.zeros(5),
        late=np.full(5, 100.0),
        pairs=np.array([[1, 3], [2, 4]]),
    )
    fleet = FleetSearch(task_of(instance), 1, FleetSettings(attempts=20))
    fleet.run_slice()
    settings = Settings(attempts=20, cycle=1, columns=100, visits=1000)
    Optimiser(fleet.task, 1, settings, start=fleet.best).run_slice()

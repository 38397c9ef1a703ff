"""`campusloop warm`: compile every numba kernel into the cache, so that nothing live meets the compiler."""

import time

import typer

from server.dispatch.bound.warm import warm_kernels as warm_bound
from server.dispatch.warm import warm_kernels as warm_dispatch
from simulator.warm import warm_kernels as warm_simulator
from vehicle_agent.runtime.gate_footprint import warm_footprint
from vehicle_agent.stacks.warm import warm_kernels as warm_vehicle


def warm() -> None:
    """Compile the numerical kernels (set-up does this once)."""
    started = time.perf_counter()
    warm_vehicle()
    warm_footprint()
    warm_simulator()
    warm_dispatch()
    warm_bound()
    typer.echo(f"kernels ready after {time.perf_counter() - started:.1f} s")

"""`campusloop warm`: compile every numba kernel into the cache, so that nothing live meets the compiler."""

import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import typer

from campusloop.studies.bound.warm import warm_kernels as warm_bound
from server.dispatch.warm import warm_kernels as warm_dispatch
from simulator.warm import warm_kernels as warm_simulator
from vehicle_agent.gate.footprint import warm_footprint
from vehicle_agent.stacks.warm import warm_kernels as warm_vehicle


def warm() -> None:
    """Compile the numerical kernels (set-up does this once), in two processes: there are many."""
    started = time.perf_counter()
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        for done in [pool.submit(part) for part in (warm_vehicle, _warm_others)]:
            done.result()
    typer.echo(f"kernels ready after {time.perf_counter() - started:.1f} s")


def _warm_others() -> None:
    """All that no stack's drive calls."""
    warm_dispatch()
    warm_bound()
    warm_simulator()
    warm_footprint()

"""A small campus and short runs, so that a run takes seconds."""

from collections.abc import Callable
from pathlib import Path

import pytest

from campusloop.simulation.service import SimulatedService, SimulationOptions, SimulationResult
from tests.server.usecases.small_campus import small_campus

Run = Callable[..., SimulationResult]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """A run of a campus with two shuttles; each in a folder of its own."""
    runs = 0

    def simulate(*faults: str, seed: int = 1, hours: float = 0.03) -> SimulationResult:
        nonlocal runs
        runs += 1
        folder = tmp_path / str(runs)
        options = SimulationOptions(
            small_campus(), folder, seed, 2, hours, faults, rides_1ph=120.0, settle_s=160.0
        )
        return SimulatedService(options).run()

    return simulate

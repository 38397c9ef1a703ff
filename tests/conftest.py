import gc
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
import structlog
from hypothesis import settings

from campusloop.kernels.caches import KernelCaches
from campusloop.kernels.compiling import PACKAGES
from campusloop.kernels.sources import Sources

ROOT = Path(__file__).resolve().parents[1]

# No test is timed, for its neighbours on the machine would decide it. Examples are the same each time, so
# that a commit is judged alike wherever it is tested; `make soak ARGS=properties` looks for new ones.
settings.register_profile("fixed", deadline=None, derandomize=True)
settings.register_profile("campaign", deadline=None, print_blob=True)
settings.load_profile("campaign" if "CAMPUSLOOP_NEW_EXAMPLES" in os.environ else "fixed")

# Longer than the limit in pyproject.toml: whole rides, real processes and browsers. A test that hangs has to
# end within the time that CI has for all of them.
LONG_LIMIT_S = 1200.0
WITH_LONG_LIMIT = ("long", "faults", "real", "browser")

# Whole vehicles and campuses: begun first, so that no process is left with one of them when the rest is done.
LONGEST = (
    "tests/scenarios/test_rides",
    "tests/scenarios",
    "tests/campusloop/studies/endurance/test_endurance_run",
    "tests/benchmarks",
    "tests/vehicle_agent/stacks",
)


@pytest.fixture(autouse=True)
def own_log() -> Iterator[None]:
    """A command that a test calls sets the log of its process: the next test has the one from before."""
    config = structlog.get_config()
    yield
    structlog.configure(**config)


def pytest_configure(config: pytest.Config) -> None:
    """Once a run: delete the compiled kernels of changed sources, since numba would use them."""
    # Until the tests are collected: imports make no garbage.
    gc.disable()
    if not hasattr(config, "workerinput"):
        KernelCaches(Sources(ROOT, PACKAGES)).missing(())


def pytest_collection_finish() -> None:
    """What was imported stays: a tenth of all time went into looking through it for garbage."""
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)
    gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    def place(item: pytest.Item) -> int:
        return next((k for k, path in enumerate(LONGEST) if item.nodeid.startswith(path)), len(LONGEST))

    items.sort(key=place)
    for item in items:
        if any(item.get_closest_marker(name) for name in WITH_LONG_LIMIT):
            item.add_marker(pytest.mark.timeout(LONG_LIMIT_S))

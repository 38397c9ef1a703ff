"""The machine of `ride_machine`, a few stories of it in every run; `tests.soak` plays it for long."""

import os
from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis.stateful import run_state_machine_as_test
from sqlalchemy import Engine

from server.store.engine import open_engine
from tests.server.usecases.fresh_database import fresh_database
from tests.server.usecases.rides.ride_machine import RideMachine

STORIES = int(os.environ.get("CAMPUSLOOP_STORIES", "0"))


def play(stories: int, new_database: Callable[[], Engine] = fresh_database) -> None:
    class Machine(RideMachine):
        pass

    Machine.new_database = staticmethod(new_database)
    run_state_machine_as_test(
        Machine,
        settings=settings(
            max_examples=STORIES or stories,
            stateful_step_count=20,
            deadline=None,
            derandomize=not STORIES,
            database=None,
            phases=(Phase.generate, Phase.shrink) if STORIES else (Phase.generate,),
            suppress_health_check=list(HealthCheck),
        ),
    )


def test_no_story_loses_a_ride_or_crashes() -> None:
    play(4)


@pytest.mark.real
def test_no_story_loses_a_ride_on_postgresql(new_postgresql: Callable[[], str]) -> None:
    play(2, lambda: open_engine(new_postgresql()))

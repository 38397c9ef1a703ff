"""The machine of `ride_machine`, a few stories of it in every run; `tests.soak` plays it for long."""

import os

from hypothesis import HealthCheck, Phase, settings
from hypothesis.stateful import run_state_machine_as_test
from sqlalchemy import Engine

from tests.server.usecases.ride_machine import RideMachine

STORIES = int(os.environ.get("CAMPUSLOOP_STORIES", "0"))


def play(stories: int, engine: Engine | None = None) -> None:
    class Machine(RideMachine):
        pass

    Machine.engine = engine
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
    play(5)

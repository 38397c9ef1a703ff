"""The fits of the planner's picture of people, on people who were made up."""

import numpy as np
import pytest

from benchmarks.predictions.deviations import HORIZONS_S, Deviations
from benchmarks.predictions.fitting import covered, fitted_pace, fitted_step, paced_m, step_m, within_sigmas
from vehicle_agent.planning.motion.request import SuddenStep

TIMES = np.array(HORIZONS_S)


def some_people(step: SuddenStep, count: int = 4000) -> Deviations:
    """People of whom one in 500 steps aside so, and the others hardly."""
    rng = np.random.default_rng(3)
    speeds = rng.uniform(0.0, 2.0, count)
    aside = 0.05 * rng.standard_normal((count, len(TIMES)))
    aside[:: 500 // 2] = step_m(step, TIMES)
    return Deviations(speeds, paced_m(speeds, 1.2, 4.0), aside)


def test_the_step_that_few_take_is_found_again() -> None:
    step = SuddenStep(1.3, 0.4)
    found = fitted_step(some_people(step))
    assert found.mps == pytest.approx(step.mps, abs=0.02)
    assert found.rise_s == pytest.approx(step.rise_s, abs=0.02)


def test_a_common_pace_is_found_again() -> None:
    assert fitted_pace(some_people(SuddenStep(1.3, 0.4))) == pytest.approx((1.2, 4.0), abs=1e-3)


def test_coverage_counts_only_people_who_are_still_there() -> None:
    people = some_people(SuddenStep(1.3, 0.4))
    people.across_m[:, -1] = np.nan
    people.across_m[0, -1] = 0.0
    assert covered(people, SuddenStep(1.4, 0.4))[-1] == 1.0
    along, across = within_sigmas(people, np.full(len(TIMES), 10.0), 1.0)
    assert along.min() == across[:-1].min() == across[-1] == 1.0

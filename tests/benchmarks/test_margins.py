"""Each allowance that is taken away is one that was there."""

import numpy as np
import pytest

from benchmarks.margins.__main__ import DriveTime, _cost
from benchmarks.margins.allowances import ALLOWANCES, Allowance
from campusloop.scenes.path_map import path_map
from campusloop.scenes.random_crowds import random_curve
from campusloop.scenes.stacks import profile_of
from vehicle_agent.stacks.choice import build_car
from vehicle_agent.stacks.snow_lion import behaviour_rules, motion_params

PROFILE = profile_of("snow_lion")


@pytest.mark.parametrize("allowance", ALLOWANCES, ids=lambda each: each.name)
def test_an_allowance_changes_exactly_one_room(allowance: Allowance) -> None:
    rules, params = behaviour_rules(PROFILE), motion_params(PROFILE)
    curve = random_curve(60.0, np.random.default_rng(1))
    car = build_car(PROFILE, path_map("curve", curve, width_m=4.0, speed_limit_mps=4.0))
    changed = (
        allowance.rules(rules) != rules,
        allowance.motion(params) != params,
        allowance.car(car).guard != car.guard,
        allowance.tracker is not None,
    )
    assert sum(changed) == 1


def test_a_cost_is_the_time_that_would_be_saved() -> None:
    def drive(time_s: float) -> DriveTime:
        return DriveTime(True, 10.0, time_s, True, 0, 0.5)

    assert _cost([(drive(15.0), drive(12.0)), (drive(10.0), drive(11.0))]) == pytest.approx(0.1)
    assert _cost([]) is None

"""Plans among random walkers: never through where they are predicted, in whatever order they pass."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Array
from tests.vehicle_agent.planning.motion.scenes import a_request, people
from vehicle_agent.planning.motion.clearance import box_distance, box_pose
from vehicle_agent.planning.motion.plan import plan_motion
from vehicle_agent.planning.motion.request import Agents, Motion, MotionParams, Vehicle

PARAMS = MotionParams()
BOX = Vehicle().box
NOSE = BOX._replace(rear_m=PARAMS.vehicle.nose_m - BOX.front_m)
_MOVING_MPS = 0.3

walker = st.tuples(st.floats(6.0, 25.0), st.floats(-6.0, 6.0), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))


def gaps_m(motion: Motion, who: Agents) -> Array:
    """(k, a) from the body's nose to each person at each row."""
    found = np.full((len(motion.rows), len(who.ids)), np.inf)
    for i, row in enumerate(motion.rows):
        at = box_pose(np.ascontiguousarray(row[1:4]))
        for a in range(len(who.ids)):
            x, y = (float(np.interp(row[0], who.times_s, who.poses_map[a, :, k])) for k in (0, 1))
            found[i, a] = box_distance(at, NOSE, x, y) - 0.5 * float(who.sizes_m[a, 0])
    return found


@settings(max_examples=60, deadline=None, derandomize=True)
@given(walkers=st.lists(walker, min_size=1, max_size=5), speed_mps=st.floats(0.0, 4.0))
def test_a_plan_never_leads_through_a_predicted_body(
    walkers: list[tuple[float, float, float, float]], speed_mps: float
) -> None:
    who = people(*walkers)
    motion = plan_motion(a_request(speed_mps=speed_mps, agents=who), PARAMS)
    moving = motion.rows[:, 5] > _MOVING_MPS
    if motion.quality == "planned":
        assert motion.violations == ()
        assert gaps_m(motion, who)[moving].min(initial=np.inf) >= 0.0


@settings(max_examples=60, deadline=None, derandomize=True)
@given(walkers=st.lists(walker, min_size=1, max_size=5), speed_mps=st.floats(0.0, 4.0))
def test_nobody_is_both_yielded_to_and_passed_before(
    walkers: list[tuple[float, float, float, float]], speed_mps: float
) -> None:
    motion = plan_motion(a_request(speed_mps=speed_mps, agents=people(*walkers)), PARAMS)
    assert not set(motion.yields_to.tolist()) & set(motion.passes.tolist())


def test_of_two_who_cross_the_first_is_let_go_and_the_second_is_passed_before() -> None:
    """The orders of passing are decided one by one."""
    motion = plan_motion(
        a_request(speed_mps=3.0, agents=people((12.0, -2.0, 0.0, 1.4), (18.0, -9.5, 0.0, 1.2))), PARAMS
    )
    assert motion.quality == "planned"
    assert 0 not in motion.passes.tolist()
    assert 1 in motion.passes.tolist()

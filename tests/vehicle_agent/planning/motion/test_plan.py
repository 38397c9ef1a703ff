"""Whole motions: right, not timid, and never without rows."""

import math

import msgspec
import numpy as np
import pytest

from contract.runlog.arrays import dec_hook, enc_hook
from tests.vehicle_agent.planning.motion.scenes import a_corridor, a_request, people
from vehicle_agent.planning.motion.plan import plan_motion
from vehicle_agent.planning.motion.request import (
    PASS_YIELD,
    Motion,
    MotionParams,
    MotionRequest,
    MotionRequestError,
)

PARAMS = MotionParams()


def planned(request: MotionRequest) -> Motion:
    motion = plan_motion(request, PARAMS)
    assert motion.feasible, motion.violations
    assert len(motion.rows) >= 2
    return motion


def test_a_free_road_is_driven_at_the_limit() -> None:
    motion = planned(a_request())
    assert motion.rows[-1, 5] == pytest.approx(4.17, abs=0.03)
    assert motion.limited_by == "speed_limit"
    # 4.17 m/s at 1 m/s2 and 1.9 m/s3: 8 s are worth 23.6 m at most.
    assert motion.rows[-1, 7] > 22.8


def test_twenty_kilometres_an_hour_come_down_to_the_limit_comfortably() -> None:
    motion = planned(a_request(speed_mps=20.0 / 3.6))
    assert motion.rows[:, 6].min() > -1.0
    assert motion.rows[:, 5].min() > 3.9


def test_a_curve_is_taken_at_its_lateral_acceleration() -> None:
    motion = planned(a_request(a_corridor(1.0 / 12.0), speed_mps=2.0, curvature_1pm=1.0 / 12.0))
    lateral = np.abs(motion.rows[:, 4]) * motion.rows[:, 5] ** 2
    assert 0.7 < lateral.max() <= 0.84
    assert motion.limited_by == "curve"


@pytest.mark.parametrize("ahead_m", [1.0, 3.0, 8.0, 20.0])
def test_it_stops_where_it_must_to_a_few_centimetres(ahead_m: float) -> None:
    request = a_request(end_s_m=ahead_m, speed_mps=min(3.0, 0.3 * ahead_m))
    motion = planned(request)
    assert motion.rows[-1, 7] == pytest.approx(ahead_m, abs=0.1)
    assert motion.rows[-1, 5] < 0.1
    assert motion.limited_by == "stop"


def test_a_crossing_pedestrian_is_let_go_without_stopping() -> None:
    motion = planned(a_request(speed_mps=3.0, agents=people((15.0, -6.0, 0.0, 1.4))))
    assert list(motion.yields_to) == [0]
    assert motion.rows[:, 5].min() > 0.8
    assert motion.rows[-1, 7] > 16.0


def test_who_crosses_long_after_us_is_passed_before_unless_that_is_forbidden() -> None:
    agents = people((16.0, -10.0, 0.0, 1.4))
    free = planned(a_request(speed_mps=4.0, agents=agents))
    assert list(free.passes) == [0]
    must = msgspec.structs.replace(agents, pass_rule=np.array([PASS_YIELD]))
    held = planned(a_request(speed_mps=4.0, agents=must))
    assert list(held.yields_to) == [0]
    assert held.rows[-1, 7] < free.rows[-1, 7] - 3.0


def test_past_somebody_who_stands_beside_the_way_it_goes_slower_but_goes() -> None:
    motion = planned(a_request(speed_mps=3.0, agents=people((15.0, 1.7, 0.0, 0.0))))
    assert motion.limited_by == "pedestrian_clearance"
    assert motion.rows[-1, 7] > 13.5
    assert motion.rows[:, 6].min() > -PARAMS.yield_mps2 - 0.05


def test_it_follows_somebody_who_walks_ahead() -> None:
    motion = planned(a_request(speed_mps=3.0, agents=people((12.0, 0.0, 1.2, 0.0))))
    assert motion.rows[-1, 5] == pytest.approx(1.2, abs=0.2)
    assert 12.0 + 8.0 * 1.2 - motion.rows[-1, 7] - 3.5 < 2.6


def test_a_wall_of_things_ends_the_way_before_it() -> None:
    things = np.array([[20.0, y, 0.3] for y in np.linspace(-3.0, 3.0, 13)])
    motion = planned(a_request(speed_mps=3.0, static_discs=things))
    assert 15.0 < motion.cut_s_m < 16.4
    assert motion.limited_by == "blocked"
    assert motion.rows[-1, 7] < motion.cut_s_m


def test_something_beside_the_middle_is_driven_around() -> None:
    motion = planned(a_request(speed_mps=3.0, static_discs=np.array([[20.0, 0.5, 0.3]])))
    assert motion.rows[-1, 7] > 30.0
    assert motion.cut_s_m == math.inf


def test_somebody_inside_the_outline_means_a_stop() -> None:
    for speed in (0.0, 2.0):
        motion = planned(a_request(speed_mps=speed, agents=people((1.0, 0.0, 0.0, 0.0))))
        assert motion.rows[-1, 5] == 0.0
        assert motion.limited_by == "footprint"


def test_somebody_who_jumps_out_is_braked_for_by_the_named_fallback() -> None:
    motion = planned(a_request(speed_mps=4.0, agents=people((6.5, -1.5, 0.0, 1.4))))
    assert motion.quality == "emergency"
    assert motion.rows[:, 6].min() < -2.0
    assert motion.limited_by == "emergency"


def test_three_metres_off_the_line_it_comes_back() -> None:
    motion = planned(a_request(speed_mps=2.0, pose=(0.0, 3.0, 0.0)))
    assert abs(motion.rows[-1, 2]) < 0.4
    assert motion.quality == "planned"


def test_sixty_degrees_off_it_turns_back_where_there_is_room() -> None:
    motion = planned(a_request(speed_mps=1.0, pose=(0.0, 0.5, math.radians(60.0)), room_m=6.0))
    assert abs(motion.rows[-1, 2]) < 1.5
    assert np.abs(motion.rows[:, 4]).max() <= 0.202


def test_sixty_degrees_off_towards_a_wall_it_stops_and_says_why() -> None:
    motion = planned(a_request(speed_mps=1.0, pose=(0.0, 0.5, math.radians(60.0))))
    assert motion.quality == "stop"
    assert (motion.limited_by, "wall" in motion.replaced) == ("infeasible", True)


def test_a_line_that_doubles_back_is_refused_where_it_does() -> None:
    corridor = a_corridor()
    points = corridor.points_map.copy()
    points[70:, 0] = 2.0 * points[70, 0] - points[70:, 0]
    far = msgspec.structs.replace(corridor, points_map=points)
    motion = planned(a_request(far, speed_mps=3.0))
    assert motion.rows[-1, 7] < 30.0
    points = corridor.points_map.copy()
    points[12:, 0] = 2.0 * points[12, 0] - points[12:, 0]
    near = plan_motion(a_request(msgspec.structs.replace(corridor, points_map=points), speed_mps=1.0), PARAMS)
    assert near.violations == ("line_folds",)
    assert near.rows[-1, 5] == 0.0


def test_heading_across_the_line_it_stops_on_its_steering_arc() -> None:
    motion = plan_motion(a_request(speed_mps=1.0, pose=(0.0, 0.0, 1.5)), PARAMS)
    assert motion.violations == ("off_line",)
    assert motion.rows[-1, 5] == 0.0
    assert motion.rows[:, 6].min() > -1.0


def test_tracks_that_cannot_be_true_slow_the_vehicle_and_stop_nothing_else() -> None:
    agents = people((10.0, 9.0, 1e6, 0.0), (20.0, 9.0, 0.0, 0.0))
    agents.poses_map[1] = np.nan
    motion = planned(a_request(speed_mps=3.0, agents=agents))
    assert motion.limited_by == "implausible_prediction"
    assert motion.rows[-1, 5] == pytest.approx(PARAMS.doubt_mps, abs=0.1)


@pytest.mark.parametrize(
    "broken",
    [
        {"reference_l_m": np.zeros(3)},
        {"speed_mps": math.nan},
        {"static_discs": np.array([[1.0, math.nan, 0.3]])},
        {"end_s_m": math.nan},
        {"upper_l_m": np.full(121, math.nan)},
        {"agents": msgspec.structs.replace(people((1.0, 1.0, 0.0, 0.0)), sizes_m=np.zeros((2, 2)))},
    ],
)
def test_a_request_that_does_not_fit_is_refused(broken: dict[str, object]) -> None:
    with pytest.raises(MotionRequestError):
        plan_motion(a_request(**broken), PARAMS)


def test_an_empty_corridor_is_refused() -> None:
    empty = msgspec.structs.replace(a_corridor(), s_m=np.empty(0), points_map=np.empty((0, 2)))
    with pytest.raises(MotionRequestError, match="no stations"):
        plan_motion(a_request(empty), PARAMS)


def test_one_request_has_one_answer_to_the_last_bit_also_when_sent() -> None:
    agents = people((15.0, -6.0, 0.0, 1.4), (9.0, 2.0, 0.3, -0.2), (20.0, 4.0, -1.0, -0.5))
    first = plan_motion(a_request(speed_mps=3.0, agents=agents), PARAMS)
    request = a_request(speed_mps=3.0, agents=agents, warm=first.path)
    sent = msgspec.msgpack.encode(request, enc_hook=enc_hook)
    again = msgspec.msgpack.decode(sent, type=MotionRequest, dec_hook=dec_hook)
    one, other = plan_motion(request, PARAMS), plan_motion(again, PARAMS)
    assert one.rows.tobytes() == other.rows.tobytes()
    assert msgspec.msgpack.encode(one, enc_hook=enc_hook) == msgspec.msgpack.encode(other, enc_hook=enc_hook)


@pytest.mark.parametrize("as_track", [True, False])
def test_somebody_at_the_rear_bumper_is_left_behind(as_track: bool) -> None:
    """A tracker's noise puts them now and then a centimetre into the outline."""
    x_m = -0.85 - 0.24
    if as_track:
        request = a_request(agents=people((x_m, 0.2, 0.0, 0.0)))
    else:
        request = a_request(static_discs=np.array([[x_m, 0.2, 0.25]]))
    motion = plan_motion(request, PARAMS)
    assert motion.quality == "planned"
    assert motion.rows[-1, 7] > 5.0

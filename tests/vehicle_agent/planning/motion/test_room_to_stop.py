"""Plans leave the guard its room before people, and do not count on them to be late."""

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.vehicle_agent.planning.motion.scenes import a_request, people
from vehicle_agent.planning.motion.agents import early_slots, moving_discs
from vehicle_agent.planning.motion.flanks import CORNER_M
from vehicle_agent.planning.motion.path.path_samples import PathSamples
from vehicle_agent.planning.motion.plan import plan_motion
from vehicle_agent.planning.motion.request import Agents, MotionParams, Vehicle
from vehicle_agent.planning.motion.speed.occupancy import Occupancy, project_agents
from vehicle_agent.planning.motion.speed.room_to_stop import turn_time_s
from vehicle_agent.planning.motion.speed.st_graph import graph
from vehicle_agent.signals import CYCLIST

PARAMS = MotionParams()
FRONT, HALF = Vehicle().box.front_m, Vehicle().box.half_width_m
SLOTS = np.arange(81) * PARAMS.row_s


def occupied(who: Agents) -> tuple[Occupancy, np.ndarray]:
    """On a straight path of 40 m; and the path's ways."""
    u = 0.25 * np.arange(161)
    flat = np.zeros(len(u))
    samples = PathSamples(u, u, np.ones(len(u)), np.column_stack((u, flat, flat)), flat, flat)
    found = project_agents(
        samples,
        moving_discs(who, SLOTS, PARAMS.track_mps_max),
        len(who.ids),
        PARAMS.projection,
    )
    return found, u


@settings(max_examples=40, deadline=None)
@given(gap_m=st.floats(0.4, 2.4), aside_m=st.floats(-0.8, 0.2))
def test_before_somebody_close_the_speed_is_one_from_which_the_vehicle_stops_in_time(
    gap_m: float, aside_m: float
) -> None:
    room = PARAMS.room
    x = FRONT + 0.25 + 10.0
    found, u = occupied(people((x, HALF + 0.25 + aside_m, 0.0, 0.0)))
    j = int(np.searchsorted(u, 10.0 - gap_m))
    v, ahead_m = found.limit_mps[0, j], 10.0 - u[j]
    if ahead_m < 0.0:
        return
    stops_m = room.response_s * v + v**2 / (2.0 * room.decel_mps2)
    assert v <= room.speed_mps_min + 1e-9 or stops_m <= ahead_m - room.ahead_m + 1e-9


def test_who_stands_well_beside_the_way_asks_for_no_room_ahead() -> None:
    near, u = occupied(people((14.0, HALF + 0.25 + 0.1, 0.0, 0.0)))
    far, _ = occupied(people((14.0, HALF + 0.25 + 1.3, 0.0, 0.0)))
    before = int(np.searchsorted(u, 14.0 - FRONT - 0.25 - 1.0))
    assert near.limit_mps[0, before] < 2.0
    assert far.limit_mps[0, before] > 2.0


@pytest.mark.parametrize("aside_m", [0.45, 0.6, 0.8, 0.95])
def test_who_stands_a_step_beside_the_way_cannot_come_before_a_nose_that_still_drives(aside_m: float) -> None:
    """Somebody who begins to walk when the bumper is right before them is met at no more than a creep."""
    room = PARAMS.room
    found, u = occupied(people((14.0, HALF + 0.25 + aside_m, 0.0, 0.0)))
    at = int(np.searchsorted(u, 14.0 - FRONT - 0.25))
    comes_s = turn_time_s(aside_m, 0.0, room.step)
    met_mps = found.limit_mps[0, at] - room.decel_mps2 * max(comes_s - room.late_s, 0.0)
    assert met_mps <= room.speed_mps_min + 1e-9
    assert found.limit_mps[0, at] > room.speed_mps_min, "and passes them faster than those who are close"


def test_who_creeps_past_is_not_kept_from_it() -> None:
    found, _ = occupied(people((14.0, HALF + 0.25 + 0.2, 0.0, 0.0)))
    assert found.limit_mps.min() == pytest.approx(min(PARAMS.room.speed_mps_min, PARAMS.law.speed_mps_min))


def test_it_creeps_until_who_stands_close_beside_the_way_is_behind_its_corner() -> None:
    found, u = occupied(people((14.0, HALF + 0.25 + 0.3, 0.0, 0.0)))
    beside, behind = (int(np.searchsorted(u, 14.0 - FRONT + past_m)) for past_m in (0.2, 0.8))
    assert found.limit_mps[0, beside] == pytest.approx(PARAMS.room.speed_mps_min)
    assert found.limit_mps[0, behind] > 2.0 * PARAMS.room.speed_mps_min


@settings(max_examples=30, deadline=None)
@given(ahead_m=st.floats(-0.2, 0.6))
def test_a_plan_creeps_until_its_corner_has_passed_who_stands_close_beside_the_way(ahead_m: float) -> None:
    """Wherever the path's samples are: between two of them the limit is not that of the next."""
    x_m, creeps_mps = FRONT + ahead_m, PARAMS.room.speed_mps_min
    agents = people((x_m, HALF + 0.25 + 0.3, 0.0, 0.0))
    motion = plan_motion(a_request(speed_mps=creeps_mps, room_m=0.05, agents=agents), PARAMS)
    is_beside = motion.rows[:, 1] + FRONT - CORNER_M < x_m
    assert motion.feasible
    assert motion.rows[is_beside, 5].max() < creeps_mps + 0.05
    assert motion.rows[:, 5].max() > 3.0 * creeps_mps, "and sets off then"


def test_somebody_is_reckoned_with_a_moment_before_they_are_expected() -> None:
    walker = people((12.0, -6.0, 0.0, 1.4))
    found, _ = occupied(walker)
    at = [
        graph(found, walker.pass_rule, 2, early, 0.2, 0.8).low_m[:, 0] <= 1e3
        for early in (np.zeros(1, np.int64), early_slots(walker, PARAMS))
    ]
    plain, sooner = (int(np.flatnonzero(taken)[0]) for taken in at)
    assert (plain - sooner) * 0.2 == pytest.approx(PARAMS.early_s, abs=0.1)
    assert np.flatnonzero(at[0])[-1] == np.flatnonzero(at[1])[-1], "they do not leave sooner"


def test_who_has_just_begun_to_walk_may_come_as_soon_as_others_would() -> None:
    def slots(*walkers: tuple[float, float, float, float], **changes: np.ndarray) -> list[int]:
        return early_slots(msgspec.structs.replace(people(*walkers), **changes), PARAMS).tolist()

    walks, starts, dawdles, stands = (12.0, -2.0, 0.0, 1.4), (0, 0, 0, 0.65), (0, 0, 0.26, 0), (0, 0, 0, 0.1)
    plain = round(PARAMS.early_s / PARAMS.row_s)
    later = [round(PARAMS.start_s * PARAMS.walk_mps / mps / PARAMS.row_s) for mps in (0.65, 0.26)]
    assert slots(walks, starts, dawdles, stands) == [plain, *later, plain]
    assert slots(starts, kinds=np.array([CYCLIST])) == [plain], "only people on foot begin at once"
    assert slots(starts, poses_map=np.full((1, 33, 3), np.nan)) == [plain], "no speed can be told"


def test_nobody_is_passed_before_who_begins_to_walk_into_the_way() -> None:
    """1 m beside the way, 3 m ahead, at a third of the pace they will have: the plan must not speed up."""
    starts = people((FRONT + 3.0, HALF + 0.25 + 1.0, 0.0, -0.4))
    motion = plan_motion(a_request(speed_mps=2.6, agents=starts), PARAMS)
    assert motion.yields_to.tolist() == [0]
    assert motion.rows[:, 5].max() <= 2.6 + 0.05


@pytest.mark.parametrize("aside_m", [0.05, 0.12, 0.2])
def test_somebody_beside_the_way_is_approached_slowly_and_passed(aside_m: float) -> None:
    request = a_request(speed_mps=3.0, room_m=0.05, agents=people((14.0, HALF + 0.25 + aside_m, 0.02, 0.0)))
    motion = plan_motion(request, PARAMS)
    t, x, v = motion.rows[:, 0], motion.rows[:, 1], motion.rows[:, 5]
    ahead_m = 14.0 + 0.02 * t - 0.25 - FRONT - x
    close = (ahead_m > 0.0) & (ahead_m < 1.5) & (v > PARAMS.room.speed_mps_min + 0.15)
    needed_m = PARAMS.room.response_s * v + v**2 / (2.0 * PARAMS.room.decel_mps2) + PARAMS.room.ahead_m
    assert motion.feasible
    assert (needed_m[close] <= ahead_m[close] + 0.15).all()


@settings(max_examples=200, deadline=None)
@given(
    aside_m=st.floats(0.05, 1.0),
    away_mps=st.floats(-2.0, 2.0),
)
def test_who_turns_into_the_way_is_there_when_their_velocity_has_brought_them(
    aside_m: float, away_mps: float
) -> None:
    """The closed form against the motion itself, in small steps; never later than it says."""
    step = PARAMS.room.step
    t, y, v = 0.0, aside_m, max(away_mps, -step.mps)
    while y > 0.0 and t < 20.0:
        y += v * 0.001
        v += (-step.mps - v) / step.rise_s * 0.001
        t += 0.001
    assert turn_time_s(aside_m, away_mps, step) == pytest.approx(t, abs=0.03)


def test_who_walks_away_from_the_way_is_passed_sooner_than_who_stands_or_comes() -> None:
    beside = HALF + 0.25 + 0.5
    at = 40  # 10 m: the bumper is 1 m before them
    x = FRONT + 0.25 + 11.0
    limits = [
        float(occupied(people((x, beside, 0.0, vy)))[0].limit_mps[0, at + 4 : at + 6].min())
        for vy in (1.2, 0.0, -0.6)
    ]
    assert limits[0] > 1.9 * limits[1] > 1.9 * limits[2]


def test_who_still_stands_beside_the_way_needs_more_room_to_stop_than_who_is_in_it() -> None:
    """Their step has to be seen first."""
    room = PARAMS.room
    x, at = FRONT + 0.25 + 10.0, 32  # the bumper is 2 m before them
    inside, beside = (
        float(occupied(people((x, HALF + 0.25 + aside_m, 0.0, 0.0)))[0].limit_mps[0, at])
        for aside_m in (-0.05, 0.3)
    )
    for limit_mps, late_s in ((inside, room.response_s), (beside, room.late_s)):
        stops_m = limit_mps * late_s + limit_mps**2 / (2.0 * room.decel_mps2)
        assert stops_m == pytest.approx(2.0 - room.ahead_m, abs=0.01)


def test_who_stands_but_seems_to_walk_away_is_passed_as_slowly_as_who_stands() -> None:
    """The tracker's error of a velocity may be 0.4 m/s; who walks away at a pace is believed."""
    at, slot = 46, 30  # 3 s from now, the bumper is 1 m past them
    stands, seems, walks = (
        float(occupied(people((FRONT + 0.25 + 10.0, HALF + 0.25 + 0.3, 0.0, vy)))[0].limit_mps[slot, at])
        for vy in (0.0, 0.35, 1.2)
    )
    assert stands < 1.0
    assert seems == pytest.approx(stands)
    assert walks > 4.0


def test_who_is_at_hand_and_hardly_walks_makes_no_room_by_their_velocitys_error() -> None:
    def room_mps(aside_m: float, velocity: tuple[float, float]) -> float:
        found, _ = occupied(people((FRONT + 0.1, HALF + 0.25 + aside_m, *velocity)))
        return float(found.room_mps[0, 0])

    trembles, walks = (0.3, 0.2), (0.9, 0.5)
    assert room_mps(0.3, trembles) == pytest.approx(room_mps(0.3, (0.0, 0.0)))
    assert room_mps(0.3, walks) > 2.0 * room_mps(0.3, trembles)
    assert room_mps(0.7, trembles) > 1.2 * room_mps(0.7, (0.0, 0.0)), "out of reach they are believed"


def test_who_comes_towards_the_vehicle_needs_more_room_to_stop_than_who_stands() -> None:
    x = FRONT + 0.25 + 10.0
    stands, comes = (
        float(occupied(people((x, HALF + 0.25, vx, 0.0)))[0].limit_mps[0, 32]) for vx in (0.0, -1.2)
    )
    assert stands > comes


@settings(max_examples=100, deadline=None)
@given(ahead_m=st.floats(0.5, 2.4), walks_mps=st.floats(0.3, 2.0))
def test_a_vehicle_at_its_limit_stops_behind_a_walker_who_turns_round_and_comes_back(
    ahead_m: float, walks_mps: float
) -> None:
    """The closed form against both motions, in small steps."""
    room, step_s = PARAMS.room, 0.001
    found, _ = occupied(people((FRONT + 0.25 + ahead_m, 0.0, walks_mps, 0.0)))
    speed_mps = float(found.limit_mps[0, 0])
    if speed_mps <= room.speed_mps_min:
        return
    late_s = room.response_s + min(walks_mps / room.step.mps, 1.0) * (room.turn_s - room.response_s)
    t, gap_m, person_mps, vehicle_mps = 0.0, ahead_m, walks_mps, speed_mps
    while vehicle_mps > 0.0:
        gap_m += (person_mps - vehicle_mps) * step_s
        person_mps += (-walks_mps - person_mps) / room.step.rise_s * step_s
        vehicle_mps -= room.decel_mps2 * step_s if t >= late_s else 0.0
        t += step_s
    assert gap_m == pytest.approx(room.ahead_m, abs=0.02) or gap_m > room.ahead_m


def test_who_walks_ahead_is_followed_at_their_pace_with_room_for_a_turn() -> None:
    """At 1.2 m/s: nearer than most cars would, but not at the bumper."""
    gaps_m = [
        gap_m
        for gap_m in np.arange(0.5, 2.4, 0.05)
        if occupied(people((FRONT + 0.25 + gap_m, 0.0, 1.2, 0.0)))[0].limit_mps[0, 0] >= 1.2
    ]
    assert 1.4 < gaps_m[0] < 2.0


def rider(x_m: float, aside_m: float, vx_mps: float, vy_mps: float = 0.0) -> Agents:
    """A cyclist whose rear wheel is x_m before the bumper of a vehicle at the path's beginning."""
    length_m, width_m = 1.8, 0.6
    who = people((FRONT + x_m + 0.5 * length_m, HALF + 0.5 * width_m + aside_m, vx_mps, vy_mps))
    return msgspec.structs.replace(
        who,
        kinds=np.array([CYCLIST]),
        sizes_m=np.array([[length_m, width_m]]),
        inflation_m=0.0 * who.inflation_m,
    )


def limit_of(who: Agents) -> float:
    """What a vehicle at the path's beginning may drive now."""
    return float(occupied(who)[0].limit_mps[0, 0])


def test_who_overtakes_close_by_may_turn_in_and_is_let_go_ahead() -> None:
    limits = [limit_of(rider(ahead_m, 1.0, 6.0)) for ahead_m in (0.0, 1.0, 2.0, 3.5)]
    assert limits == sorted(limits)
    assert limits[0] < 3.5
    assert limits[-1] > 5.0


@settings(max_examples=60, deadline=None)
@given(ahead_m=st.floats(0.3, 4.0), aside_m=st.floats(0.2, 1.0), mps=st.floats(2.0, 8.0))
def test_a_vehicle_at_its_limit_stops_behind_a_rider_who_turns_across_or_is_slow_by_then(
    ahead_m: float, aside_m: float, mps: float
) -> None:
    room, v = PARAMS.rider_room, limit_of(rider(ahead_m, aside_m, mps))
    # Their outline is a row of discs about its corners.
    comes_s = turn_time_s(aside_m - (0.3 * 2.0**0.5 - 0.3), 0.0, room.step)
    along_mps = mps * np.exp(-comes_s / room.step.rise_s)
    stops_m = room.response_s * v + v**2 / (2.0 * room.decel_mps2)
    goes_m = mps * min(0.5 * mps / room.rider_mps2, room.step.rise_s)
    met_mps = v - room.decel_mps2 * max(comes_s - room.late_s, 0.0)
    slow_mps = room.speed_mps_min + along_mps
    assert stops_m <= ahead_m + goes_m - room.ahead_m + 1e-3 or met_mps <= slow_mps + 1e-3


@pytest.mark.parametrize(
    "who",
    [
        rider(1.0, 1.0, -5.0),
        rider(1.0, 1.0, 0.3, 3.0),
        rider(1.0, 1.6, 6.0),
        rider(-4.0, 1.0, 6.0),
        rider(7.0, 1.0, 6.0),
    ],
    ids=["comes towards it", "leaves across", "keeps their distance", "is at the flank", "is far ahead"],
)
def test_other_riders_slow_nothing_down(who: Agents) -> None:
    assert limit_of(who) > 5.0


def test_a_plan_lets_who_overtakes_go_ahead_and_drives_on() -> None:
    close, wide = (
        plan_motion(a_request(speed_mps=4.0, agents=rider(-0.5, aside_m, 5.4)), PARAMS)
        for aside_m in (0.9, 1.8)
    )
    assert close.feasible
    assert wide.feasible
    assert close.rows[:, 5].min() < 3.6, "it eases off"
    assert close.rows[-1, 5] > 3.9
    assert close.quality == "planned"
    assert wide.rows[:, 5].min() > 3.9

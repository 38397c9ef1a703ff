"""Predicted agents as moving discs: what they cover, where they are, and which are believed."""

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.geometry import Array
from vehicle_agent.planning.motion.agents import MovingDiscs, check_agents, early_slots, moving_discs
from vehicle_agent.planning.motion.request import PASS_FREE, Agents, MotionParams, MotionRequestError
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE

TIMES_S = np.array([0.0, 1.0, 2.0])
FASTEST_MPS = 20.0


def an_agent(
    size_m: tuple[float, float],
    kind: int = VEHICLE,
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
    velocity: tuple[float, float] = (0.0, 0.0),
    inflation_m: float = 0.0,
) -> Agents:
    """Predicted for two seconds at its velocity."""
    poses = np.repeat(np.array([[pose]]), len(TIMES_S), axis=1)
    poses[0, :, 0] += velocity[0] * TIMES_S
    poses[0, :, 1] += velocity[1] * TIMES_S
    return Agents(
        np.array([7]),
        np.array([kind]),
        TIMES_S,
        poses,
        np.array([size_m]),
        np.full((1, len(TIMES_S)), inflation_m),
        np.array([PASS_FREE]),
    )


def discs_of(agents: Agents, *at_s: float) -> MovingDiscs:
    return moving_discs(agents, np.array(at_s or (0.0,)), FASTEST_MPS)


def outline(size_m: tuple[float, float], pose: tuple[float, float, float]) -> Array:
    """(n, 2) points along the rectangle, its corners among them."""
    length, width = size_m
    along = np.linspace(-0.5 * length, 0.5 * length, 41)
    across = np.linspace(-0.5 * width, 0.5 * width, 41)
    sides = np.vstack(
        [np.column_stack((along, np.full(41, s * 0.5 * width))) for s in (-1.0, 1.0)]
        + [np.column_stack((np.full(41, s * 0.5 * length), across)) for s in (-1.0, 1.0)]
    )
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    turned: Array = sides @ np.array([[cos, sin], [-sin, cos]]) + np.array(pose[:2])
    return turned


@given(
    length=st.floats(0.5, 6.0),
    width=st.floats(0.4, 2.5),
    x=st.floats(-50.0, 50.0),
    yaw=st.floats(-math.pi, math.pi),
)
def test_the_discs_cover_the_whole_outline_corners_included(
    length: float, width: float, x: float, yaw: float
) -> None:
    pose = (x, 3.0, yaw)
    discs = discs_of(an_agent((length, width), VEHICLE, pose)).discs[0]
    points = outline((length, width), pose)
    away = np.hypot(points[:, None, 0] - discs[None, :, 0], points[:, None, 1] - discs[None, :, 1])
    assert (away - discs[None, :, 2]).min(axis=1).max() <= 1e-9


def test_each_of_several_outlines_is_covered_by_discs_of_its_own_size() -> None:
    sizes = ((6.0, 1.6), (2.0, 1.0), (4.5, 1.8))
    pair = [an_agent(size, VEHICLE, (10.0 * k, 0.0, 0.3)) for k, size in enumerate(sizes)]
    together = msgspec.structs.replace(
        pair[0],
        **{
            name: np.concatenate([getattr(one, name) for one in pair])
            for name in ("ids", "kinds", "poses_map", "sizes_m", "inflation_m", "pass_rule")
        },
    )
    alone = np.concatenate([discs_of(one).discs[0] for one in pair])
    np.testing.assert_allclose(discs_of(together).discs[0], alone)


@pytest.mark.parametrize(("at_s", "along_x"), [(0.4, True), (0.6, False), (1.4, False), (1.6, True)])
def test_between_two_predicted_times_the_heading_is_that_of_the_nearer_one(
    at_s: float, along_x: bool
) -> None:
    turning = an_agent((6.0, 1.6), CYCLIST)
    turning.poses_map[0, 1, 2] = 0.5 * math.pi
    discs = discs_of(turning, at_s).discs[0]
    assert (np.ptp(discs[:, 0]) > np.ptp(discs[:, 1])) == along_x


def test_of_whom_only_the_present_place_is_known_that_place_counts_at_all_times() -> None:
    known = an_agent((4.0, 1.6), pose=(3.0, -2.0, 0.4), velocity=(1.0, 0.0), inflation_m=0.3)
    now_only = msgspec.structs.replace(
        known,
        times_s=known.times_s[:1],
        poses_map=known.poses_map[:, :1],
        inflation_m=known.inflation_m[:, :1],
    )
    moving = discs_of(now_only, 0.0, 1.0, 5.0)
    for discs in moving.discs:
        assert np.array_equal(discs, discs_of(known, 0.0).discs[0])
    assert np.all(moving.inflation_m == 0.3)


def test_beyond_the_last_predicted_time_an_agent_goes_on_and_is_no_more_uncertain() -> None:
    walks = an_agent((0.5, 0.5), PEDESTRIAN, (1.0, 2.0, 0.0), (1.5, -0.5))
    walks.inflation_m[0] = (0.0, 0.2, 0.4)
    moving = discs_of(walks, 1.5, 2.0, 2.5, 6.0)
    np.testing.assert_allclose(moving.discs[:, 0, 0], [3.25, 4.0, 4.75, 10.0], atol=1e-8)
    np.testing.assert_allclose(moving.discs[:, 0, 1], [1.25, 1.0, 0.75, -1.0], atol=1e-8)
    np.testing.assert_allclose(moving.inflation_m[:, 0], [0.3, 0.4, 0.4, 0.4], atol=1e-8)


def test_a_long_vehicle_is_not_given_much_more_room_than_it_takes() -> None:
    discs = discs_of(an_agent((6.0, 1.6), CYCLIST)).discs[0]
    assert len(discs) == 4
    assert discs[:, 2].max() <= 1.15
    assert np.abs(discs[:, 1]).max() == 0.0


@pytest.mark.parametrize(
    ("size_m", "count"), [((1.8, 1.8), 1), ((3.6, 1.8), 2), ((3.7, 1.8), 3), ((40.0, 2.0), 8)]
)
def test_a_long_outline_has_a_disc_for_every_width_and_eight_at_most(
    size_m: tuple[float, float], count: int
) -> None:
    assert len(discs_of(an_agent(size_m)).discs[0]) == count


def test_a_person_is_one_disc_of_their_own_width() -> None:
    discs = discs_of(an_agent((0.6, 0.5), PEDESTRIAN, (1.0, 2.0, 0.3)))
    assert discs.discs[0].tolist() == [[1.0, 2.0, 0.3]]
    assert discs.pedestrian.tolist() == [True]


def test_between_predictions_an_agent_is_between_them_and_after_the_last_it_keeps_its_velocity() -> None:
    walks = an_agent((0.5, 0.5), PEDESTRIAN, velocity=(1.0, -0.5), inflation_m=0.2)
    discs = discs_of(walks, 0.0, 0.25, 1.5, 2.0, 4.0)
    assert discs.discs[:, 0, 0].tolist() == pytest.approx([0.0, 0.25, 1.5, 2.0, 4.0])
    assert discs.discs[:, 0, 1].tolist() == pytest.approx([0.0, -0.125, -0.75, -1.0, -2.0])
    assert discs.inflation_m[:, 0].tolist() == pytest.approx([0.2] * 5)


def test_an_agent_faster_than_anything_stays_where_it_was_first_seen_and_is_named() -> None:
    discs = discs_of(an_agent((4.0, 1.6), VEHICLE, (5.0, 0.0, 0.0), (30.0, 0.0)), 0.0, 2.0)
    assert discs.doubted.tolist() == [7]
    assert np.array_equal(discs.discs[0], discs.discs[1])
    assert discs.discs[0, :, 0].mean() == pytest.approx(5.0)


@pytest.mark.parametrize("spoil", ["place", "size", "empty"])
def test_an_agent_without_a_place_or_a_size_is_left_out_and_named(spoil: str) -> None:
    agents = an_agent((4.0, 1.6))
    if spoil == "place":
        agents.poses_map[0, 0, 1] = math.nan
    else:
        agents.sizes_m[0, 1] = math.nan if spoil == "size" else 0.0
    discs = discs_of(agents)
    assert discs.discs.shape[1] == 0
    assert discs.doubted.tolist() == [7]


def test_a_later_place_that_is_no_number_leaves_the_agent_where_it_is() -> None:
    agents = an_agent((4.0, 1.6), VEHICLE, (5.0, 0.0, 0.0), (2.0, 0.0))
    agents.poses_map[0, 2, 0] = math.nan
    discs = discs_of(agents, 0.0, 1.0)
    assert discs.doubted.tolist() == [7]
    assert np.array_equal(discs.discs[0], discs.discs[1])


def test_arrays_that_do_not_fit_each_other_are_refused_by_their_name() -> None:
    agents = an_agent((4.0, 1.6))
    check_agents(agents)
    with pytest.raises(MotionRequestError, match=r"agents\.kinds"):
        check_agents(msgspec.structs.replace(agents, kinds=np.array([1, 2])))
    with pytest.raises(MotionRequestError, match="rise strictly"):
        check_agents(msgspec.structs.replace(agents, times_s=np.array([0.0, 1.0, 1.0])))


def test_only_a_person_who_has_just_begun_to_walk_is_granted_more_time_to_be_early() -> None:
    params = MotionParams()
    usual = round(params.early_s / params.row_s)
    slow_mps = 0.5 * (params.moving_mps_min + params.walk_mps)

    def slots(kind: int, speed_mps: float) -> int:
        return int(early_slots(an_agent((0.5, 0.5), kind, velocity=(speed_mps, 0.0)), params)[0])

    assert slots(PEDESTRIAN, slow_mps) == round(params.start_s * params.walk_mps / slow_mps / params.row_s)
    assert slots(PEDESTRIAN, 0.0) == slots(PEDESTRIAN, 1.2 * params.walk_mps) == usual
    assert slots(VEHICLE, slow_mps) == usual

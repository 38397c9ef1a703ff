"""Fixes, dead reckoning, outages, jumps: where the vehicle takes itself to be, and how sure it is."""

import math

import msgspec
import numpy as np
import pytest

from contract.geometry import Pose2, compose
from contract.roads.model import Origin
from contract.roads.projection import project, unproject
from vehicle_agent.localization.gnss_ins import GnssInsLocalization, LocalizationState
from vehicle_agent.signals import Ego, GnssFix, ImuSample, VehicleMotion
from vehicle_agent.signals.poor_position import position_limit_mps

ORIGIN = Origin(31.3, 121.4)
TICK_NS = 20_000_000
ROOM = GnssInsLocalization(ORIGIN)


def a_motion(now_ns: int, speed_mps: float = 2.0) -> VehicleMotion:
    return VehicleMotion(now_ns, speed_mps, 0.0, 0.0, 0.0, True, False, True, 1.0)


def a_fix(stamp_ns: int, pose: Pose2, std_m: float = 0.02) -> GnssFix:
    latitude_deg, longitude_deg = unproject(ORIGIN, pose.x_m, pose.y_m)
    return GnssFix(stamp_ns, latitude_deg, longitude_deg, pose.yaw_rad, 2.0, 0.0, std_m)


def driven_east(
    ticks: int, *, fixes: int, noise_m: float = 0.0, late_ns: int = 0
) -> tuple[Ego, LocalizationState, float]:
    """East at 2 m/s; fixes in the first `fixes` ticks only. Returns where it truly is, too."""
    rng = np.random.default_rng(1)
    state, x_m = ROOM.initial(), 0.0
    for k in range(1, ticks + 1):
        now_ns, x_m = k * TICK_NS, 2.0 * k * 0.02
        poses: tuple[GnssFix | ImuSample, ...] = (ImuSample(now_ns, 0.0, 0.0),)
        if k <= fixes:
            dx, dy = rng.standard_normal(2) * noise_m
            seen = Pose2(x_m - 2.0 * late_ns * 1e-9 + dx, dy, 0.0)
            poses += (a_fix(now_ns - late_ns, seen),)
        ego, state = ROOM.step(state, a_motion(now_ns), poses, now_ns)
    return ego, state, x_m


def test_projection_and_its_inverse_agree_to_a_micrometre() -> None:
    for x_m, y_m in ((0.0, 0.0), (1500.0, -900.0), (-2000.0, 2000.0)):
        back = project(ORIGIN, *unproject(ORIGIN, x_m, y_m))
        assert math.hypot(back[0] - x_m, back[1] - y_m) < 1e-6


def test_nothing_is_valid_before_the_first_fix() -> None:
    ego, _ = ROOM.step(ROOM.initial(), a_motion(TICK_NS), (), TICK_NS)
    assert not ego.valid
    assert [fault.code for fault in ego.faults] == ["pose_missing"]


def test_the_pose_is_carried_between_fixes_by_wheel_speed() -> None:
    ego, _, x_m = driven_east(25, fixes=15)
    assert ego.valid
    assert abs(ego.pose_map.x_m - x_m) < 0.01


def test_a_late_fix_is_carried_forward_from_its_own_stamp() -> None:
    ego, _, x_m = driven_east(50, fixes=50, late_ns=100_000_000)
    assert abs(ego.pose_map.x_m - x_m) < 0.01


def test_noise_of_two_centimetres_is_averaged_below_one() -> None:
    errors = []
    for ticks in range(100, 160):
        ego, _, x_m = driven_east(ticks, fixes=ticks, noise_m=0.02)
        errors.append(math.hypot(ego.pose_map.x_m - x_m, ego.pose_map.y_m))
    assert float(np.sqrt(np.mean(np.square(errors)))) < 0.014


def test_an_outage_is_driven_through_as_long_as_the_pose_is_known_well() -> None:
    """Less and less sure of the place, in time slowly, and at last not at all."""
    short, _, x_m = driven_east(1000, fixes=500)
    assert short.valid
    assert abs(short.pose_map.x_m - x_m) < 0.1
    longer, _, _ = driven_east(3000, fixes=500)
    assert short.position_std_m < longer.position_std_m
    assert position_limit_mps(longer.position_std_m) < 1.0
    longest, _, _ = driven_east(4000, fixes=500)
    assert not longest.valid
    assert {"pose_poor", "pose_stale"} & {fault.code for fault in longest.faults}


def test_a_poor_solution_is_not_valid() -> None:
    ego, _ = ROOM.step(ROOM.initial(), a_motion(TICK_NS), (a_fix(TICK_NS, Pose2(0, 0, 0), 3.0),), TICK_NS)
    assert [fault.code for fault in ego.faults] == ["pose_poor"]


def test_one_stray_fix_is_not_believed() -> None:
    ego, state, x_m = driven_east(50, fixes=50)
    now_ns = 51 * TICK_NS
    ego, _ = ROOM.step(state, a_motion(now_ns), (a_fix(now_ns, Pose2(x_m + 30.0, 5.0, 0.0)),), now_ns)
    assert abs(ego.pose_map.x_m - x_m - 0.04) < 0.01
    assert ego.valid


def jumped(
    state: LocalizationState, x_m: float, seconds: float, jump: tuple[float, float]
) -> tuple[Ego, LocalizationState]:
    """East at 2 m/s from x_m on, with fixes that are a jump away."""
    for k in range(1, round(seconds * 50) + 1):
        now_ns = state.stamp_ns + TICK_NS
        fix = a_fix(now_ns, Pose2(x_m + 0.04 * k + jump[0], jump[1], 0.0))
        ego, state = ROOM.step(state, a_motion(now_ns), (ImuSample(now_ns, 0.0, 0.0), fix), now_ns)
    return ego, state


def test_a_jump_of_the_receiver_is_not_followed_and_makes_the_pose_doubtful() -> None:
    _, state, x_m = driven_east(50, fixes=50)
    ego, _ = jumped(state, x_m, 0.9, (30.0, 5.0))
    assert ego.valid
    assert abs(ego.pose_map.y_m) < 0.02
    ego, _ = jumped(state, x_m, 1.2, (0.0, 0.8))
    assert position_limit_mps(ego.position_std_m) < 1.0
    ego, _ = jumped(state, x_m, 1.2, (30.0, 5.0))
    assert not ego.valid


def test_a_lasting_jump_is_followed_and_told_as_a_fault() -> None:
    _, state, x_m = driven_east(50, fixes=50)
    ego, state = jumped(state, x_m, 60.1, (30.0, 5.0))
    assert abs(ego.pose_map.y_m - 5.0) < 0.1
    assert not ego.valid
    assert "pose_jump" in [fault.code for fault in ego.faults]
    ego, _ = jumped(state, x_m + 0.04 * 3005, 2.5, (30.0, 5.0))
    assert ego.valid


def test_fixes_that_wander_far_from_each_other_are_not_followed() -> None:
    _, state, x_m = driven_east(50, fixes=50)
    for k in range(140):
        ego, state = jumped(state, x_m + 0.04 * 25 * k, 0.5, (30.0 + 5.0 * k, 10.0))
    assert abs(ego.pose_map.y_m) < 0.5
    assert not ego.valid


@pytest.mark.long
def test_the_stated_deviation_is_honest() -> None:
    """Receivers wander as they state, gyroscopes have biases, wheels scale errors. After a while and after an
    outage, the error is as large as it is said to be (NEES of the position, 2 degrees of freedom).
    """
    scores = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        scale, bias = rng.normal(0.0, 0.01), rng.normal(0.0, 0.003)
        state, truth, wander = ROOM.initial(), Pose2(0.0, 0.0, 0.0), rng.normal(0.0, 0.09, 2)
        for k in range(1, 3001):
            now_ns, turn_radps = k * TICK_NS, 0.15 * math.sin(k * 0.004)
            truth = compose(truth, Pose2(0.06, 0.0, turn_radps * 0.02))
            keep = math.exp(-0.02 / 30.0)
            wander = keep * wander + math.sqrt(1 - keep**2) * rng.normal(0.0, 0.09, 2)
            gyro = ImuSample(now_ns, 0.0, turn_radps + bias + rng.normal(0.0, 0.003))
            items: tuple[GnssFix | ImuSample, ...] = (gyro,)
            if k < 2500:
                seen = wander + rng.normal(0.0, 0.045, 2)
                heading = truth.yaw_rad + rng.normal(0.0, 0.005)
                items += (a_fix(now_ns, Pose2(truth.x_m + seen[0], truth.y_m + seen[1], heading), 0.1),)
            motion = a_motion(now_ns, 3.0 / (1.0 + scale) + rng.normal(0.0, 0.02))
            ego, state = ROOM.step(state, motion, items, now_ns)
            if k in (1500, 2499, 3000):
                error = np.array((truth.x_m - ego.pose_map.x_m, truth.y_m - ego.pose_map.y_m))
                scores.append(error @ np.linalg.inv(state.covariance[:2, :2]) @ error)
    assert 1.0 < float(np.mean(scores)) < 2.6
    assert float(np.mean(np.array(scores) < 9.21)) > 0.97


@pytest.mark.parametrize("field", ["latitude_deg", "heading_rad", "speed_mps", "yaw_rate_radps"])
def test_values_that_are_no_numbers_are_told_and_never_taken_in(field: str) -> None:
    _, state, x_m = driven_east(50, fixes=50)
    for k in range(51, 101):
        now_ns, x_m = k * TICK_NS, 2.0 * k * 0.02
        fix = a_fix(now_ns, Pose2(x_m, 0.0, 0.0))
        wrong = 55 <= k < 80
        if wrong:
            fix = msgspec.structs.replace(fix, **{field: math.nan})
        inertial = ImuSample(now_ns, 0.0, math.inf if wrong else 0.0)
        ego, state = ROOM.step(state, a_motion(now_ns), (inertial, fix), now_ns)
        if k == 60:
            assert ego.valid
            assert [fault.code for fault in ego.faults] == ["pose_not_finite"]
        if k == 79:
            assert not ego.valid
    assert ego.valid
    assert abs(ego.pose_map.x_m - x_m) < 0.02


def test_one_value_that_is_no_number_stops_no_vehicle_between_buildings() -> None:
    """Without a fix for 2 s, a single sample stopped the vehicle for 2 s more."""
    _, state, _ = driven_east(50, fixes=50)
    for k in range(51, 301):
        now_ns = k * TICK_NS
        inertial = ImuSample(now_ns, 0.0, math.nan if k == 150 else 0.0)
        ego, state = ROOM.step(state, a_motion(now_ns), (inertial,), now_ns)
        assert ego.valid
        if k == 151:
            assert [(fault.code, fault.severity) for fault in ego.faults] == [("pose_not_finite", "warning")]


def test_a_gyroscope_that_goes_on_with_nonsense_between_buildings_stops_the_vehicle() -> None:
    _, state, _ = driven_east(50, fixes=50)
    for k in range(51, 201):
        now_ns = k * TICK_NS
        inertial = ImuSample(now_ns, 0.0, math.nan if 100 <= k < 150 else 0.0)
        ego, state = ROOM.step(state, a_motion(now_ns), (inertial,), now_ns)
        assert ego.valid == (not 116 <= k <= 164)


def test_a_deviation_that_is_no_number_is_a_poor_position_and_stops_the_vehicle() -> None:
    now_ns = TICK_NS
    without_solution = a_fix(now_ns, Pose2(0.0, 0.0, 0.0), math.nan)
    ego, state = ROOM.step(ROOM.initial(), a_motion(now_ns), (without_solution,), now_ns)
    assert not ego.valid
    assert [fault.code for fault in ego.faults] == ["pose_poor"]
    ego, _ = ROOM.step(state, a_motion(2 * now_ns), (a_fix(2 * now_ns, Pose2(0.04, 0.0, 0.0)),), 2 * now_ns)
    assert ego.valid
